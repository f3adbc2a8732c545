#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "io/cloud_writer.h"
#include "io/scan_reader.h"

namespace backsight {

/// A placed station and how to read its scan again.
struct MergeStation {
  int number = 1;  ///< Point Source ID, 1..65535
  RigidTransform survey_from_station;
  Eigen::Vector3d range_origin =
      Eigen::Vector3d::Zero();                    ///< ranges count from here, station frame
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< bounds of the points used, station frame
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  double min_range_m = 0.0;  ///< the range limits of the ingest hold here too
  double max_range_m = 0.0;
  bool has_intensity = false;
  bool has_rgb = false;
  std::function<std::unique_ptr<ScanReader>()> open;
};

/// Bounds of all stations' points in the survey frame, from the corners of their boxes.
struct CloudBounds {
  Eigen::Vector3d min;
  Eigen::Vector3d max;
};
CloudBounds MergedBounds(const std::vector<MergeStation>& stations);

/// Reads every station's scan once more and hands its points, in the survey frame, to `writer`;
/// with `thin_m` > 0 twice: one point per cell of that edge is kept, the one nearest to its
/// scanner. Streams; memory is 24 bytes per occupied cell when thinning, otherwise constant.
/// Returns the number of points written; the caller finishes the writer.
std::uint64_t MergeClouds(const std::vector<MergeStation>& stations, double thin_m,
                          CloudWriter& writer, const ExecutionContext& context);

}  // namespace backsight
