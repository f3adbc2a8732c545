#include "io/xyz_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/text_fields.h"
#include "io/xyz_layout.h"

namespace backsight {
namespace {

constexpr std::size_t kMaxColumns = 256;
constexpr std::size_t kSampleLines = 2000;

bool IsComment(std::string_view line) { return line.starts_with('#') || line.starts_with("//"); }

char SeparatorOf(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  return line.find(',') != std::string_view::npos ? ',' : ' ';
}

/// Header lines start with a name; a damaged number does not make a line a header.
bool LooksLikeNames(std::string_view line) {
  const char c = line.front();
  if (!(c == '"' || c == '_' || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))) return false;
  std::vector<std::string_view> words(1);
  SplitFields(line, SeparatorOf(line), words);
  return !ParseNumber(words[0]);  // "nan" is a number
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

class XyzReader : public ScanReader {
 public:
  explicit XyzReader(const std::string& path) : source_(path), lines_(source_) {
    info_.path = path;
    info_.format = "XYZ";
    ReadPreamble();
    const std::uint64_t offset = source_.position();
    const std::uint64_t line_number = lines_.line_number();
    GuessLayout();
    lines_.Restart(offset, line_number);
    collector_.Configure(false, layout_.intensity_range);
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (at_end_) return false;
    for (std::size_t i = 0; i < kChunkRecords; ++i) {
      if (!NextRecord()) {
        Close();
        break;
      }
      Add(chunk);
    }
    return true;
  }

 private:
  /// Steps over comments, the header line and the count line, up to the first record.
  void ReadPreamble() {
    std::uint64_t offset = 0;
    std::uint64_t line_number = 0;
    bool had_header = false;
    std::string_view line;
    while (lines_.Next(line)) {
      line = Trim(line);
      if (IsComment(line)) {
        names_ = NamesOf(line);
      } else if (!line.empty() && !had_header && LooksLikeNames(line)) {
        had_header = true;
        names_ = NamesOf(line);
        info_.notes.push_back(fmt::format("line {} taken as header", lines_.line_number()));
      } else if (!line.empty() && !info_.point_count && ParseCount(line)) {
        TakeCount(line);
      } else if (!line.empty()) {
        separator_ = SeparatorOf(line);
        lines_.Restart(offset, line_number);
        return;
      }
      offset = source_.position();
      line_number = lines_.line_number();
    }
    if (info_.point_count == 0U) return;  // a PTS file that honestly says it is empty
    throw lines_.Error("the file ends without a point", "lines 'x y z ...'",
                       "check that this is a point cloud");
  }

  void TakeCount(std::string_view line) {
    // A record needs at least "0 0 0" and a line end.
    const std::uint64_t room = source_.remaining() / 6 + 1;
    const std::uint64_t count = *ParseCount(line);
    if (count > room) {
      throw lines_.Error(fmt::format("{} points declared", count),
                         fmt::format("<= {} points, what the file can hold", room),
                         "the count is wrong or the file is cut short: export it again");
    }
    info_.point_count = count;
    info_.notes.push_back(fmt::format("line {} taken as number of points", lines_.line_number()));
  }

  void GuessLayout() {
    std::vector<std::vector<double>> sample;
    std::size_t columns = 0;
    try {
      while (sample.size() < kSampleLines && NextRecord()) {
        columns = std::max(columns, values_.size());
        const bool finite = std::all_of(values_.begin(), values_.end(),
                                        [](double value) { return std::isfinite(value); });
        if (finite) sample.push_back(values_);
      }
    } catch (const InputError&) {
      // Next() comes to the damaged line again and reports it then, unless it is the first.
      if (columns == 0) throw;
    }
    if (columns == 0) columns = 3;
    if (sample.empty()) sample.emplace_back(columns, 0.0);
    layout_ = GuessXyzLayout(names_, sample, info_.point_count.has_value());
    info_.has_intensity = layout_.HasIntensity();
    info_.has_rgb = layout_.HasRgb();
    info_.notes.push_back(layout_.Describe() + ", by " +
                          fmt::format("the first {} lines", sample.size()));
  }

  /// Puts the next record's numbers into values_; false at the end of the file.
  bool NextRecord() {
    std::string_view line;
    do {
      if (!lines_.Next(line)) return false;
      line = Trim(line);
    } while (line.empty() || IsComment(line));
    const std::size_t count = SplitFields(line, separator_, words_);
    const bool first = values_.empty();
    if (count < 3 || count > kMaxColumns || (!first && count != values_.size())) {
      throw lines_.Error(
          fmt::format("{} values: {}", count, Quoted(line)),
          first ? "x y z and possibly intensity and colour"
                : fmt::format("{} values, as in the lines before", values_.size()),
          "the line is damaged, or the file holds several clouds: split or export it again");
    }
    values_.resize(count);
    for (std::size_t i = 0; i < count; ++i) values_[i] = Number(words_[i]);
    return true;
  }

  double Number(std::string_view word) const {
    const std::optional<double> number = ParseNumber(word);
    if (number) return *number;
    const bool comma = word.find(',') != std::string_view::npos ||
                       (separator_ == ',' && word.find(' ') != std::string_view::npos);
    throw lines_.Error(Quoted(word), "a number",
                       comma ? "write numbers with a decimal point, not a comma"
                             : "the line is damaged or not a point");
  }

  void Add(PointChunk& chunk) {
    const auto value = [&](std::size_t column) { return values_[column]; };
    const auto& xyz = layout_.xyz;
    if (!collector_.AddPoint(value(xyz[0]), value(xyz[1]), value(xyz[2]), chunk)) return;
    if (layout_.HasIntensity()) collector_.AddIntensity(value(layout_.intensity), chunk);
    if (!layout_.HasRgb()) return;
    chunk.rgb.push_back({ScaleColor(value(layout_.rgb[0]), layout_.color_scale),
                         ScaleColor(value(layout_.rgb[1]), layout_.color_scale),
                         ScaleColor(value(layout_.rgb[2]), layout_.color_scale)});
  }

  void Close() {
    at_end_ = true;
    collector_.Finish();
    const std::uint64_t records = collector_.tally().records;
    if (!info_.point_count || records == *info_.point_count) return;
    throw lines_.Error(fmt::format("the file ends after {} points", records),
                       fmt::format("the declared {} points", *info_.point_count),
                       records < *info_.point_count
                           ? "the file is cut short: copy or export it again"
                           : "correct the count in the file's first line or export it again");
  }

  ByteSource source_;
  LineReader lines_;
  ScanInfo info_;
  XyzLayout layout_;
  PointCollector collector_;
  std::vector<std::string> names_;
  char separator_ = ' ';
  std::vector<std::string_view> words_ = std::vector<std::string_view>(kMaxColumns);
  std::vector<double> values_;
  bool at_end_ = false;
};

}  // namespace

std::unique_ptr<ScanReader> OpenXyz(const std::string& path) {
  return std::make_unique<XyzReader>(path);
}

}  // namespace backsight
