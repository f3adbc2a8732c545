#include "io/las_sample.h"

#include <algorithm>

#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr std::uint64_t kMaxPoints = 65536;
constexpr std::uint64_t kMaxBytes = std::uint64_t{8} << 20U;
constexpr std::uint64_t kRuns = 32;

}  // namespace

void LasSample::Add(const char* record, const LasPointLayout& layout) {
  ++points;
  intensity = std::max(intensity, LoadBytes<std::uint16_t>(record + LasAt::kPointIntensity));
  for (std::size_t c = 0; c < 3 && layout.rgb != 0; ++c) {
    color = std::max(color, LoadBytes<std::uint16_t>(record + layout.rgb + 2 * c));
  }
  if (layout.gps_time != 0 && LoadBytes<double>(record + layout.gps_time) != 0.0) {
    has_gps_time = true;
  }
}

LasSample SampleLas(ByteSource& source, const LasHeader& header) {
  const LasPointLayout layout = LasPointLayoutOf(header.point_format);
  const std::uint64_t most = std::min(kMaxPoints, kMaxBytes / header.point_bytes);
  const std::uint64_t runs = header.points <= most ? 1 : kRuns;
  const std::uint64_t run_points = header.points <= most ? header.points : most / kRuns;
  LasSample sample;
  for (std::uint64_t run = 0; run < runs; ++run) {
    // Divided first, because 64 bit counts times a run would overflow.
    const std::uint64_t first = runs == 1 ? 0 : (header.points - run_points) / (runs - 1) * run;
    source.Seek(header.point_offset + first * header.point_bytes);
    for (std::uint64_t i = 0; i < run_points; ++i) {
      const std::string_view bytes = source.Peek(header.point_bytes);
      if (bytes.size() < header.point_bytes) return sample;  // the reader comes here and reports it
      sample.Add(bytes.data(), layout);
      source.Consume(header.point_bytes);
    }
  }
  return sample;
}

}  // namespace backsight
