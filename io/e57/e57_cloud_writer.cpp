#include "io/e57/e57_cloud_writer.h"

#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

class E57CloudWriter : public CloudWriter {
 public:
  E57CloudWriter(E57FileSpec file, std::map<int, E57ScanSpec> scans)
      : writer_(std::move(file)), scans_(std::move(scans)) {}

  void Write(const PointChunk& chunk, int station_number) override {
    if (chunk.empty()) return;
    if (station_number != open_) {
      EndScan();
      const auto scan = scans_.extract(station_number);
      BACKSIGHT_CHECK(!scan.empty(), "a station that is not announced, or was ended before");
      writer_.BeginScan(scan.mapped());
      open_ = station_number;
    }
    writer_.Write(chunk);
  }

  std::uint64_t Finish() override {
    EndScan();
    writer_.Finish();
    return points_;
  }

 private:
  void EndScan() {
    if (open_ != 0) points_ += writer_.EndScan();
    open_ = 0;
  }

  E57Writer writer_;
  std::map<int, E57ScanSpec> scans_;  // those not begun yet
  int open_ = 0;
  std::uint64_t points_ = 0;
};

}  // namespace

std::unique_ptr<CloudWriter> CreateE57CloudWriter(E57FileSpec file,
                                                  std::map<int, E57ScanSpec> scans) {
  return std::make_unique<E57CloudWriter>(std::move(file), std::move(scans));
}

}  // namespace backsight
