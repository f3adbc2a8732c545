#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/endian_bytes.h"
#include "io/ply_reader.h"
#include "io/read_back.h"

namespace backsight {
namespace {

class PlyWriter : public CloudWriter {
 public:
  explicit PlyWriter(const CloudWriterSpec& spec) : spec_(spec), file_(spec.path) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    if (!spec.generator.empty()) header += "comment " + spec.generator + "\n";
    header += "element vertex ";
    count_offset_ = header.size();
    header += CountText() + "\nproperty double x\nproperty double y\nproperty double z\n";
    if (spec.has_intensity) header += "property float intensity\n";
    if (spec.has_rgb) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (spec.has_classification) header += "property uchar classification\n";
    header += "property ushort station\nend_header\n";
    file_.Write(header);
  }

  void Write(const PointChunk& chunk, int station_number) override {
    RequireStationNumber(spec_.path, station_number);
    std::array<char, 34> record{};
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      char* end = record.data();
      const auto put = [&end](auto value) {
        StoreBytes(end, value);
        end += sizeof(value);
      };
      put(chunk.x[i]);
      put(chunk.y[i]);
      put(chunk.z[i]);
      if (spec_.has_intensity) put(chunk.intensity.empty() ? 0.0F : chunk.intensity[i]);
      for (std::size_t c = 0; c < 3 && spec_.has_rgb; ++c) {
        put(chunk.rgb.empty() ? std::uint8_t{0} : EightBit(chunk.rgb[i][c]));
      }
      if (spec_.has_classification) {
        put(chunk.classification.empty() ? std::uint8_t{0} : chunk.classification[i]);
      }
      put(static_cast<std::uint16_t>(station_number));
      file_.Write({record.data(), static_cast<std::size_t>(end - record.data())});
      ++written_.records;
      written_.AddPoint({chunk.x[i], chunk.y[i], chunk.z[i]});
    }
  }

  std::uint64_t Finish() override {
    file_.Overwrite(count_offset_, CountText());
    file_.Seal();
    RequireWritten(spec_.path, *OpenPly(file_.temporary_path()), written_, spec_.between);
    file_.Commit();
    return written_.records;
  }

 private:
  /// Leading zeros keep the width, so that the count can be set when it is known.
  std::string CountText() const { return fmt::format("{:020}", written_.records); }

  static std::uint8_t EightBit(std::uint16_t value) {
    return static_cast<std::uint8_t>((value + 128U) / 257U);
  }

  CloudWriterSpec spec_;
  AtomicFile file_;
  std::size_t count_offset_ = 0;
  CloudContent written_;
};

}  // namespace

std::unique_ptr<CloudWriter> CreatePlyWriter(const CloudWriterSpec& spec) {
  return std::make_unique<PlyWriter>(spec);
}

}  // namespace backsight
