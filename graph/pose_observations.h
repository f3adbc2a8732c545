#pragma once

#include <Eigen/Core>
#include <span>

#include "core/rigid_transform.h"
#include "graph/pose_graph.h"

namespace backsight {

/// Gradient and Gauss-Newton matrix over all stations, 6 rows each, Retract's convention.
struct NormalEquations {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd matrix;
};

/// Adds J^T information J, J = [I, -I], to the rows and columns of two different stations, which
/// begin at `i` and `j`: what is known of their relative pose. The information is symmetric.
void AddRelative(Eigen::Index i, Eigen::Index j, const Matrix6d& information,
                 Eigen::MatrixXd* matrix);

/// Soft observation of one station's pose: 0.5 * r^T information r, r = LocalDifference(pose,
/// expected).
struct PosePrior {
  int station = 0;
  RigidTransform expected;
  Matrix6d information = Matrix6d::Zero();
};

/// A levelled station: its z axis is the vertical, within sigma_rad per horizontal axis. The
/// vertical itself is unknown and common to all levelled stations; it is eliminated in closed form:
/// the cost is 0.5 * sum |z_s - v|^2 / sigma_s^2, z_s the station's z axis in the world and v their
/// weighted mean. One station alone observes nothing; the datum station counts like any other.
struct TiltObservation {
  int station = 0;
  double sigma_rad = 1e-4;

  double weight() const { return 1.0 / (sigma_rad * sigma_rad); }
};

/// The levelled stations' weighted mean z axis in the world, v above, and their total weight; both
/// zero where there are none.
struct Vertical {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weight = 0.0;
};

Vertical EstimateVertical(std::span<const TiltObservation> tilts,
                          std::span<const RigidTransform> poses);

/// What is known of the poses besides planes. `links` are 0.5 * r^T information r with r =
/// LinkResidual; their confidence plays no part.
struct PoseObservations {
  std::span<const PosePrior> priors;
  std::span<const PoseGraphLink> links;
  std::span<const TiltObservation> tilts;
};

double PoseObservationsCost(const PoseObservations& observations,
                            std::span<const RigidTransform> poses);

/// Adds cost, gradient and Gauss-Newton matrix; `system` must have 6 rows per pose. Links
/// annihilate a common motion, tilts a common rotation about the vertical and every translation.
void AddPoseObservations(const PoseObservations& observations,
                         std::span<const RigidTransform> poses, NormalEquations* system);

}  // namespace backsight
