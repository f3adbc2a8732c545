#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/plane_segmentation.h"

namespace backsight {

/// A plane in the adjustment: cost weight * lambda_1, the smallest eigenvalue of the covariance of
/// all its points at the current poses, i.e. their mean squared distance from the best plane.
struct WeightedPlane {
  std::vector<PlaneObservation> observations;
  double weight = 1.0;  ///< 1/m^2
};

/// Soft observation of one station's pose: 0.5 * r^T information r, r = LocalDifference(pose,
/// expected).
struct PosePrior {
  int station = 0;
  RigidTransform expected;
  Matrix6d information = Matrix6d::Zero();
};

/// Gradient and Gauss-Newton matrix over all stations, 6 rows each, Retract's convention. The
/// matrix is the Schur complement of the point-to-plane normal matrix after elimination of the
/// planes: always positive semi-definite, and it annihilates a common rigid motion.
struct NormalEquations {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd matrix;
};

/// lambda_1 of every plane at `poses` (world_from_station), m^2.
std::vector<double> PlaneThicknesses(std::span<const WeightedPlane> planes,
                                     std::span<const RigidTransform> poses);

/// Sum of weight * lambda_1 and the priors' cost.
double PlanarCost(std::span<const WeightedPlane> planes, std::span<const PosePrior> priors,
                  std::span<const RigidTransform> poses);

/// Cost, gradient and Gauss-Newton matrix (docs/stages/fine_registration.md, after BALM2's
/// elimination of plane parameters, doi 10.1109/TRO.2023.3335670).
NormalEquations AssembleNormalEquations(std::span<const WeightedPlane> planes,
                                        std::span<const PosePrior> priors,
                                        std::span<const RigidTransform> poses);

}  // namespace backsight
