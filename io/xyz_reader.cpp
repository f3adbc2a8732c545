#include "io/xyz_reader.h"

#include "io/block_reader.h"
#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/xyz_records.h"

namespace backsight {
namespace {

class XyzReader : public BlockReader<TextBlock> {
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

 private:
  bool Take(TextBlock& block) override {
    if (at_end_) return false;
    at_end_ = !records_.Take(kChunkRecords, block) || source_.remaining() == 0;
    block.is_last = at_end_;
    return true;
  }

  void Decode(TextBlock& block) const override {
    block.counts = collector_.ForPart();
    records_.Decode(block);
  }

  void Count(TextBlock& block) override {
    collector_.Add(block.counts);
    if (block.is_last) collector_.Finish();
  }

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
