#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// By how much a closed chain of links fails to close, and how far that is to be expected.
struct Misclosure {
  Vector6d value = Vector6d::Zero();           ///< LocalDifference(product around, identity)
  Matrix6d covariance = Matrix6d::Identity();  ///< of value, to first order in the links' errors
  double SquaredError() const;                 ///< chi^2 with 6 degrees of freedom, if all is well
};

/// Goes once around: `loop` holds link indices so that consecutive links share a station, beginning
/// and ending at `start`. `covariances` are those of the links, in Retract's convention. The
/// product of the motions M1 M2 ... has the error sum Ad(M1 ... Mk-1) xi_k (and -Ad(T^-1) xi for a
/// link gone through backwards), which LocalDifferenceJacobian carries to `value` exactly.
Misclosure CloseLoop(std::span<const PoseGraphLink> links, std::span<const Matrix6d> covariances,
                     std::span<const int> loop, int start);

/// A triangle, or a loop of four links.
struct Cycle {
  std::array<int, 4> links{-1, -1, -1, -1};  ///< the last is -1 in a triangle
  int start = 0;                             ///< a station on it
  double rotation = 0.0;                     ///< misclosure, radians
  double translation = 0.0;                  ///< misclosure, metres
  double squared_error = 0.0;                ///< under the links' covariances as given
  std::span<const int> Links() const { return {links.data(), links[3] < 0 ? 3U : 4U}; }
};

/// What the cycles say of one link. Rivals of other links do not count twice: of all cycles over
/// the same stations, one that holds is enough.
struct LinkSupport {
  int valid = 0;       ///< station loops through the link that close
  int invalid = 0;     ///< and that do not
  int confirmed = 0;   ///< valid ones whose other links are all accepted, none doubtful
  int part_loops = 0;  ///< CountPartLoops'; CheckCycles leaves it 0
  int Score() const { return valid - invalid; }
};

struct CycleOptions {
  double limit = 16.81;  ///< of a cycle's squared error over the variance factor: chi^2_6, 99 %
  /// Of the variance; more disagreement is gross error, not noise. Thin real clouds reach 30 (the
  /// kitchen fragments of 3DMatch). Few loops cannot tell that from falsehood, so it is believed
  /// only of ten or more: the tenth part that closes best is then a loop at least.
  double largest_factor = 25.0;
  double largest_factor_of_many = 100.0;
  std::size_t many = 10;  ///< loops
};

/// Scale of the links' covariances.
struct VarianceScale {
  double factor = 1.0;   ///< at least 1
  double largest = 1.0;  ///< that was allowed
};

/// From the squared errors of loops, true and false: the median of those that fit to the factor,
/// found upwards from the tenth part that closes best, so that up to about 85 % may be false.
VarianceScale EstimateScale(const std::vector<double>& squared_errors, const CycleOptions& options);

struct CycleStatistics {
  std::vector<Cycle> cycles;
  std::vector<LinkSupport> support;  ///< per link
  VarianceScale scale;
};

/// All triangles, and for links on no triangle loops of four (at most 100 station loops for each).
/// Time O(links * links per station), times the number of rivals per pair cubed.
CycleStatistics CheckCycles(int stations, std::span<const PoseGraphLink> links,
                            const CycleOptions& options);

/// Covariance of a link: its information's inverse, with what it does not know held below 1 m and
/// 0.1 rad, so that a corridor's link has large but finite variances.
Matrix6d CovarianceOf(const Matrix6d& information);

}  // namespace backsight
