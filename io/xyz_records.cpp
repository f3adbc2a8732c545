#include "io/xyz_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/column_names.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::size_t kMaxColumns = kMaxTextColumns;
constexpr std::size_t kSampleLines = 2000;

bool HasCommentMark(std::string_view line) {
  return line.starts_with('#') || line.starts_with("//");
}

char SeparatorOf(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  return line.find(',') != std::string_view::npos ? ',' : ' ';
}

std::vector<std::string> NamesOf(std::string_view line) {
  line = line.substr(std::min(line.size(), line.find_first_not_of("#/ \t")));
  std::vector<std::string_view> words(kMaxColumns);
  words.resize(std::min(kMaxColumns, SplitFields(line, SeparatorOf(line), words)));
  std::vector<std::string> names;
  for (std::string_view word : words) {
    if (word.size() >= 2 && word.front() == '"' && word.back() == '"') {
      word = word.substr(1, word.size() - 2);
    }
    names.emplace_back(word);
  }
  return names;
}

}  // namespace

/// A label in a skipped first column may begin like a comment: a line that holds what the columns
/// say is a record all the same.
bool XyzRecords::IsComment(std::string_view line) const {
  if (!HasCommentMark(line)) return false;
  if (!IsSkipped(0)) return true;
  std::vector<std::string_view> words(kMaxColumns);
  const std::size_t count = SplitFields(line, SeparatorOf(line), words);
  if (count != given_.size()) return true;
  for (std::size_t i = 0; i < count; ++i) {
    if (!IsSkipped(i) && !ParseNumber(words[i])) return true;
  }
  return false;
}

/// Header lines start with a name; a damaged number does not make a line a header. Columns to skip
/// may hold names on every line, so that the first of the others decides.
bool XyzRecords::LooksLikeNames(std::string_view line) const {
  std::size_t place = 0;
  while (IsSkipped(place)) ++place;
  std::vector<std::string_view> words(place + 1);
  if (SplitFields(line, SeparatorOf(line), words) <= place || words[place].empty()) return false;
  const char c = words[place].front();
  if (!(c == '"' || c == '_' || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))) return false;
  return !ParseNumber(words[place]);  // "nan" is a number
}

/// Of several comments the last that names most coordinates; a header line outranks comments.
void XyzRecords::TakeNames(std::string_view line, bool is_header) {
  std::vector<std::string> names = NamesOf(line);
  const bool fewer = CoordinatesNamed(names) < CoordinatesNamed(names_);
  if (!is_header && (names_are_header_ || fewer)) return;
  names_ = std::move(names);
  names_line_ = lines_.line_number();
  names_are_header_ = is_header;
}

bool XyzRecords::SkipPreamble(std::vector<std::string>& notes) {
  std::uint64_t offset = 0;
  std::uint64_t line_number = 0;
  bool had_header = false;
  std::string_view line;
  while (lines_.Next(line)) {
    line = Trim(line);
    if (IsComment(line)) {
      TakeNames(line, false);
    } else if (!line.empty() && !had_header && LooksLikeNames(line)) {
      had_header = true;
      TakeNames(line, true);
      notes.push_back(fmt::format("line {} taken as header", lines_.line_number()));
    } else if (!line.empty()) {
      lines_.Restart(offset, line_number);
      return true;
    }
    offset = lines_.source().position();
    line_number = lines_.line_number();
  }
  return false;
}

bool XyzRecords::NextLine(std::string_view& line) {
  do {
    if (!lines_.Next(line)) return false;
    line = Trim(line);
  } while (line.empty() || IsComment(line));
  return true;
}

std::size_t XyzRecords::CountColumns() {
  const std::uint64_t offset = lines_.source().position();
  const std::uint64_t line_number = lines_.line_number();
  std::string_view line;
  std::vector<std::string_view> words(kMaxColumns);
  const std::size_t count = NextLine(line) ? SplitFields(line, SeparatorOf(line), words) : 0;
  lines_.Restart(offset, line_number);
  return count;
}

void XyzRecords::UseNames(std::size_t columns, std::vector<std::string>& notes) {
  if (names_.size() == columns) given_ = ColumnsByNames(names_);
  if (!given_.empty() || names_.empty()) return;
  // A comment is prose unless it names columns.
  const std::size_t named = CoordinatesNamed(names_);
  const std::size_t needed = names_.size() == columns ? 2 : 3;
  if (!names_are_header_ && named < needed) return;
  const std::string contradiction = ContradictionOf(names_, columns);
  if (!contradiction.empty()) {
    throw InputError({fmt::format("{}:{}", lines_.source().path(), names_line_),
                      fmt::format("the names {}, {}",
                                  Quoted(fmt::format("{}", fmt::join(names_, " "))), contradiction),
                      fmt::format("names of {} columns with x, y and z among them, or easting, "
                                  "northing and height",
                                  columns),
                      "say what the columns hold with the key columns, like columns: [y, x, z, "
                      "skip]"});
  }
  const bool some = named > 0;
  notes.push_back(fmt::format(
      "the names in line {} ({}) {}: the first columns are taken as x, y and z; if they are not, "
      "give columns",
      names_line_, Quoted(fmt::format("{}", fmt::join(names_, " "))),
      some ? "do not name every coordinate" : "mean nothing here"));
}

