#include <fmt/format.h>

#include <array>

#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/endian_bytes.h"
#include "io/pcd_reader.h"
#include "io/read_back.h"

namespace backsight {
namespace {

class PcdWriter : public CloudWriter {
 public:
  explicit PcdWriter(const CloudWriterSpec& spec) : spec_(spec), file_(spec.path) {
    file_.Write(Header());
  }

  void Write(const PointChunk& chunk, int station_number) override {
    RequireStationNumber(spec_.path, station_number);
    std::array<char, 35> record{};
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
      if (spec_.has_rgb) put(chunk.rgb.empty() ? 0U : PackColor(chunk.rgb[i]));
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
    file_.Overwrite(0, Header());
    file_.Seal();
    RequireWritten(spec_.path, *OpenPcd(file_.temporary_path()), written_, spec_.between);
    file_.Commit();
    return written_.records;
  }

 private:
  /// Leading zeros keep the length, so that the count can be set when it is known. Colour is called
  /// a float, as the Point Cloud Library wants it, though its bits are 0x00RRGGBB.
  std::string Header() const {
    std::string fields = "x y z", sizes = "8 8 8", types = "F F F", counts = "1 1 1";
    const auto add = [&](const char* field, const char* size, const char* type) {
      fields.append(" ").append(field);
      sizes.append(" ").append(size);
      types.append(" ").append(type);
      counts.append(" 1");
    };
    if (spec_.has_intensity) add("intensity", "4", "F");
    if (spec_.has_rgb) add("rgb", "4", "F");
    if (spec_.has_classification) add("classification", "1", "U");
    add("station", "2", "U");
    return fmt::format(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\n"
        "COUNT {}\nWIDTH {:020}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {:020}\nDATA binary\n",
        fields, sizes, types, counts, written_.records, written_.records);
  }

  static std::uint32_t PackColor(const std::array<std::uint16_t, 3>& rgb) {
    const auto eight_bit = [](std::uint16_t value) { return (value + 128U) / 257U; };
    return eight_bit(rgb[0]) << 16U | eight_bit(rgb[1]) << 8U | eight_bit(rgb[2]);
  }

  CloudWriterSpec spec_;
  AtomicFile file_;
  CloudContent written_;
};

}  // namespace

std::unique_ptr<CloudWriter> CreatePcdWriter(const CloudWriterSpec& spec) {
  return std::make_unique<PcdWriter>(spec);
}

}  // namespace backsight
