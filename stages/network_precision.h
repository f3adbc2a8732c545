#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/execution.h"
#include "graph/planar_cost.h"
#include "graph/planar_statistics.h"

namespace backsight {

/// The motion of the whole network that is determined least.
struct WeakestMotion {
  double sigma_m = 0.0;  ///< rotations count by the shift they cause at the station's planes
  int station = -1;      ///< moves most in it
  /// 6M entries, unit length: per station [rotation times lever; shift] about its planes' centre.
  Eigen::VectorXd direction;
};

struct NetworkPrecision {
  Eigen::MatrixXd covariance;  ///< 6M x 6M, zero for the first station
  double variance_factor = 1.0;
  double block_m = 0.0;
  WeakestMotion weakest;
  bool valid = false;
};

struct PrecisionFloor {
  double rotation_rad = 0.0;   ///< systematic error of every station, per axis
  double translation_m = 0.0;  ///< at the instrument
};

/// The network at its minimum.
struct PrecisionInput {
  std::span<const WeightedPlane> planes;
  std::span<const LinkScore> surfaces;    ///< whatever else belongs to the scans, by blocks
  PoseObservations others;                ///< whose information is taken at its word
  std::span<const RigidTransform> poses;  ///< the first station is the datum
  double smallest_block_m = 0.8;          ///< of the blocks that may be independent
  double robust_slope = 1.0;              ///< PlaneWeights::slope
};

/// Covariance (information of planes and surfaces / variance factor + others')^-1, larger for those
/// principal motions of it whose blocks scatter more than that or whose information was none, plus
/// the floor (docs/stages/network_refinement.md#uncertainty). Time: some (6 M)^3 products for M
/// stations, and those of the blocks' stations.
NetworkPrecision ComputePrecision(const PrecisionInput& input, const PrecisionFloor& floor,
                                  const ExecutionContext& context);

/// Gauss-Newton matrix of planes and surfaces.
Eigen::MatrixXd ScanInformation(const PrecisionInput& input, const ExecutionContext& context);

/// Blocks for the variance factor: each plane and then each surface score by the cell of edge
/// `edge_m` its centre lies in.
std::vector<std::uint64_t> SpatialBlocks(const PrecisionInput& input, double edge_m);

/// Inverse of the information of all but the first station, in full size; nothing where it is
/// singular.
Eigen::MatrixXd InvertInformation(const Eigen::MatrixXd& information);

}  // namespace backsight
