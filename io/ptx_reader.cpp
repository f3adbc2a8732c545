#include "io/ptx_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "io/block_reader.h"
#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/text_block.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::uint64_t kMaxGridSide = 10'000'000;
constexpr std::size_t kHeaderLines = 10;
constexpr const char* kRemedy = "the PTX file is damaged: export it again";

struct PtxHeader {
  int columns = 0;
  int rows = 0;
  Eigen::Matrix4d world_from_scan = Eigen::Matrix4d::Identity();

  std::uint64_t Cells() const {
    return static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows);
  }
};

/// A scan's place in the file: its first record.
struct ScanPlace {
  PtxHeader header;
  std::uint64_t offset = 0;
  std::uint64_t lines_before = 0;
};

/// As many numbers as there are `numbers`, and nothing else.
bool FindNumbers(std::string_view line, std::span<double> numbers) {
  std::array<std::string_view, 7> words;
  if (SplitFields(line, ' ', words) != numbers.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = ParseNumber(words[i]);
    if (!number) return false;
    numbers[i] = *number;
  }
  return true;
}

template <std::size_t N>
std::array<double, N> NumbersOf(LineReader& lines, std::string_view line,
                                std::string_view expected) {
  std::array<double, N> numbers{};
  if (FindNumbers(line, numbers)) return numbers;
  throw lines.Error(Quoted(line), std::string(expected), kRemedy);
}

int GridSide(LineReader& lines, std::string_view line, std::string_view name) {
  const std::optional<std::uint64_t> side = ParseCount(Trim(line));
  if (!side || *side == 0 || *side > kMaxGridSide) {
    throw lines.Error(Quoted(line), fmt::format("the number of {}, 1 to {}", name, kMaxGridSide),
                      kRemedy);
  }
  return static_cast<int>(*side);
}

/// Reads a scan's header; `first` is its first line, already taken.
PtxHeader ReadHeader(LineReader& lines, std::string_view first) {
  PtxHeader header;
  header.columns = GridSide(lines, first, "columns");
  header.rows = GridSide(lines, lines.Require("the number of rows"), "rows");
  // Scanner position and axes say the same as the matrix below.
  for (int i = 0; i < 4; ++i) {
    const std::string expected = i == 0 ? "the scanner position, 3 numbers" : "an axis, 3 numbers";
    NumbersOf<3>(lines, lines.Require(expected), expected);
  }
  for (int i = 0; i < 4; ++i) {
    const std::string expected = fmt::format("row {} of the matrix, 4 numbers", i + 1);
    const auto row = NumbersOf<4>(lines, lines.Require(expected), expected);
    // The file holds the transposed matrix: the translation is its last row.
    for (int j = 0; j < 4; ++j) header.world_from_scan(j, i) = row[static_cast<std::size_t>(j)];
  }
  return header;
}

/// The next line that is not blank, or nothing at the end of the file.
std::optional<std::string_view> NextFilled(LineReader& lines) {
  std::string_view line;
  while (lines.Next(line)) {
    if (!Trim(line).empty()) return line;
  }
  return std::nullopt;
}

/// The pose, if the matrix is one; PTX files with scaled axes exist.
std::optional<RigidTransform> PoseOf(const Eigen::Matrix4d& matrix) {
  constexpr double kTolerance = 1e-3;  // headers carry as few as four decimals
  if (!matrix.allFinite()) return std::nullopt;
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  const Eigen::RowVector4d last_row(0.0, 0.0, 0.0, 1.0);
  if (error > kTolerance || rotation.determinant() < 0.0 || matrix.row(3) != last_row) {
    return std::nullopt;
  }
  return RigidTransform::FromMatrix(matrix);
}

