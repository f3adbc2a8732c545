#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/station_model.h"

namespace backsight {

/// A station's voxels as pieces of surface. Instrument frame.
struct Surface {
  const StationModel& model;
  const std::vector<Eigen::Vector3f>& normals;  ///< per leaf; NaN where undefined
  /// The scanner stood at the origin, so that its range image tells what it saw through.
  bool scanner_credible = true;
};

}  // namespace backsight
