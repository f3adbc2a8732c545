#include "io/las_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr const char* kRemedy = "write the file again; check the disk if this repeats";
constexpr std::size_t kReturns = 14;  // in a point record of format 6 and up

/// Steps over the points.
struct StepBounds {
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
};

StepBounds ReadPoints(ByteSource& source, const LasHeader& header,
                      const std::function<void()>& between) {
  StepBounds bounds;
  bounds.low.fill(std::numeric_limits<std::int32_t>::max());
  bounds.high.fill(std::numeric_limits<std::int32_t>::min());
  source.Seek(header.point_offset);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    if (between && i % 65536 == 0) between();
    const std::string_view bytes = source.Peek(header.point_bytes);
    if (bytes.size() < header.point_bytes) {
      throw source.Truncated(source.position(), "points", header.points, i);
    }
    if (bytes[kReturns] != 0x11) {
      throw source.Error(source.position() + kReturns, "a point of several returns",
                         "return 1 of 1, as Backsight writes", kRemedy);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = LoadBytes<std::int32_t>(bytes.data() + 4 * axis);
      bounds.low[axis] = std::min(bounds.low[axis], value);
      bounds.high[axis] = std::max(bounds.high[axis], value);
    }
    source.Consume(header.point_bytes);
  }
  return bounds;
}

void CheckCounts(ByteSource& source, const LasHeader& header) {
  source.Seek(0);
  const std::string_view bytes = source.Peek(kLasHeaderBytes);
  for (std::size_t at = LasAt::kLegacyPoints; at < LasAt::kScale; at += 4) {
    const auto count = LoadBytes<std::uint32_t>(bytes.data() + at);
    if (count == 0) continue;
    throw source.Error(at, fmt::format("a legacy count of {}", count), "0", kRemedy);
  }
  for (std::size_t at = LasAt::kPointsByReturn; at < kLasHeaderBytes; at += 8) {
    const auto count = LoadBytes<std::uint64_t>(bytes.data() + at);
    const std::uint64_t expected = at == LasAt::kPointsByReturn ? header.points : 0;
    if (count == expected) continue;
    throw source.Error(at, fmt::format("{} points of a return", count), fmt::format("{}", expected),
                       kRemedy);
  }
}

}  // namespace

LasHeader VerifyLas(const std::string& path, const std::function<void()>& between) {
  ByteSource source(path);
  std::vector<std::string> notes;
  const LasHeader header = ReadLasHeader(source, notes);
  if (header.version_minor < 4 || header.point_format < 6) {
    throw source.Error(
        LasAt::kVersion,
        fmt::format("LAS 1.{}, point format {}", header.version_minor, header.point_format),
        "LAS 1.4, point format 6 or 7, as Backsight writes", kRemedy);
  }
  if (!notes.empty()) {
    throw source.Error(0, fmt::format("{}", fmt::join(notes, "; ")), "a file without flaw",
                       kRemedy);
  }
  CheckCounts(source, header);
  const StepBounds bounds = ReadPoints(source, header, between);
  for (int axis = 0; axis < 3 && header.points > 0; ++axis) {
    const double min = header.Metres(axis, bounds.low[static_cast<std::size_t>(axis)]);
    const double max = header.Metres(axis, bounds.high[static_cast<std::size_t>(axis)]);
    if (min == header.min[axis] && max == header.max[axis]) continue;
    throw source.Error(
        LasAt::kBounds,
        fmt::format("axis {} from {} to {}", axis, header.min[axis], header.max[axis]),
        fmt::format("{} to {}, as the points are", min, max), kRemedy);
  }
  return header;
}

}  // namespace backsight
