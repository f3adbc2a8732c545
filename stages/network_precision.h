#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/execution.h"
#include "graph/planar_cost.h"

namespace backsight {

/// The motion of the whole network that is determined least.
struct WeakestDirection {
  double sigma_m = 0.0;  ///< rotations count by the shift they cause at the station's planes
  int station = -1;      ///< moves most in it
  /// 6M entries, unit length: per station [rotation times lever; shift] about its planes' centre.
  Eigen::VectorXd direction;
};

struct NetworkPrecision {
  Eigen::MatrixXd covariance;  ///< 6M x 6M, zero for the first station
  double variance_factor = 1.0;
  double block_m = 0.0;
  WeakestDirection weakest;
  bool valid = false;
};

struct PrecisionFloor {
  double rotation_rad = 0.0;   ///< systematic error of every station, per axis
  double translation_m = 0.0;  ///< at the instrument
};

/// Covariance at the minimum: (planes' information / variance factor + other observations')^-1 and
/// the floor. `problem.planes` with their weights, `poses` with the first station as datum,
/// `smallest_block_m` the edge of the smallest blocks of planes that are taken as independent.
NetworkPrecision ComputePrecision(const PlanarProblem& problem,
                                  std::span<const RigidTransform> poses, double smallest_block_m,
                                  const PrecisionFloor& floor, const ExecutionContext& context);

/// Inverse of the information of all but the first station, in full size; nothing where it is
/// singular.
Eigen::MatrixXd InvertInformation(const Eigen::MatrixXd& information);

}  // namespace backsight
