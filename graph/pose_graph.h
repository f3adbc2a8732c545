#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

/// A measured relative pose between two stations.
struct PoseGraphLink {
  int source = 0;
  int target = 0;
  RigidTransform target_from_source;
  /// Of the measurement, in Retract's convention about target_from_source.
  Matrix6d information = Matrix6d::Identity();
  double confidence = 1.0;  ///< for the spanning tree only; larger is better
};

struct PoseGraphOptions {
  bool robust = true;               ///< graduated non-convexity over truncated least squares
  double outlier_quantile = 16.81;  ///< chi^2 with 6 degrees of freedom at 99 %
  int max_iterations = 100;
};

struct PoseGraphResult {
  std::vector<RigidTransform> survey_from_station;  ///< identity for each component's first station
  std::vector<int> component;                       ///< per station, from 0
  std::vector<double> weights;                      ///< per link, 0 (removed) or 1
  std::vector<Matrix6d> covariance;                 ///< per station, zero for the fixed one
  double cost = 0.0;                                ///< half the weighted sum of squares
  int rounds = 0;                                   ///< of re-weighting
  bool converged = false;
};

/// Residual of a link, whitened by nothing: [Log(R Rm^T); t - Exp(phi) tm] with R, t the relative
/// pose from the stations. It is LocalDifference(relative, measured), so that the information
/// matrix of a planar adjustment applies as it is (docs/stages/network_solution.md).
Vector6d LinkResidual(const PoseGraphLink& link, const RigidTransform& survey_from_source,
                      const RigidTransform& survey_from_target);

/// Poses from a maximum spanning tree, then Ceres with robust re-weighting and a search for better
/// places of single stations; each connected component has its own datum at its first station.
/// Stations without links form components of their own. Links that end with weight 0 are taken as
/// false; components are formed anew without them. A heuristic: with many false links about one
/// station the least truncated cost may be missed.
PoseGraphResult SolvePoseGraph(int stations, std::span<const PoseGraphLink> links,
                               const PoseGraphOptions& options);

}  // namespace backsight
