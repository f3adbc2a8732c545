#include "io/pts_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "io/block_reader.h"
#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/text_fields.h"
#include "io/xyz_records.h"

namespace backsight {
namespace {

/// A scan's place in the file: its first record.
struct PtsScan {
  std::uint64_t points = 0;
  std::uint64_t offset = 0;
  std::uint64_t lines_before = 0;
  std::uint64_t last_line = 0;  // that of the last record
};

class PtsReader : public BlockReader<TextBlock> {
 public:
  PtsReader(const std::string& path, int scan_index, const TextColumns& columns)
      : source_(path), lines_(source_), records_(lines_, columns) {
    info_.path = path;
    info_.format = "PTS";
    info_.scan_index = scan_index;
    FindScans(scan_index);
    info_.point_count = scan_.points;
    lines_.Restart(scan_.offset, scan_.lines_before);
    records_.GuessLayout(true, scan_.points, info_.notes);
    records_.Describe(info_);
    collector_.Configure(false, records_.layout().intensity_range);
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

 private:
  /// Comments may stand between the records, so that lines tell where the scan ends.
  bool Take(TextBlock& block) override {
    if (lines_.line_number() >= scan_.last_line) return false;
    const std::uint64_t left = scan_.last_line - lines_.line_number();
    if (!records_.Take(std::min<std::uint64_t>(kChunkRecords, left), block)) {
      throw Truncated(scan_, lines_.line_number() - scan_.lines_before);
    }
    block.is_last = lines_.line_number() == scan_.last_line;
    return true;
  }

  void Decode(TextBlock& block) const override {
    block.counts = collector_.ForPart();
    records_.Decode(block);
  }

  void Count(TextBlock& block) override {
    collector_.Add(block.counts);
    if (!block.is_last) return;
    collector_.Finish();
    const std::uint64_t records = tally().records;
    if (records == scan_.points) return;
    throw ErrorInLine(
        info_.path, scan_.last_line, fmt::format("{} points up to here", records),
        fmt::format("the declared {} points (line {})", scan_.points, scan_.lines_before),
        "export the file again, without marks of comments before its records");
  }

  void FindScans(int wanted) {
    info_.scan_count = 0;
    records_.SkipPreamble(info_.notes);
    try {
      while (const std::optional<PtsScan> scan = NextScan()) {
        if (info_.scan_count++ == wanted) scan_ = *scan;
      }
    } catch (const InputError& error) {
      const bool found = info_.scan_count > wanted && wanted >= 0;
      if (!found || (count_missing_ && info_.scan_count == wanted + 1)) throw;
      info_.notes.push_back(fmt::format("the file is damaged behind this scan: {}", error.what()));
    }
    if (wanted >= 0 && wanted < info_.scan_count) return;
    throw InputError({info_.path, fmt::format("no scan with index {}", wanted),
                      fmt::format("a scan_index from 0 to {}", info_.scan_count - 1),
                      "correct scan_index"});
  }

  /// Takes a scan's count and steps over its records; nothing at the end of the file.
  std::optional<PtsScan> NextScan() {
    std::string_view line;
    if (!records_.NextLine(line)) return std::nullopt;
    const std::optional<std::uint64_t> count = ParseCount(line);
    count_missing_ = !count;
    if (!count) {
      throw lines_.Error(Quoted(line),
                         info_.scan_count == 0
                             ? "the number of points"
                             : "the number of points of another scan, or the end of the file",
                         "correct the count before these points or export the file again");
    }
    // A record needs at least "0 0 0" and a line end.
    const std::uint64_t room = source_.remaining() / 6 + 1;
    if (*count > room) {
      throw lines_.Error(fmt::format("{} points declared", *count),
                         fmt::format("<= {} points, what the file can hold", room),
                         "the count is wrong or the file is cut short: export it again");
    }
    PtsScan scan{*count, source_.position(), lines_.line_number(), lines_.line_number()};
    for (std::uint64_t done = 0; done < scan.points; ++done) {
      if (!records_.NextLine(line)) throw Truncated(scan, done);
    }
    scan.last_line = lines_.line_number();
    return scan;
  }

  InputError Truncated(const PtsScan& scan, std::uint64_t done) const {
    return lines_.Error(
        fmt::format("the file ends after {} points", done),
        fmt::format("the declared {} points (line {})", scan.points, scan.lines_before),
        "the file is cut short: copy or export it again");
  }

  ByteSource source_;
  LineReader lines_;
  XyzRecords records_;
  ScanInfo info_;
  PtsScan scan_;
  PointCollector collector_;
  bool count_missing_ = false;
};

}  // namespace

std::unique_ptr<ScanReader> OpenPts(const std::string& path, int scan_index,
                                    const TextColumns& columns) {
  return std::make_unique<PtsReader>(path, scan_index, columns);
}

}  // namespace backsight
