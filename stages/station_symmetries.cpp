#include "stages/station_symmetries.h"

#include <algorithm>
#include <numbers>

#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/rigid_fit.h"
#include "stages/structure_images.h"
#include "stages/surface_refinement.h"

namespace backsight {
namespace {

constexpr double kLeastScore = 0.25;
constexpr double kMostConflict = 0.1;
constexpr std::size_t kMost = 24;

/// Matches of key points with others, at least 10 l away.
Correspondences MatchWithItself(const Surface& surface, const StationFeatures& features,
                                const MatchingOptions& options) {
  MatchingOptions wider = options;
  ++wider.neighbors;  // each key point's first neighbour is itself
  const Correspondences all =
      MatchStations(surface.model, features, surface.model, features, wider);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < all.size(); ++row) {
    const double distance = (all.source[row] - all.target[row]).norm();
    if (distance > 10.0 * surface.model.resolution_m()) rows.push_back(row);
  }
  return all.Subset(rows);
}

struct Scored {
  RigidTransform motion;
  double score = 0.0;
};

class SymmetryList {
 public:
  SymmetryList(const Surface& surface, const CloudIndex& index) : surface_(surface), index_(index) {
    const std::vector<Eigen::Vector3d>& points = index.sample.points;
    const auto count = static_cast<double>(points.size());
    for (const Eigen::Vector3d& point : points) center_ += point / count;
  }

  void Offer(const RigidTransform& motion) {
    if (Alike(motion, {})) return;
    for (const Scored& other : list_) {
      if (Alike(motion, other.motion)) return;
    }
    const double tolerance_m = 2.0 * surface_.model.resolution_m();
    CloudAgreement agreement;
    for (const CloudSample* sample : {&index_.sieve, &index_.sample}) {
      agreement = CompareClouds(surface_, *sample, surface_, index_, motion, tolerance_m);
      if (agreement.score < kLeastScore || agreement.conflict.value >= kMostConflict) return;
    }
    list_.push_back({motion, agreement.score});
  }

  /// Whether a motion that is only roughly right is worth refining.
  bool MayHold(const RigidTransform& motion) const {
    const double tolerance_m = 2.0 * surface_.model.resolution_m();
    const CloudAgreement agreement =
        CompareClouds(surface_, index_.sieve, surface_, index_, motion, tolerance_m);
    return !Alike(motion, {}) && agreement.score > 0.5 * kLeastScore &&
           agreement.conflict.value < 2.0 * kMostConflict;
  }

  std::vector<RigidTransform> Take() {
    std::stable_sort(list_.begin(), list_.end(),
                     [](const Scored& a, const Scored& b) { return a.score > b.score; });
    std::vector<RigidTransform> motions;
    for (const Scored& entry : list_) {
      if (motions.size() < kMost) motions.push_back(entry.motion);
    }
    return motions;
  }

 private:
  bool Alike(const RigidTransform& a, const RigidTransform& b) const {
    constexpr double kNearAngle = 5.0 * std::numbers::pi / 180.0;
    return (a * center_ - b * center_).norm() < 10.0 * surface_.model.resolution_m() &&
           RotationAngle(a.rotation, b.rotation) < kNearAngle;
  }

  const Surface& surface_;
  const CloudIndex& index_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  std::vector<Scored> list_;
};

}  // namespace

std::vector<RigidTransform> FindSymmetries(const Surface& surface, const StationFeatures& features,
                                           const CloudIndex& index, const MatchingOptions& matching,
                                           const CoarseOptions& coarse,
                                           const ExecutionContext& context) {
  const double l = surface.model.resolution_m();
  SymmetryList list(surface, index);
  const Correspondences c = MatchWithItself(surface, features, matching);
  const ReliableNodes nodes =
      SelectReliableNodes(c, {.resolution_m = l, .keep = coarse.nodes}, context);
  for (const EdgeHypothesis& h : FindEdgeHypotheses(c.Subset(nodes.rows),
                                                    {.resolution_m = l,
                                                    .edges_per_node = coarse.edges_per_node,
                                                    .hypotheses = coarse.hypotheses},
                                                    context)) {
    const RigidTransform motion = RefineOnInliers(c, h.target_from_source, 3.0 * l);
    list.Offer(motion);
    list.Offer(motion.Inverse());
  }
  for (const RigidTransform& image : FindStructureImages(surface, index, surface, index, {})) {
    if (!list.MayHold(image)) continue;
    // A shift by correlation is good to some voxels; surfaces make it good to a fraction of one.
    const RigidTransform motion = RefineRoughly(surface, surface, index, image);
    list.Offer(motion);
    list.Offer(motion.Inverse());
  }
  return list.Take();
}

}  // namespace backsight
