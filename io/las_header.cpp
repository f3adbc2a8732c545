#include "io/las_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "io/endian_bytes.h"
#include "io/las_crs.h"

namespace backsight {
namespace {

constexpr std::size_t kTextBytes = 32;
constexpr const char* kRemedy = "the LAS header is damaged: export the file again";

void StoreText(std::string_view text, char* to) {
  std::copy_n(text.data(), std::min(text.size(), kTextBytes), to);
}

class HeaderReader {
 public:
  HeaderReader(ByteSource& source, std::vector<std::string>& notes)
      : source_(source), notes_(notes) {}

  LasHeader Read() {
    source_.Seek(0);
    bytes_ = source_.Peek(kLas15HeaderBytes);
    if (bytes_.size() < kLas12HeaderBytes || !bytes_.starts_with("LASF")) {
      throw source_.Error(0, "no LAS header",
                          fmt::format("{} bytes that begin with LASF", kLas12HeaderBytes),
                          "the file is cut short or no LAS file: copy or export it again");
    }
    ReadVersion();
    ReadSizes();
    ReadPointFormat();
    ReadCoordinateSystem();
    ReadCounts();
    ReadTimeOffset();
    header_.generator = std::string(bytes_.substr(LasAt::kGenerator, kTextBytes));
    header_.generator.resize(std::min(header_.generator.size(), header_.generator.find('\0')));
    header_.crs = ReadLasCrs(source_, header_, notes_);
    return std::move(header_);
  }

 private:
  template <Arithmetic T>
  T Load(std::size_t at) const {
    return LoadBytes<T>(bytes_.data() + at);
  }

  void ReadVersion() {
    const int major = Load<std::uint8_t>(LasAt::kVersion);
    const int minor = Load<std::uint8_t>(LasAt::kVersion + 1);
    if (major != 1 || minor > 5) {
      throw source_.Error(LasAt::kVersion, fmt::format("LAS version {}.{}", major, minor),
                          "1.0 to 1.5", kRemedy);
    }
    header_.version_minor = minor;
    header_.global_encoding = Load<std::uint16_t>(LasAt::kGlobalEncoding);
  }

  void ReadSizes() {
    const std::size_t least = header_.version_minor < 4 ? kLas12HeaderBytes : kLasHeaderBytes;
    header_.header_bytes = Load<std::uint16_t>(LasAt::kHeaderBytes);
    if (header_.header_bytes < least || header_.header_bytes > source_.size()) {
      throw source_.Error(LasAt::kHeaderBytes,
                          fmt::format("a header of {} bytes", header_.header_bytes),
                          fmt::format("{} bytes (LAS 1.{}) to {}, the file's size", least,
                                      header_.version_minor, source_.size()),
                          kRemedy);
    }
    header_.point_offset = Load<std::uint32_t>(LasAt::kPointOffset);
    if (header_.point_offset < header_.header_bytes || header_.point_offset > source_.size()) {
      throw source_.Error(LasAt::kPointOffset,
                          fmt::format("points at byte {}", header_.point_offset),
                          fmt::format("{}, the end of the header, to {}, the file's size",
                                      header_.header_bytes, source_.size()),
                          "the header is damaged or the file cut short: copy or export it again");
    }
    header_.record_count = Load<std::uint32_t>(LasAt::kRecordCount);
  }

  void ReadPointFormat() {
    header_.point_format = Load<std::uint8_t>(LasAt::kPointFormat);
    if (header_.point_format >= kLasPointFormats) {
      throw source_.Error(LasAt::kPointFormat,
                          fmt::format("point data record format {}", header_.point_format),
                          "0 to 10, not compressed", kRemedy);
    }
    header_.point_bytes = Load<std::uint16_t>(LasAt::kPointBytes);
    const std::size_t least = LasPointLayoutOf(header_.point_format).bytes;
    if (header_.point_bytes < least) {
      throw source_.Error(
          LasAt::kPointBytes, fmt::format("point records of {} bytes", header_.point_bytes),
          fmt::format("at least {}, the length of format {}", least, header_.point_format),
          kRemedy);
    }
    if (header_.point_format >= 6 && header_.version_minor < 4) {
      notes_.push_back(fmt::format("point format {} came with LAS 1.4, but the file says 1.{}",
                                   header_.point_format, header_.version_minor));
    }
  }

  void ReadCoordinateSystem() {
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = static_cast<std::size_t>(axis) * 8;
      const double scale = Load<double>(LasAt::kScale + place);
      if (!std::isfinite(scale) || !(scale > 0.0)) {
        throw source_.Error(LasAt::kScale + place, fmt::format("scale {} of axis {}", scale, axis),
                            "a positive number of metres", kRemedy);
      }
      const double offset = Load<double>(LasAt::kOffset + place);
      if (!std::isfinite(offset)) {
        throw source_.Error(LasAt::kOffset + place,
                            fmt::format("offset {} of axis {}", offset, axis), "a finite number",
                            kRemedy);
      }
      header_.scale[axis] = scale;
      header_.offset[axis] = offset;
      header_.max[axis] = Load<double>(LasAt::kBounds + 2 * place);
      header_.min[axis] = Load<double>(LasAt::kBounds + 2 * place + 8);
    }
  }

  /// How many whole records lie between the first point and byte `end`.
  std::uint64_t RecordsUpTo(std::uint64_t end) const {
    return (end - header_.point_offset) / header_.point_bytes;
  }

