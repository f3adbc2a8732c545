#include "io/pcd_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "io/line_reader.h"
#include "io/lzf.h"
#include "io/pcd_header.h"
#include "io/point_collector.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

/// Where the values of a field lie: at base + i * stride of the record or column buffer.
struct Channel {
  ScalarType type = ScalarType::kFloat32;
  std::size_t base = 0;
  std::size_t stride = 0;
  std::size_t column = 0;
};

bool IsGrid(const PcdHeader& header) { return header.height > 1 && header.width > 1; }

class PcdReader : public ScanReader {
 public:
  explicit PcdReader(const std::string& path)
      : source_(path), lines_(source_), header_(ReadPcdHeader(lines_)) {
    data_offset_ = source_.position();
    CheckFields();
    CheckSize();
    if (header_.data == PcdData::kCompressed) Unpack();
    FillInfo();
    MapChannels();
    collector_.Configure(IsGrid(header_),
                         has_intensity_ ? IntensityRangeOf(intensity_.type) : IntensityRange{});
    words_.resize(header_.columns);
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (done_ == header_.points) return false;
    const std::uint64_t n = std::min<std::uint64_t>(kChunkRecords, header_.points - done_);
    for (std::uint64_t i = 0; i < n; ++i, ++done_) {
      switch (header_.data) {
        case PcdData::kAscii:
          ReadLine(chunk);
          break;
        case PcdData::kBinary:
          ReadRecord(chunk);
          break;
        case PcdData::kCompressed:
          Add(columns_.data(), static_cast<std::size_t>(done_), chunk);
          break;
      }
    }
    if (done_ == header_.points) collector_.Finish();
    return true;
  }

 private:
  void CheckFields() {
    for (const char* name : {"x", "y", "z"}) {
      if (header_.Find(name) != nullptr) continue;
      throw lines_.Error(fmt::format("no field '{}'", name), "fields x, y and z",
                         "export the cloud with its coordinates");
    }
  }

  void CheckSize() const {
    if (header_.data == PcdData::kCompressed) return;
    const std::uint64_t bytes =
        header_.data == PcdData::kBinary ? header_.record_bytes : 2 * header_.columns - 1;
    const std::uint64_t available = source_.remaining() / bytes;
    if (header_.points > available) {
      throw source_.Truncated(data_offset_, "points", header_.points, available);
    }
  }

  void Unpack() {
    std::array<char, 8> sizes{};
    source_.Read(sizes.data(), sizes.size(), "bytes of the compression header");
    const std::size_t packed_bytes = LoadBytes<std::uint32_t>(sizes.data());
    const std::size_t bytes = LoadBytes<std::uint32_t>(sizes.data() + 4);
    if (packed_bytes > source_.remaining()) {
      throw source_.Truncated(data_offset_, "compressed bytes", packed_bytes, source_.remaining());
    }
    const bool fits = header_.points <= bytes / header_.record_bytes &&
                      header_.points * header_.record_bytes == bytes;
    if (!fits || bytes > packed_bytes * kLzfMaxRatio) {
      throw source_.Error(
          data_offset_, fmt::format("{} compressed bytes for {} bytes", packed_bytes, bytes),
          fmt::format("{} points of {} bytes", header_.points, header_.record_bytes),
          "the file is damaged: export it again");
    }
    std::vector<char> packed(packed_bytes);
    source_.Read(packed.data(), packed.size(), "compressed bytes");
    columns_.resize(bytes);
    if (!DecodeLzf(packed, columns_)) {
      throw source_.Error(data_offset_ + sizes.size(), "damaged LZF data",
                          fmt::format("{} bytes when unpacked", bytes),
                          "export the file again, best uncompressed (DATA binary)");
    }
  }

  void FillInfo() {
    info_.path = source_.path();
    info_.format = "PCD";
    info_.point_count = header_.points;
    if (IsGrid(header_) && header_.width <= std::numeric_limits<int>::max() &&
        header_.height <= std::numeric_limits<int>::max()) {
      info_.rows = static_cast<int>(header_.height);
      info_.columns = static_cast<int>(header_.width);
    }
    info_.world_from_scan = header_.viewpoint;
    if (header_.viewpoint_unusable) {
      info_.notes.emplace_back("VIEWPOINT is no pose (7 finite numbers, unit quaternion): ignored");
    } else if (header_.viewpoint && !header_.viewpoint->Matrix().isIdentity(1e-12)) {
      info_.notes.emplace_back(
          "VIEWPOINT is not the identity: recorded, not applied; coordinates are taken to be in "
          "the scanner's own frame");
    }
    if (header_.data == PcdData::kBinary) {
      const std::uint64_t used = header_.points * header_.record_bytes;
      if (source_.remaining() > used) {
        info_.notes.push_back(
            fmt::format("{} bytes after the last point ignored", source_.remaining() - used));
      }
    }
  }

