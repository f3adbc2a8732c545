#include "io/text_fields.h"

#include <fmt/format.h>

#include <charconv>

namespace backsight {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::size_t SplitBlanks(std::string_view line, std::span<std::string_view> fields) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < line.size();) {
    while (i < line.size() && IsBlank(line[i])) ++i;
    const std::size_t start = i;
    while (i < line.size() && !IsBlank(line[i])) ++i;
    if (i == start) break;
    if (count < fields.size()) fields[count] = line.substr(start, i - start);
    ++count;
  }
  return count;
}

template <typename T>
std::optional<T> ParseWhole(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);  // from_chars knows no plus sign
  if (text.starts_with('+') || text.empty()) return std::nullopt;
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

}  // namespace

std::size_t SplitFields(std::string_view line, char separator, std::span<std::string_view> fields) {
  if (separator == ' ') return SplitBlanks(line, fields);
  std::size_t count = 0;
  while (true) {
    const std::size_t end = line.find(separator);
    const std::string_view field = Trim(line.substr(0, end));
    if (end == std::string_view::npos && field.empty()) break;
    if (count < fields.size()) fields[count] = field;
    ++count;
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  return count;
}

std::optional<double> ParseNumber(std::string_view text) { return ParseWhole<double>(text); }

std::optional<std::uint64_t> ParseCount(std::string_view text) {
  return ParseWhole<std::uint64_t>(text);
}

std::string_view Trim(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string ToLower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string Quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string quoted = "'";
  for (const char c : text.substr(0, kShown)) {
    if (c >= ' ' && c <= '~') {
      quoted += c;
    } else {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return quoted + (text.size() > kShown ? "...'" : "'");
}

}  // namespace backsight
