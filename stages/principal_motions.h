#pragma once

#include <Eigen/Core>
#include <span>

#include "graph/planar_cost.h"

namespace backsight {

/// Motions of all stations but the first whose errors are independent of each other, one a column.
struct PrincipalMotions {
  Eigen::VectorXd sigmas_m;    ///< ascending; rotations count by the shift they cause at the planes
  Eigen::MatrixXd directions;  ///< unit; per station [rotation times lever; shift] about its planes
  /// Left perturbations of one sigma, Retract's convention: steps * steps^T is the covariance.
  Eigen::MatrixXd steps;
};

/// Of a covariance of left perturbations, 6 rows per pose, zero for the first. The lever of a
/// station is the rms distance of its planes from their centre. Time O(M^3) for M poses: a second
/// for 200.
PrincipalMotions FindPrincipalMotions(std::span<const WeightedPlane> planes,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance);

}  // namespace backsight
