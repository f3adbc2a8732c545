#include "io/text_block.h"

#include <cstring>

#include "io/plain_number.h"

namespace backsight {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

void SkipBlanks(const char*& at) {
  while (IsBlank(*at)) ++at;
}

/// Goes behind what parts two values; false if that is not all that stands there.
bool TakeSeparator(const char*& at, char separator) {
  const bool had_blank = IsBlank(*at);
  SkipBlanks(at);
  if (separator == ' ') return had_blank;
  if (*at != separator) return false;
  ++at;
  SkipBlanks(at);
  return true;
}

void SkipValue(const char*& at, char separator) {
  while (*at != '\n' && *at != separator && !(separator == ' ' && IsBlank(*at))) ++at;
}

}  // namespace

std::string_view TakeLine(const char*& at, const char* end) {
  const auto room = static_cast<std::size_t>(end - at);
  const void* const found = std::memchr(at, '\n', room);
  const char* const stop = found == nullptr ? end : static_cast<const char*>(found);
  std::string_view line(at, static_cast<std::size_t>(stop - at));
  if (line.ends_with('\r')) line.remove_suffix(1);
  at = found == nullptr ? end : stop + 1;
  return line;
}

bool TakePlainLine(const char*& at, char separator, std::span<const char> is_skipped,
                   std::span<double> values) {
  SkipBlanks(at);
  if (*at == '#' || *at == '/') return false;  // may be a comment
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0 && !TakeSeparator(at, separator)) return false;
    if (!is_skipped.empty() && is_skipped[i] != 0) {
      if (*at == '\n') return false;
      SkipValue(at, separator);
      values[i] = 0.0;
    } else {
      const std::optional<double> number = TakePlainNumber(at);
      if (!number) return false;
      values[i] = *number;
    }
  }
  SkipBlanks(at);
  if (*at != '\n') return false;
  ++at;
  return true;
}

}  // namespace backsight
