#include "io/xyz_lines.h"

#include <fmt/format.h>

#include <optional>

#include "io/line_reader.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

bool HasCommentMark(std::string_view line) {
  return line.starts_with('#') || line.starts_with("//");
}

void AddRecord(const XyzLayout& layout, const std::vector<double>& values, TextBlock& block) {
  const auto& xyz = layout.xyz;
  if (!block.counts.AddPoint(values[xyz[0]], values[xyz[1]], values[xyz[2]], block.points)) return;
  if (layout.HasIntensity()) block.counts.AddIntensity(values[layout.intensity], block.points);
  if (!layout.HasRgb()) return;
  const auto color = [&](std::size_t c) {
    return ScaleColor(values[layout.rgb[c]], layout.color_scale);
  };
  block.points.rgb.push_back({color(0), color(1), color(2)});
}

}  // namespace

char SeparatorOf(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  return line.find(',') != std::string_view::npos ? ',' : ' ';
}

/// A label in a skipped first column may begin like a comment: a line that holds what the columns
/// say is a record all the same.
bool XyzLines::IsComment(std::string_view line) const {
  if (!HasCommentMark(line)) return false;
  if (!IsSkipped(0)) return true;
  std::vector<std::string_view> words(kMaxTextColumns);
  const std::size_t count = SplitFields(line, SeparatorOf(line), words);
  if (count != given_.size()) return true;
  for (std::size_t i = 0; i < count; ++i) {
    if (!IsSkipped(i) && !ParseNumber(words[i])) return true;
  }
  return false;
}

void XyzLines::Read(std::string_view line, std::uint64_t number, std::vector<double>* values) {
  if (columns_ == 0) separator_ = SeparatorOf(line);
  std::vector<std::string_view> words(kMaxTextColumns);
  ReadSettled(line, number, &words, values);
  columns_ = values->size();
}

void XyzLines::Decode(const XyzLayout& layout, TextBlock& block) const {
  block.points.Clear();
  std::vector<std::string_view> words(kMaxTextColumns);
  std::vector<double> values(columns_);
  std::vector<char> is_skipped;
  for (std::size_t i = 0; i < given_.size(); ++i) is_skipped.push_back(IsSkipped(i) ? 1 : 0);
  const char* at = block.text.data();
  const char* const end = at + block.text.size();
  for (std::size_t i = 0; i < block.lines; ++i) {
    const char* const begin = at;
    if (!TakePlainLine(at, separator_, is_skipped, values)) {
      at = begin;
      const std::string_view line = Trim(TakeLine(at, end));
      if (line.empty() || IsComment(line)) continue;
      ReadSettled(line, block.lines_before + i + 1, &words, &values);
    }
    AddRecord(layout, values, block);
  }
}

void XyzLines::ReadSettled(std::string_view line, std::uint64_t number,
                           std::vector<std::string_view>* words,
                           std::vector<double>* values) const {
  const std::size_t count = SplitFields(line, separator_, *words);
  RequireCount(count, line, number);
  values->resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    (*values)[i] = IsSkipped(i) ? 0.0 : Number((*words)[i], number);
  }
}

void XyzLines::RequireCount(std::size_t count, std::string_view line, std::uint64_t number) const {
  const bool first = columns_ == 0;
  const bool is_fit =
      given_.empty() ? count >= 3 && (first || count == columns_) : count == given_.size();
  if (is_fit && count <= kMaxTextColumns) return;
  const std::string found = fmt::format("{} values: {}", count, Quoted(line));
  if (!given_.empty()) {
    throw ErrorInLine(path_, number, found,
                      fmt::format("{} values, as many as columns given or named", given_.size()),
                      "name every column of the file, or skip for what it does not matter");
  }
  throw ErrorInLine(path_, number, found,
                    first ? "x y z and possibly intensity and colour"
                          : fmt::format("{} values, as in the lines before", columns_),
                    "the line is damaged, or the file holds several clouds: split or export it "
                    "again");
}

double XyzLines::Number(std::string_view word, std::uint64_t number) const {
  const std::optional<double> value = ParseNumber(word);
  if (value) return *value;
  const bool comma = word.find(',') != std::string_view::npos ||
                     (separator_ == ',' && word.find(' ') != std::string_view::npos);
  if (comma) {
    throw ErrorInLine(path_, number, Quoted(word), "a number",
                      "write numbers with a decimal point, not a comma");
  }
  const std::string header =
      header_line_ > 0 ? fmt::format(" (line {} was taken as header)", header_line_) : "";
  throw ErrorInLine(path_, number, Quoted(word) + header, "a number",
                    "the line is damaged or not a point; if a column holds names or other text, "
                    "say so with the key columns, like columns: [skip, x, y, z]");
}

}  // namespace backsight
