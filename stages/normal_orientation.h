#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/execution.h"
#include "stages/station_model.h"

namespace backsight {

/// How the normals of a station were oriented.
struct NormalOrientation {
  /// Share of the surface that the assumed scanner position and the surface's own continuity orient
  /// alike, 0 to 1. A true position reaches 0.8 and more.
  double agreement = 1.0;
  bool scanner_credible = true;  ///< false: continuity decided, the position was not used
};

/// Turns the normals of the model's leaves towards the scanner, which is taken to stand at the
/// origin of the instrument frame. A position that is only assumed is checked against the surface:
/// signs are propagated from patch to patch along the smoothest way (Hoppe et al. 1992, doi
/// 10.1145/133994.134011), each connected part towards the cloud's centroid, around which a scanned
/// scene is open. Where the two disagree the scan is not in its scanner's frame and the propagated
/// signs are taken, as they are where the position is unknown. Rotation-invariant. NaN normals
/// stay.
NormalOrientation OrientNormals(const StationModel& model, const ExecutionContext& context,
                                std::vector<Eigen::Vector3f>* normals);

}  // namespace backsight
