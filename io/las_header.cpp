#include "io/las_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "io/byte_source.h"
#include "io/endian_bytes.h"

namespace backsight {
namespace {

// Byte offsets in the LAS 1.4 header.
constexpr std::size_t kGlobalEncoding = 6;
constexpr std::size_t kVersion = 24;
constexpr std::size_t kSystemIdentifier = 26;
constexpr std::size_t kGenerator = 58;
constexpr std::size_t kTextBytes = 32;
constexpr std::size_t kHeaderSize = 94;
constexpr std::size_t kPointDataOffset = 96;
constexpr std::size_t kPointFormat = 104;
constexpr std::size_t kRecordLength = 105;
constexpr std::size_t kScale = 131;
constexpr std::size_t kOffset = 155;
constexpr std::size_t kBounds = 179;  // max x, min x, max y, min y, max z, min z
constexpr std::size_t kPointCount = 247;
constexpr std::size_t kPointsByReturn = 255;

constexpr std::uint16_t kWktBit = 1U << 4U;

void StoreText(std::string_view text, char* to) {
  std::copy_n(text.data(), std::min(text.size(), kTextBytes), to);
}

}  // namespace

std::size_t LasRecordBytes(int point_format) { return point_format == 7 ? 36 : 30; }

std::array<char, kLasHeaderBytes> EncodeLasHeader(const LasHeader& header) {
  std::array<char, kLasHeaderBytes> bytes{};  // what is not set below is 0
  char* const to = bytes.data();
  std::copy_n("LASF", 4, to);
  StoreBytes<std::uint16_t>(to + kGlobalEncoding, kWktBit);
  to[kVersion] = 1;
  to[kVersion + 1] = 4;
  StoreText("MERGE", to + kSystemIdentifier);
  StoreText(header.generator, to + kGenerator);
  StoreBytes<std::uint16_t>(to + kHeaderSize, kLasHeaderBytes);
  StoreBytes<std::uint32_t>(to + kPointDataOffset, kLasHeaderBytes);
  to[kPointFormat] = static_cast<char>(header.point_format);
  StoreBytes(to + kRecordLength, static_cast<std::uint16_t>(LasRecordBytes(header.point_format)));
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = static_cast<std::size_t>(axis) * 8;
    StoreBytes(to + kScale + place, header.scale[axis]);
    StoreBytes(to + kOffset + place, header.offset[axis]);
    StoreBytes(to + kBounds + 2 * place, header.max[axis]);
    StoreBytes(to + kBounds + 2 * place + 8, header.min[axis]);
  }
  StoreBytes(to + kPointCount, header.points);
  StoreBytes(to + kPointsByReturn, header.points);
  return bytes;
}

LasHeader DecodeLasHeader(std::string_view bytes, const std::string& path) {
  const auto fail = [&](std::string found, std::string expected) {
    return InputError({path, std::move(found), std::move(expected), "write the file again"});
  };
  if (bytes.size() < kLasHeaderBytes || !bytes.starts_with("LASF")) {
    throw fail("no LAS header", fmt::format("{} bytes that begin with LASF", kLasHeaderBytes));
  }
  const char* const from = bytes.data();
  LasHeader header;
  header.point_format = static_cast<unsigned char>(from[kPointFormat]);
  if (from[kVersion] != 1 || from[kVersion + 1] != 4 ||
      (header.point_format != 6 && header.point_format != 7) ||
      LoadBytes<std::uint16_t>(from + kRecordLength) != LasRecordBytes(header.point_format) ||
      LoadBytes<std::uint32_t>(from + kPointDataOffset) != kLasHeaderBytes) {
    throw fail("a LAS header of another kind", "LAS 1.4, point format 6 or 7, no records before");
  }
  header.generator = std::string(bytes.substr(kGenerator, kTextBytes));
  header.generator.resize(std::min(header.generator.size(), header.generator.find('\0')));
  header.points = LoadBytes<std::uint64_t>(from + kPointCount);
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = static_cast<std::size_t>(axis) * 8;
    header.scale[axis] = LoadBytes<double>(from + kScale + place);
    header.offset[axis] = LoadBytes<double>(from + kOffset + place);
    header.max[axis] = LoadBytes<double>(from + kBounds + 2 * place);
    header.min[axis] = LoadBytes<double>(from + kBounds + 2 * place + 8);
  }
  return header;
}

LasHeader VerifyLas(const std::string& path) {
  ByteSource source(path);
  const LasHeader header = DecodeLasHeader(source.Peek(kLasHeaderBytes), path);
  source.Seek(kLasHeaderBytes);
  const std::size_t record = LasRecordBytes(header.point_format);
  if (header.points != source.remaining() / record || source.remaining() % record != 0) {
    throw source.Truncated(kLasHeaderBytes, "points", header.points, source.remaining() / record);
  }
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;
  low.fill(std::numeric_limits<std::int32_t>::max());
  high.fill(std::numeric_limits<std::int32_t>::min());
  for (std::uint64_t i = 0; i < header.points; ++i) {
    const std::string_view bytes = source.Peek(record);
    if (bytes.size() < record)
      throw source.Truncated(source.position(), "points", header.points, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = LoadBytes<std::int32_t>(bytes.data() + 4 * axis);
      low[axis] = std::min(low[axis], value);
      high[axis] = std::max(high[axis], value);
    }
    source.Consume(record);
  }
  for (int axis = 0; axis < 3 && header.points > 0; ++axis) {
    const auto metres = [&](std::int32_t step) {
      return header.offset[axis] + header.scale[axis] * step;
    };
    const double min = metres(low[static_cast<std::size_t>(axis)]);
    const double max = metres(high[static_cast<std::size_t>(axis)]);
    if (min == header.min[axis] && max == header.max[axis]) continue;
    throw source.Error(
        kBounds, fmt::format("axis {} from {} to {}", axis, header.min[axis], header.max[axis]),
        fmt::format("{} to {}, as the points are", min, max),
        "write the file again; check the disk if this repeats");
  }
  return header;
}

}  // namespace backsight