  bool IsBehindPoints(std::uint64_t offset) const {
    return offset >= header_.point_offset && offset < source_.size();
  }

  void ReadCounts() {
    std::uint64_t end = source_.size();
    if (header_.version_minor >= 4) {
      header_.extended_offset = Load<std::uint64_t>(LasAt::kExtendedOffset);
      header_.extended_count = Load<std::uint32_t>(LasAt::kExtendedCount);
      if (header_.extended_count > 0 && IsBehindPoints(header_.extended_offset)) {
        end = header_.extended_offset;
      } else if (header_.extended_count > 0) {
        notes_.push_back(
            fmt::format("extended records said to begin at byte {}, which is not "
                        "behind the points, are ignored",
                        header_.extended_offset));
        header_.extended_count = 0;
      }
    }
    const bool has_waveforms = header_.header_bytes >= LasAt::kExtendedOffset &&
                               (header_.global_encoding & LasEncoding::kInternalWaveforms) != 0 &&
                               LasPointLayoutOf(header_.point_format).has_waveform;
    if (has_waveforms && IsBehindPoints(Load<std::uint64_t>(LasAt::kWaveforms))) {
      end = std::min(end, Load<std::uint64_t>(LasAt::kWaveforms));
    }
    header_.points = ChooseCount(RecordsUpTo(end));
    if (header_.points > RecordsUpTo(source_.size())) {
      throw source_.Truncated(header_.point_offset, "points", header_.points,
                              RecordsUpTo(source_.size()));
    }
    const std::uint64_t used = header_.point_offset + header_.points * header_.point_bytes;
    if (used > end) {
      notes_.push_back(fmt::format(
          "records said to begin at byte {}, in the middle of the points, are ignored", end));
      header_.extended_count = 0;
    } else if (used < end) {
      notes_.push_back(fmt::format("{} bytes behind the last of the {} declared points are ignored",
                                   end - used, header_.points));
    }
  }

  /// LAS 1.4 counts points in 64 bits and, for old readers, in a legacy field of 32 that may be 0.
  /// Where both are set and differ, the one that the file's size confirms is taken.
  std::uint64_t ChooseCount(std::uint64_t available) {
    const std::uint64_t legacy = Load<std::uint32_t>(LasAt::kLegacyPoints);
    if (header_.version_minor < 4) return legacy;
    const auto count = Load<std::uint64_t>(LasAt::kPoints);
    if (count == legacy || legacy == 0) return count;
    const bool take_legacy = count == 0 || (legacy == available && count != available) ||
                             (legacy <= available && count > available);
    const std::uint64_t taken = take_legacy ? legacy : count;
    notes_.push_back(
        fmt::format("the header counts {} points in its 64 bit field and {} in the legacy one; {} "
                    "taken, where the file has room for {}",
                    count, legacy, taken, available));
    return taken;
  }

  void ReadTimeOffset() {
    const bool has_offset = header_.version_minor >= 5 && bytes_.size() >= kLas15HeaderBytes &&
                            header_.header_bytes >= kLas15HeaderBytes &&
                            (header_.global_encoding & LasEncoding::kTimeOffset) != 0;
    if (has_offset) header_.time_offset = Load<std::uint16_t>(LasAt::kTimeOffset);
  }

  ByteSource& source_;
  std::vector<std::string>& notes_;
  std::string_view bytes_;  // valid until the source is read again
  LasHeader header_;
};

}  // namespace

LasHeader ReadLasHeader(ByteSource& source, std::vector<std::string>& notes) {
  return HeaderReader(source, notes).Read();
}

std::array<char, kLasHeaderBytes> EncodeLasHeader(const LasHeader& header) {
  std::array<char, kLasHeaderBytes> bytes{};  // what is not set below is 0
  char* const to = bytes.data();
  std::copy_n("LASF", 4, to);
  StoreBytes(to + LasAt::kGlobalEncoding, static_cast<std::uint16_t>(header.global_encoding));
  to[LasAt::kVersion] = 1;
  to[LasAt::kVersion + 1] = 4;
  StoreText("MERGE", to + LasAt::kSystemIdentifier);
  StoreText(header.generator, to + LasAt::kGenerator);
  StoreBytes<std::uint16_t>(to + LasAt::kHeaderBytes, kLasHeaderBytes);
  StoreBytes(to + LasAt::kPointOffset, static_cast<std::uint32_t>(header.point_offset));
  StoreBytes(to + LasAt::kRecordCount, header.record_count);
  to[LasAt::kPointFormat] = static_cast<char>(header.point_format);
  StoreBytes(to + LasAt::kPointBytes, static_cast<std::uint16_t>(header.point_bytes));
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = static_cast<std::size_t>(axis) * 8;
    StoreBytes(to + LasAt::kScale + place, header.scale[axis]);
    StoreBytes(to + LasAt::kOffset + place, header.offset[axis]);
    StoreBytes(to + LasAt::kBounds + 2 * place, header.max[axis]);
    StoreBytes(to + LasAt::kBounds + 2 * place + 8, header.min[axis]);
  }
  StoreBytes(to + LasAt::kPoints, header.points);
  StoreBytes(to + LasAt::kPointsByReturn, header.points);
  return bytes;
}

}  // namespace backsight
