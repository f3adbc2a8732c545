#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// What a file holds, as it was written or as it is read.
struct CloudContent {
  std::uint64_t records = 0;  ///< points, and with them what is no point
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;  ///< below `low` while there are no points
  std::string crs;

  void AddPoint(const Eigen::Vector3d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

/// Reads a scan that was just written from end to end and throws InputError, `path` in it, unless
/// it has the records, exactly the bounds and the reference system that were written. `between`,
/// called for every chunk, may throw to give up.
void RequireWritten(const std::string& path, ScanReader& scan, const CloudContent& written,
                    const std::function<void()>& between);

}  // namespace backsight