class PtxReader : public BlockReader<TextBlock> {
 public:
  PtxReader(const std::string& path, int scan_index, const std::function<void()>& between)
      : source_(path), lines_(source_) {
    info_.path = path;
    info_.format = "PTX";
    info_.scan_index = scan_index;
    FindScans(scan_index, between);
    FillInfo();
    lines_.Restart(place_.offset, place_.lines_before);
    ReadFirstRecord();
    collector_.Configure(true, IntensityRange{0.0, 1.0});
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

 private:
  /// Steps through the file from header to header. Damage behind the wanted scan is only noted:
  /// it must not cost the scans before it.
  void FindScans(int wanted, const std::function<void()>& between) {
    bool found = false;
    info_.scan_count = 0;
    try {
      while (const std::optional<std::string_view> first = NextFilled(lines_)) {
        ScanPlace place;
        place.header = ReadHeader(lines_, *first);
        place.offset = source_.position();
        place.lines_before = lines_.line_number();
        SkipRecords(place, between);
        if (info_.scan_count++ != wanted) continue;
        place_ = place;
        found = true;
      }
    } catch (const InputError& error) {
      if (!found) throw;
      info_.notes.push_back(fmt::format("the file is damaged behind this scan: {}", error.what()));
    }
    if (found) return;
    if (info_.scan_count == 0) {
      throw InputError({info_.path, "no PTX header", "the number of columns in the first line",
                        "check that this is a PTX file"});
    }
    throw InputError({info_.path, fmt::format("no scan with index {}", wanted),
                      fmt::format("a scan_index from 0 to {}", info_.scan_count - 1),
                      "correct scan_index"});
  }

  void SkipRecords(const ScanPlace& place, const std::function<void()>& between) {
    const std::uint64_t cells = place.header.Cells();
    const std::uint64_t skipped = lines_.Skip(cells, between);
    if (skipped == cells) return;
    throw lines_.Error(
        fmt::format("the file ends after {} records", skipped),
        fmt::format("{} records ({} columns * {} rows, declared in line {})", cells,
                    place.header.columns, place.header.rows, place.lines_before + 1 - kHeaderLines),
        "the file is cut short: copy or export it again");
  }

  void FillInfo() {
    info_.point_count = place_.header.Cells();
    info_.has_intensity = true;
    info_.columns = place_.header.columns;
    info_.rows = place_.header.rows;
    info_.world_from_scan = PoseOf(place_.header.world_from_scan);
    if (!info_.world_from_scan) {
      info_.notes.emplace_back("the matrix of the header is no rigid motion: ignored");
    }
  }

  /// The first record tells whether the scan has colours.
  void ReadFirstRecord() {
    std::array<std::string_view, 7> words;
    const std::string_view line = lines_.Require("the first record");
    const std::size_t count = SplitFields(line, ' ', words);
    if (count != 4 && count != 7) {
      throw lines_.Error(fmt::format("{} values: {}", count, Quoted(line)),
                         "x y z intensity or x y z intensity r g b", kRemedy);
    }
    info_.has_rgb = count == 7;
    lines_.Restart(place_.offset, place_.lines_before);
  }

  bool Take(TextBlock& block) override {
    const std::uint64_t cells = place_.header.Cells();
    if (done_ == cells) return false;
    block.lines_before = lines_.line_number();
    block.first_record = done_;
    block.lines = lines_.Take(std::min<std::uint64_t>(kChunkRecords, cells - done_), block.text);
    if (block.lines == 0) lines_.Require("a record for each grid cell");
    done_ += block.lines;
    block.is_last = done_ == cells;
    return true;
  }

  void Decode(TextBlock& block) const override {
    block.points.Clear();
    block.counts = collector_.ForPart();
    const char* at = block.text.data();
    const char* const end = at + block.text.size();
    std::array<double, 7> numbers{};
    const std::span<double> record(numbers.data(), info_.has_rgb ? 7 : 4);
    for (std::size_t i = 0; i < block.lines; ++i) {
      const char* const begin = at;
      if (!TakePlainLine(at, ' ', {}, record)) {
        at = begin;
        ReadRecord(TakeLine(at, end), block.lines_before + i + 1, record);
      }
      const std::size_t points = block.points.size();
      AddRecord(record, block);
      if (block.points.size() > points) AddCell(block.first_record + i, block);
    }
  }

  void Count(TextBlock& block) override {
    collector_.Add(block.counts);
    if (block.is_last) collector_.Finish();
  }

  /// Any line that may be a record; InputError if it is none.
  void ReadRecord(std::string_view line, std::uint64_t number, std::span<double> record) const {
    if (FindNumbers(line, record)) return;
    throw ErrorInLine(
        info_.path, number, Quoted(line),
        info_.has_rgb ? "7 numbers: x y z intensity r g b" : "4 numbers: x y z intensity", kRemedy);
  }

  static void AddRecord(std::span<const double> v, TextBlock& block) {
    if (!block.counts.AddPoint(v[0], v[1], v[2], block.points)) return;
    block.counts.AddIntensity(v[3], block.points);
    if (v.size() == 4) return;
    block.points.rgb.push_back({ScaleColor(v[4], ColorScale::k8Bit),
                                ScaleColor(v[5], ColorScale::k8Bit),
                                ScaleColor(v[6], ColorScale::k8Bit)});
  }

  /// Records go up a column, then to the next.
  void AddCell(std::uint64_t record, TextBlock& block) const {
    const auto rows = static_cast<std::uint64_t>(place_.header.rows);
    const std::uint64_t row = record % rows;
    const std::uint64_t column = record / rows;
    block.counts.AddCell(static_cast<double>(row), static_cast<double>(column), info_,
                         block.points);
  }

  ByteSource source_;
  LineReader lines_;
  ScanInfo info_;
  ScanPlace place_;
  PointCollector collector_;
  std::uint64_t done_ = 0;  // records taken from the file
};

}  // namespace

std::unique_ptr<ScanReader> OpenPtx(const std::string& path, int scan_index,
                                    const std::function<void()>& between) {
  return std::make_unique<PtxReader>(path, scan_index, between);
}

}  // namespace backsight
