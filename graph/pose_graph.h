#pragma once

#include <span>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

/// A measured relative pose between two stations: one possible motion of one pair.
struct PoseGraphLink {
  int source = 0;
  int target = 0;
  RigidTransform target_from_source;
  /// Of the measurement, in Retract's convention about target_from_source.
  Matrix6d information = Matrix6d::Identity();
  double confidence = 1.0;  ///< for the spanning tree only; larger is better
  int pair = -1;            ///< links of one pair exclude each other; -1: a pair of its own
  double score = 0.0;       ///< how well the clouds agree; comparable between links of one pair
  bool doubtful = false;    ///< to be used only where loops of other links confirm it
  /// 0 to 1: how much the link says, by itself, for a placement of its stations that other pairs
  /// speak against.
  double credibility = 1.0;
};

struct PoseGraphOptions {
  bool robust = true;            ///< graduated non-convexity over truncated least squares
  double outlier_limit = 16.81;  ///< of the squared error: chi^2, 6 degrees of freedom, 99 %
  int max_iterations = 100;
};

struct PoseGraphResult {
  std::vector<RigidTransform> survey_from_station;  ///< identity for each component's first station
  std::vector<int> component;                       ///< per station, from 0, by first station
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

/// Squared error of a link under its information, at `poses` (survey_from_station).
double SquaredError(const PoseGraphLink& link, std::span<const RigidTransform> poses);

/// Stations that hold the datum: the first of each component.
std::vector<char> FirstOfEachComponent(const std::vector<int>& component);

/// Moves every component as a whole so that its first station is at the identity.
void ResetDatum(const std::vector<int>& component, std::vector<RigidTransform>* poses);

/// Least squares (Ceres) over the links with positive weight from the start values in `poses`;
/// stations with `fixed[s]` true stay. False if it did not converge; the poses are valid anyhow.
bool AdjustPoses(std::span<const PoseGraphLink> links, const std::vector<double>& weights,
                 const std::vector<char>& fixed, int max_iterations,
                 std::vector<RigidTransform>* poses);

/// Graduated non-convexity over truncated least squares (Yang et al. 2020, doi
/// 10.1109/LRA.2020.2965893) around AdjustPoses, from `start` and with its components: each link
/// ends with weight 0 or 1. Not robust: one adjustment with all links. `start` empty: a maximum
/// spanning forest by confidence. The components stay those of all links; covariance is left empty
/// (graph/network_covariance.h). A local method: where the start hangs on a false link, the result
/// may (graph/link_selection.h finds start values that do not).
PoseGraphResult SolvePoseGraph(int stations, std::span<const PoseGraphLink> links,
                               std::span<const RigidTransform> start,
                               const PoseGraphOptions& options);

}  // namespace backsight
