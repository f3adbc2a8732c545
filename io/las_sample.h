#pragma once

#include <cstdint>
#include <string_view>

#include "io/byte_source.h"
#include "io/las_header.h"

namespace backsight {

/// Largest values of the fields whose use LAS leaves open, over a sample of the points.
struct LasSample {
  std::uint64_t points = 0;  ///< in the sample
  std::uint16_t intensity = 0;
  std::uint16_t color = 0;
  bool has_gps_time = false;  ///< some time is not 0

  void Add(const char* record, const LasPointLayout& layout);
};

/// Looks at up to 65536 points (8 MiB) in runs spread evenly over the file: all of a small file.
LasSample SampleLas(ByteSource& source, const LasHeader& header);

}  // namespace backsight