  Channel MapField(const PcdField& field) const {
    Channel channel{field.type, field.offset, 0, field.column};
    if (header_.data == PcdData::kCompressed) {
      // Column by column: all values of the first field, then all of the second, and so on.
      channel.base = field.offset * static_cast<std::size_t>(header_.points);
      channel.stride = field.count * SizeOf(field.type);
    }
    return channel;
  }

  void MapChannels() {
    x_ = MapField(*header_.Find("x"));
    y_ = MapField(*header_.Find("y"));
    z_ = MapField(*header_.Find("z"));
    if (const PcdField* intensity = header_.Find("intensity")) {
      has_intensity_ = true;
      intensity_ = MapField(*intensity);
    }
    const PcdField* color = header_.Find("rgb");
    if (color == nullptr) color = header_.Find("rgba");
    if (color != nullptr && SizeOf(color->type) != 4) {
      info_.notes.push_back("field " + color->name + " is not a packed colour of 4 bytes: skipped");
    } else if (color != nullptr) {
      has_rgb_ = true;
      rgb_ = MapField(*color);
    }
    info_.has_intensity = has_intensity_;
    info_.has_rgb = has_rgb_;
  }

  void ReadRecord(PointChunk& chunk) {
    const std::string_view ahead = source_.Peek(header_.record_bytes);
    if (ahead.size() < header_.record_bytes) {
      throw source_.Truncated(source_.position(), "points", header_.points, done_);
    }
    Add(ahead.data(), 0, chunk);
    source_.Consume(header_.record_bytes);
  }

  void Add(const char* data, std::size_t index, PointChunk& chunk) {
    const auto at = [&](const Channel& c) { return data + c.base + index * c.stride; };
    const auto value = [&](const Channel& c) {
      return LoadScalar(at(c), c.type, std::endian::little);
    };
    if (!collector_.AddPoint(value(x_), value(y_), value(z_), chunk)) return;
    if (has_intensity_) collector_.AddIntensity(value(intensity_), chunk);
    if (has_rgb_) AddColor(LoadBytes<std::uint32_t>(at(rgb_)), chunk);
    AddCell(chunk);
  }

  /// Records go along a row, then to the next.
  void AddCell(PointChunk& chunk) {
    if (info_.rows == 0) return;
    const auto columns = static_cast<std::uint64_t>(info_.columns);
    const std::uint64_t row = done_ / columns;
    const std::uint64_t column = done_ % columns;
    collector_.AddCell(static_cast<double>(row), static_cast<double>(column), info_, chunk);
  }

  void ReadLine(PointChunk& chunk) {
    std::string_view line;
    if (!lines_.Next(line)) {
      throw lines_.Error(fmt::format("the file ends after {} points", done_),
                         fmt::format("the declared {} points", header_.points),
                         "the file is cut short: copy or export it again");
    }
    const std::size_t count = SplitFields(line, ' ', words_);
    if (count != words_.size()) {
      throw lines_.Error(fmt::format("{} values: {}", count, Quoted(line)),
                         fmt::format("{} values", words_.size()), "the line is damaged");
    }
    if (!collector_.AddPoint(Number(x_), Number(y_), Number(z_), chunk)) return;
    if (has_intensity_) collector_.AddIntensity(Number(intensity_), chunk);
    if (has_rgb_) AddColor(ColorBits(), chunk);
    AddCell(chunk);
  }

  double Number(const Channel& channel) const {
    const std::optional<double> number = ParseNumber(words_[channel.column]);
    if (!number) {
      throw lines_.Error(Quoted(words_[channel.column]), "a number", "the line is damaged");
    }
    return *number;
  }

  /// Colours written as float are the bits of 0x00RRGGBB seen as a float.
  std::uint32_t ColorBits() const {
    const double number = Number(rgb_);
    if (IsFloat(rgb_.type)) return std::bit_cast<std::uint32_t>(static_cast<float>(number));
    if (number >= -2147483648.0 && number <= 4294967295.0) {
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(number));
    }
    throw lines_.Error(Quoted(words_[rgb_.column]), "a packed colour of 32 bits",
                       "the line is damaged");
  }

  static void AddColor(std::uint32_t bits, PointChunk& chunk) {
    const auto channel = [bits](unsigned shift) {
      return static_cast<std::uint16_t>((bits >> shift & 0xFFU) * 257U);
    };
    chunk.rgb.push_back({channel(16), channel(8), channel(0)});
  }

  ByteSource source_;
  LineReader lines_;
  PcdHeader header_;
  std::uint64_t data_offset_ = 0;
  std::vector<char> columns_;
  ScanInfo info_;
  PointCollector collector_;
  Channel x_, y_, z_, intensity_, rgb_;
  bool has_intensity_ = false;
  bool has_rgb_ = false;
  std::uint64_t done_ = 0;
  std::vector<std::string_view> words_;
};

}  // namespace

std::unique_ptr<ScanReader> OpenPcd(const std::string& path) {
  return std::make_unique<PcdReader>(path);
}

}  // namespace backsight
