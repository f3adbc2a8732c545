#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "core/option_visitor.h"
#include "graph/cycle_consistency.h"
#include "graph/link_selection.h"
#include "graph/network_covariance.h"
#include "graph/pose_graph.h"

namespace backsight {

struct NetworkOptions {
  bool robust = true;
  double floor_rotation_deg = 0.003;  ///< systematic error of any link, per axis
  double floor_translation_m = 0.001;
  double score_noise = 0.01;  ///< standard deviation of NetworkLink::score
};
void VisitOptions(OptionVisitor& visitor, NetworkOptions& options);

/// One possible motion of one pair as it enters the network. Instrument frames.
struct NetworkLink {
  int pair = 0;  ///< links of one pair exclude each other: rival hypotheses
  int source = 0;
  int target = 0;
  RigidTransform target_from_source;
  Matrix6d information = Matrix6d::Zero();  ///< formal, from the registration
  double confidence = 0.0;                  ///< planes times overlap; spanning tree, among equals
  double score = 0.0;        ///< how well the clouds agree under it; between rivals of one pair
  bool doubtful = false;     ///< used only where loops of other links confirm it
  double credibility = 1.0;  ///< PoseGraphLink::credibility
};

/// Covariance of a link as the network takes it: what the registration claims, held above the
/// systematic floor; not scaled by the links' variance factor.
Matrix6d LinkCovariance(const NetworkLink& link, const NetworkOptions& options);

/// How far a link lies from a motion of its stations in standard deviations of LinkCovariance, rms
/// over the six unknowns: 1 where the covariance is right and the motion exact; NaN where the
/// covariance is not one.
double ResidualInSigmas(const NetworkLink& link, const RigidTransform& target_from_source,
                        const NetworkOptions& options);

/// How a triangle of used links closes, before adjustment: measured motions alone.
struct TriangleClosure {
  int a = 0, b = 0, c = 0;  ///< stations, ascending
  double rotation_deg = 0.0;
  double translation_m = 0.0;
  double squared_error =
      0.0;  ///< under the links' scaled covariances: chi^2 with 6 degrees of freedom
};

/// Everything by link is in the order of the links given. Links that are not used have the residual
/// against the solution where both ends hang together.
struct NetworkResult {
  PoseGraphResult poses;  ///< weights: 1 used, 0 not; covariance scaled
  std::vector<LinkFate> fate;
  std::vector<bool> loop_controlled;  ///< used, and its ends hang together without it
  /// Of target_from_source between the link's stations in the adjusted network; zero where they are
  /// in different components.
  std::vector<Matrix6d> link_covariance;
  std::vector<LinkSupport> support;  ///< by cycles over all links given
  /// Square root of the links' variance factor: by how much they disagree beyond what they claim,
  /// at least 1. It is in all covariances.
  double sigma_factor = 1.0;
  /// Its estimate from the triangles and loops of four before adjustment.
  double cycle_sigma_factor = 1.0;
  int redundancy = 0;  ///< observations minus unknowns, used links
  std::vector<TriangleClosure> closures;
  Eigen::MatrixXd covariance;  ///< joint, of all poses, scaled (graph/network_covariance.h)
  WeakestDirection weakest;
  std::vector<Ambiguity> ambiguities;
  int removed = 0;     ///< links given and not used
  int readmitted = 0;  ///< links used that contradicted the first spanning tree
  int moves = 0;       ///< stations or parts moved to better places
};

/// The links that SolveNetwork would use and the poses that they give, without covariances: for a
/// network that is still growing. `between`, called between adjustments, may throw to give up.
LinkSelection ChooseLinks(int stations, std::span<const NetworkLink> links,
                          const NetworkOptions& options, const std::function<void()>& between = {});

/// Fuses the pairs to one pose per station (survey frame of each component: the instrument frame of
/// its first station). Chooses among rival motions and removes false ones (graph/link_selection.h)
/// unless `robust` is off; then every link counts, doubtful or not, and pairs must have no rivals.
/// The links' scale of error is estimated from how their cycles close, then from the adjustment's
/// own redundancy. No transform is invented: parts that no usable link joins stay components. Cost:
/// a few sparse adjustments and one dense inverse, seconds for 200 stations. `between` as above.
NetworkResult SolveNetwork(int stations, std::span<const NetworkLink> links,
                           const NetworkOptions& options,
                           const std::function<void()>& between = {});

}  // namespace backsight