void XyzRecords::GuessLayout(bool is_pts, std::uint64_t most, std::vector<std::string>& notes) {
  const std::uint64_t offset = lines_.source().position();
  const std::uint64_t line_number = lines_.line_number();
  const bool by_key = !given_.empty();
  if (!by_key && most > 0) UseNames(CountColumns(), notes);
  std::vector<std::vector<double>> sample;
  std::size_t columns = 0;
  try {
    for (std::uint64_t i = 0; i < most && sample.size() < kSampleLines && Next(); ++i) {
      columns = values_.size();
      const bool finite = std::all_of(values_.begin(), values_.end(),
                                      [](double value) { return std::isfinite(value); });
      if (finite) sample.push_back(values_);
    }
  } catch (const InputError&) {
    if (columns == 0) throw;
  }
  if (sample.empty()) {
    sample.emplace_back(std::max<std::size_t>({columns, given_.size(), 3}), 0.0);
  }
  layout_ =
      given_.empty() ? GuessXyzLayout(sample, is_pts) : GivenXyzLayout(given_, sample, is_pts);
  const std::string names = fmt::format("by the names in line {}, ranges ", names_line_);
  notes.push_back(fmt::format("{}, {}by the first {} lines", layout_.Describe(),
                              given_.empty() ? "" : (by_key ? "as given, ranges " : names),
                              sample.size()));
  lines_.Restart(offset, line_number);
}

void XyzRecords::Describe(ScanInfo& info) const {
  info.has_intensity = layout_.HasIntensity();
  info.has_rgb = layout_.HasRgb();
  info.rgb_16_bit = info.has_rgb && layout_.color_scale != ColorScale::k8Bit;
}

bool XyzRecords::Next() {
  std::string_view line;
  if (!NextLine(line)) return false;
  const bool first = values_.empty();
  if (first) {
    separator_ = SeparatorOf(line);
    words_.resize(kMaxColumns);
  }
  const std::size_t count = SplitFields(line, separator_, words_);
  RequireCount(count, line);
  values_.resize(count);
  for (std::size_t i = 0; i < count; ++i) values_[i] = IsSkipped(i) ? 0.0 : Number(words_[i]);
  return true;
}

void XyzRecords::RequireCount(std::size_t count, std::string_view line) const {
  const std::string found = fmt::format("{} values: {}", count, Quoted(line));
  if (!given_.empty()) {
    if (count == given_.size() && count <= kMaxColumns) return;
    throw lines_.Error(found,
                       fmt::format("{} values, as many as columns given or named", given_.size()),
                       "name every column of the file, or skip for what it does not matter");
  }
  const bool first = values_.empty();
  if (count >= 3 && count <= kMaxColumns && (first || count == values_.size())) return;
  throw lines_.Error(found,
                     first ? "x y z and possibly intensity and colour"
                           : fmt::format("{} values, as in the lines before", values_.size()),
                     "the line is damaged, or the file holds several clouds: split or export it "
                     "again");
}

double XyzRecords::Number(std::string_view word) const {
  const std::optional<double> number = ParseNumber(word);
  if (number) return *number;
  const bool comma = word.find(',') != std::string_view::npos ||
                     (separator_ == ',' && word.find(' ') != std::string_view::npos);
  if (comma) {
    throw lines_.Error(Quoted(word), "a number", "write numbers with a decimal point, not a comma");
  }
  const std::string header =
      names_are_header_ ? fmt::format(" (line {} was taken as header)", names_line_) : "";
  throw lines_.Error(Quoted(word) + header, "a number",
                     "the line is damaged or not a point; if a column holds names or other text, "
                     "say so with the key columns, like columns: [skip, x, y, z]");
}

void XyzRecords::Add(PointCollector& collector, PointChunk& chunk) const {
  const auto value = [&](std::size_t column) { return values_[column]; };
  const auto& xyz = layout_.xyz;
  if (!collector.AddPoint(value(xyz[0]), value(xyz[1]), value(xyz[2]), chunk)) return;
  if (layout_.HasIntensity()) collector.AddIntensity(value(layout_.intensity), chunk);
  if (!layout_.HasRgb()) return;
  chunk.rgb.push_back({ScaleColor(value(layout_.rgb[0]), layout_.color_scale),
                       ScaleColor(value(layout_.rgb[1]), layout_.color_scale),
                       ScaleColor(value(layout_.rgb[2]), layout_.color_scale)});
}

}  // namespace backsight
