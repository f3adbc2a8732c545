#include "graph/edge_consensus.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace backsight {
namespace {

/// Nodes that an edge may start from, with their compatible partners in order of reliability.
struct NodePartners {
  std::uint32_t node = 0;
  int compatible = 0;                   // how many later nodes are compatible
  std::vector<std::uint32_t> partners;  // the first few of them
};

/// Whether two vectors, one in each cloud, rise alike; true where nobody says that z is up.
bool RiseAlike(const Eigen::Vector3d& in_source, const Eigen::Vector3d& in_target, double limit,
               const std::optional<UprightConstraint>& upright) {
  return !upright ||
         std::abs(in_source.z() - in_target.z()) < upright->Tolerance(in_source.norm(), limit);
}

std::vector<NodePartners> FindPartners(const Correspondences& c,
                                       const EdgeReliabilityOptions& options,
                                       const ExecutionContext& context) {
  const double limit = 2.0 * options.resolution_m;
  std::vector<NodePartners> nodes(c.size());
  context.ParallelFor(
      c.size(),
      [&](std::size_t i) {
        NodePartners& node = nodes[i];
        node.node = static_cast<std::uint32_t>(i);
        for (std::size_t j = i + 1; j < c.size(); ++j) {
          const double in_target = (c.target[i] - c.target[j]).norm();
          const double in_source = (c.source[i] - c.source[j]).norm();
          // Shorter edges than 2 l have no meaningful direction.
          if (std::abs(in_target - in_source) >= limit || std::min(in_target, in_source) <= limit) {
            continue;
          }
          if (!RiseAlike(c.source[j] - c.source[i], c.target[j] - c.target[i], limit,
                         options.upright)) {
            continue;
          }
          ++node.compatible;
          if (static_cast<int>(node.partners.size()) < options.edges_per_node) {
            node.partners.push_back(static_cast<std::uint32_t>(j));
          }
        }
      },
      32);
  std::erase_if(nodes,
                [&](const NodePartners& n) { return n.compatible < options.min_compatible; });
  std::stable_sort(nodes.begin(), nodes.end(), [](const NodePartners& a, const NodePartners& b) {
    return a.compatible > b.compatible;
  });
  return nodes;
}

/// The edge from node i to node j: both end points and unit directions in both clouds.
struct Edge {
  Edge(const Correspondences& c, std::uint32_t i, std::uint32_t j)
      : source(c.source[i]),
        target(c.target[i]),
        source_axis((c.source[j] - c.source[i]).normalized()),
        target_axis((c.target[j] - c.target[i]).normalized()),
        middle_shift(0.5 * ((c.target[j] - c.target[i]) -
                            (c.source[j] - c.source[i]).norm() * target_axis)) {}
  Eigen::Vector3d source, target;            // of node i
  Eigen::Vector3d source_axis, target_axis;  // from i to j
  Eigen::Vector3d middle_shift;              // centres the length difference on both ends
};

/// Necessary condition for a node to agree with the edge under some rotation about it: equal
/// distance from node i and equal signed projection on the edge, both within 2 l.
std::vector<std::uint32_t> LooseCandidates(const Correspondences& c, const Edge& edge, double limit,
                                           const std::optional<UprightConstraint>& upright) {
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t k = 0; k < c.size(); ++k) {
    const Eigen::Vector3d s = c.source[k] - edge.source;
    const Eigen::Vector3d m = c.target[k] - edge.target;
    if (std::abs(s.norm() - m.norm()) < limit &&
        std::abs(s.dot(edge.source_axis) - m.dot(edge.target_axis)) < limit &&
        RiseAlike(s, m, limit, upright)) {
      candidates.push_back(k);
    }
  }
  return candidates;
}

/// The minimal rotation that takes unit vector a to unit vector b, a half turn about any normal
/// axis where they are opposite.
Eigen::Matrix3d MinimalRotation(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return Eigen::Quaterniond::FromTwoVectors(a, b).toRotationMatrix();
}

/// Tight reliability of an edge (paper Eq. 5 with the alignment that must precede it): after moving
/// the edge onto its target, each candidate is satisfied for an interval of rotation angles about
/// it; the best stabbing angle gives the hypothesis.
EdgeHypothesis TightConsensus(const Correspondences& c, const Edge& edge,
                              std::span<const std::uint32_t> candidates, double limit) {
  const Eigen::Matrix3d align = MinimalRotation(edge.source_axis, edge.target_axis);
  const Eigen::Vector3d axis = edge.target_axis;
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);

  std::vector<AngleInterval> intervals;
  intervals.reserve(candidates.size());
  for (const std::uint32_t k : candidates) {
    const Eigen::Vector3d m = align * (c.source[k] - edge.source) + edge.middle_shift;
    const Eigen::Vector3d q = c.target[k] - edge.target;
    const double radius_m = std::hypot(m.dot(u), m.dot(v));
    const double radius_q = std::hypot(q.dot(u), q.dot(v));
    const double along = q.dot(axis) - m.dot(axis);
    // |Rz(angle) m - q|^2 <= limit^2  <=>  cos(angle - (azimuth_q - azimuth_m)) >= kappa
    const double rest = (radius_m - radius_q) * (radius_m - radius_q) + along * along;
    if (rest > limit * limit) continue;
    const double product = 2.0 * radius_m * radius_q;
    const double kappa =
        product > 1e-12
            ? (radius_m * radius_m + radius_q * radius_q + along * along - limit * limit) / product
            : -1.0;
    if (kappa <= -1.0) {
      intervals.push_back({0.0, 2.0 * std::numbers::pi, c.source_id[k]});
      continue;
    }
    const double half_width = std::acos(std::min(kappa, 1.0));
    const double center = std::atan2(q.dot(v), q.dot(u)) - std::atan2(m.dot(v), m.dot(u));
    intervals.push_back({center - half_width, center + half_width, c.source_id[k]});
  }

  const StabbingResult stabbed = StabIntervals(intervals);
  EdgeHypothesis hypothesis;
  hypothesis.consensus = stabbed.count;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(stabbed.angle, axis).toRotationMatrix();
  hypothesis.target_from_source.rotation = turn * align;
  hypothesis.target_from_source.translation =
      edge.target + turn * (edge.middle_shift - align * edge.source);
  return hypothesis;
}

