#include "io/xyz_reader.h"

#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/xyz_records.h"

namespace backsight {
namespace {

class XyzReader : public ScanReader {
 public:
  XyzReader(const std::string& path, const TextColumns& columns)
      : source_(path), lines_(source_), records_(lines_, columns) {
    info_.path = path;
    info_.format = "XYZ";
    if (!records_.SkipPreamble(info_.notes)) {
      throw lines_.Error("the file ends without a point", "lines 'x y z ...'",
                         "check that this is a point cloud");
    }
    records_.GuessLayout(false, UINT64_MAX, info_.notes);
    records_.Describe(info_);
    collector_.Configure(false, records_.layout().intensity_range);
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (at_end_) return false;
    for (std::size_t i = 0; i < kChunkRecords && !at_end_; ++i) {
      if (records_.Next()) {
        records_.Add(collector_, chunk);
      } else {
        at_end_ = true;
        collector_.Finish();
      }
    }
    return true;
  }

 private:
  ByteSource source_;
  LineReader lines_;
  XyzRecords records_;
  ScanInfo info_;
  PointCollector collector_;
  bool at_end_ = false;
};

}  // namespace

std::unique_ptr<ScanReader> OpenXyz(const std::string& path, const TextColumns& columns) {
  return std::make_unique<XyzReader>(path, columns);
}

}  // namespace backsight
