#include "io/xyz_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/column_names.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::size_t kSampleLines = 2000;

std::vector<std::string> NamesOf(std::string_view line) {
  line = line.substr(std::min(line.size(), line.find_first_not_of("#/ \t")));
  std::vector<std::string_view> words(kMaxTextColumns);
  words.resize(std::min(kMaxTextColumns, SplitFields(line, SeparatorOf(line), words)));
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

/// Header lines start with a name; a damaged number does not make a line a header. Columns to skip
/// may hold names on every line, so that the first of the others decides.
bool XyzRecords::LooksLikeNames(std::string_view line) const {
  std::size_t place = 0;
  while (rule_.IsSkipped(place)) ++place;
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
  if (is_header) rule_.SetHeader(names_line_);
}

bool XyzRecords::SkipPreamble(std::vector<std::string>& notes) {
  std::uint64_t offset = 0;
  std::uint64_t line_number = 0;
  bool had_header = false;
  std::string_view line;
  while (lines_.Next(line)) {
    line = Trim(line);
    if (rule_.IsComment(line)) {
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
  } while (line.empty() || rule_.IsComment(line));
  return true;
}

std::size_t XyzRecords::CountColumns() {
  const std::uint64_t offset = lines_.source().position();
  const std::uint64_t line_number = lines_.line_number();
  std::string_view line;
  std::vector<std::string_view> words(kMaxTextColumns);
  const std::size_t count = NextLine(line) ? SplitFields(line, SeparatorOf(line), words) : 0;
  lines_.Restart(offset, line_number);
  return count;
}

void XyzRecords::UseNames(std::size_t columns, std::vector<std::string>& notes) {
  if (names_.size() == columns) rule_.UseColumns(ColumnsByNames(names_));
  if (!rule_.given().empty() || names_.empty()) return;
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
  const bool by_key = !rule_.given().empty();
  if (!by_key && most > 0) UseNames(CountColumns(), notes);
  const std::vector<std::vector<double>> sample = TakeSample(most);
  const TextColumns& given = rule_.given();
  layout_ = given.empty() ? GuessXyzLayout(sample, is_pts) : GivenXyzLayout(given, sample, is_pts);
  const std::string names = fmt::format("by the names in line {}, ranges ", names_line_);
  notes.push_back(fmt::format("{}, {}by the first {} lines", layout_.Describe(),
                              given.empty() ? "" : (by_key ? "as given, ranges " : names),
                              sample.size()));
  lines_.Restart(offset, line_number);
}

std::vector<std::vector<double>> XyzRecords::TakeSample(std::uint64_t most) {
  std::vector<std::vector<double>> sample;
  std::vector<double> values;
  std::size_t columns = 0;
  try {
    std::string_view line;
    for (std::uint64_t i = 0; i < most && sample.size() < kSampleLines && NextLine(line); ++i) {
      rule_.Read(line, lines_.line_number(), &values);
      columns = values.size();
      const bool finite = std::all_of(values.begin(), values.end(),
                                      [](double value) { return std::isfinite(value); });
      if (finite) sample.push_back(values);
    }
  } catch (const InputError&) {
    if (columns == 0) throw;
  }
  if (sample.empty()) {
    sample.emplace_back(std::max<std::size_t>({columns, rule_.given().size(), 3}), 0.0);
  }
  return sample;
}

void XyzRecords::Describe(ScanInfo& info) const {
  info.has_intensity = layout_.HasIntensity();
  info.has_rgb = layout_.HasRgb();
  info.rgb_16_bit = info.has_rgb && layout_.color_scale != ColorScale::k8Bit;
}

bool XyzRecords::Take(std::size_t most, TextBlock& block) {
  block.lines_before = lines_.line_number();
  block.lines = lines_.Take(most, block.text);
  return block.lines > 0;
}

}  // namespace backsight