/// The same for levelled instruments: the edge's bearings give the one angle that is left. Edges
/// steeper than 60 deg have no sure bearing and give no consensus.
EdgeHypothesis UprightConsensus(const Correspondences& c, const Edge& edge,
                                std::span<const std::uint32_t> candidates, double limit) {
  EdgeHypothesis hypothesis;
  constexpr double kFlat = 0.5;
  const Eigen::Vector2d in_source = edge.source_axis.head<2>();
  const Eigen::Vector2d in_target = edge.target_axis.head<2>();
  if (std::min(in_source.norm(), in_target.norm()) < kFlat) return hypothesis;
  const double turn =
      std::atan2(in_target.y(), in_target.x()) - std::atan2(in_source.y(), in_source.x());
  RigidTransform& motion = hypothesis.target_from_source;
  motion.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  motion.translation = edge.target + edge.middle_shift - motion.rotation * edge.source;
  std::vector<std::uint32_t> ids;
  for (const std::uint32_t k : candidates) {
    if ((motion * c.source[k] - c.target[k]).norm() < limit) ids.push_back(c.source_id[k]);
  }
  std::sort(ids.begin(), ids.end());
  hypothesis.consensus = static_cast<int>(std::unique(ids.begin(), ids.end()) - ids.begin());
  return hypothesis;
}

/// Keeps the best distinct hypotheses in order.
class HypothesisList {
 public:
  HypothesisList(std::size_t capacity, const Eigen::Vector3d& centroid, double resolution_m)
      : capacity_(capacity), centroid_(centroid), near_m_(6.0 * resolution_m) {}

  /// A hypothesis must gather more than this to enter.
  int EntryBar() const { return list_.size() < capacity_ ? 3 : list_.back().consensus; }

  void Insert(const EdgeHypothesis& hypothesis) {
    if (hypothesis.consensus <= EntryBar()) return;
    for (const EdgeHypothesis& other : list_) {
      if (Near(other, hypothesis) && other.consensus >= hypothesis.consensus) return;
    }
    std::erase_if(list_, [&](const EdgeHypothesis& other) { return Near(other, hypothesis); });
    const auto place = std::find_if(list_.begin(), list_.end(), [&](const EdgeHypothesis& other) {
      return other.consensus < hypothesis.consensus;
    });
    list_.insert(place, hypothesis);
    if (list_.size() > capacity_) list_.pop_back();
  }

  std::vector<EdgeHypothesis> Take() { return std::move(list_); }

 private:
  bool Near(const EdgeHypothesis& a, const EdgeHypothesis& b) const {
    constexpr double kNearAngle = 2.0 * std::numbers::pi / 180.0;
    return (a.target_from_source * centroid_ - b.target_from_source * centroid_).norm() < near_m_ &&
           RotationAngle(a.target_from_source.rotation, b.target_from_source.rotation) < kNearAngle;
  }

  std::size_t capacity_;
  Eigen::Vector3d centroid_;
  double near_m_;
  std::vector<EdgeHypothesis> list_;
};

Eigen::Vector3d Centroid(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
}

}  // namespace

std::vector<EdgeHypothesis> FindEdgeHypotheses(const Correspondences& c,
                                               const EdgeReliabilityOptions& options,
                                               const ExecutionContext& context) {
  const double limit = 2.0 * options.resolution_m;
  HypothesisList best(static_cast<std::size_t>(options.hypotheses), Centroid(c.source),
                      options.resolution_m);
  for (const NodePartners& node : FindPartners(c, options, context)) {
    for (const std::uint32_t partner : node.partners) {
      const Edge edge(c, node.node, partner);
      const auto candidates = LooseCandidates(c, edge, limit, options.upright);
      if (static_cast<int>(candidates.size()) <= best.EntryBar()) continue;
      best.Insert(options.upright ? UprightConsensus(c, edge, candidates, limit)
                                  : TightConsensus(c, edge, candidates, limit));
    }
  }
  return best.Take();
}

}  // namespace backsight
