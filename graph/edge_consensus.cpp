#include "graph/edge_consensus.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/edge_evaluator.h"
#include "graph/edge_length.h"
#include "graph/pair_columns.h"
#include "graph/reliability_kernels.h"

namespace backsight {
namespace {

/// Nodes that an edge may start from, with their compatible partners in order of reliability.
struct NodePartners {
  std::uint32_t node = 0;
  int compatible = 0;                   // how many later nodes are compatible
  std::vector<std::uint32_t> partners;  // the first few of them
};

void CountPartners(const Correspondences& c, std::span<const std::uint32_t> later,
                   const EdgeReliabilityOptions& options, NodePartners* node) {
  const double limit = 2.0 * options.resolution_m;  // shorter edges have no meaningful direction
  const std::size_t i = node->node;
  for (const std::uint32_t j : later) {
    const Eigen::Vector3d in_source = c.source[j] - c.source[i];
    const Eigen::Vector3d in_target = c.target[j] - c.target[i];
    if (!AreOneLength(in_source, in_target, limit)) continue;
    if (!RiseAlike(in_source, in_target, limit, options.upright)) continue;
    ++node->compatible;
    if (static_cast<int>(node->partners.size()) < options.edges_per_node) {
      node->partners.push_back(j);
    }
  }
}

std::vector<NodePartners> FindPartners(const Correspondences& c, const PairColumns& columns,
                                       const EdgeReliabilityOptions& options,
                                       const ExecutionContext& context) {
  const auto limit = static_cast<float>(2.0 * options.resolution_m);
  std::vector<NodePartners> nodes(c.size());
  constexpr std::size_t kNodes = 32;  // at a time
  context.ParallelFor((c.size() + kNodes - 1) / kNodes, [&](std::size_t chunk) {
    std::vector<std::uint32_t> later(c.size() + PairColumns::kPadding);
    for (std::size_t i = chunk * kNodes; i < std::min((chunk + 1) * kNodes, c.size()); ++i) {
      nodes[i].node = static_cast<std::uint32_t>(i);
      const std::size_t count =
          FindSameLength(View(columns), i, i + 1, limit, Slack(columns), later.data());
      CountPartners(c, std::span(later).first(count), options, &nodes[i]);
    }
  });
  std::erase_if(nodes,
                [&](const NodePartners& n) { return n.compatible < options.min_compatible; });
  std::stable_sort(nodes.begin(), nodes.end(), [](const NodePartners& a, const NodePartners& b) {
    return a.compatible > b.compatible;
  });
  return nodes;
}

/// Keeps the best distinct hypotheses in order.
class HypothesisList {
 public:
  HypothesisList(std::size_t capacity, const Eigen::Vector3d& centroid, double resolution_m)
      : capacity_(capacity),
        nearness_{centroid, 2.0 * std::numbers::pi / 180.0, 6.0 * resolution_m} {}

  KnownHypotheses Known() const { return {list_, nearness_}; }

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
    return nearness_.IsNear(a.target_from_source, b.target_from_source);
  }

  std::size_t capacity_;
  HypothesisNearness nearness_;
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
  const PairColumns columns(c);
  HypothesisList best(static_cast<std::size_t>(options.hypotheses), Centroid(c.source),
                      options.resolution_m);
  EdgeEvaluator evaluator(c, columns, 2.0 * options.resolution_m, options.upright);
  for (const NodePartners& node : FindPartners(c, columns, options, context)) {
    for (const std::uint32_t partner : node.partners) {
      const auto hypothesis = evaluator.Evaluate(node.node, partner, best.EntryBar(), best.Known());
      if (hypothesis) best.Insert(*hypothesis);
    }
  }
  return best.Take();
}

}  // namespace backsight
