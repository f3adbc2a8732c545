#include "stages/pair_prematch.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/rigid_fit.h"
#include "stages/matching.h"

namespace backsight {
namespace {

using Bins = Eigen::Array<double, 33, 1>;
constexpr double kNoMotion = -2.0;
constexpr double kLargestTilt = 0.035;  // rad, 2 deg: of a rough motion between levelled stations

Bins ToBins(const FpfhDescriptor& descriptor) {
  return Eigen::Map<const Eigen::Array<float, 33, 1>>(descriptor.data()).cast<double>();
}

/// Squared distance of each descriptor from their mean, each bin in units of its variance.
std::vector<double> Rarity(const std::vector<FpfhDescriptor>& descriptors) {
  Bins sum = Bins::Zero();
  Bins squares = Bins::Zero();
  for (const FpfhDescriptor& descriptor : descriptors) {
    const Bins bins = ToBins(descriptor);
    sum += bins, squares += bins * bins;
  }
  const double n = std::max(1.0, static_cast<double>(descriptors.size()));
  const Bins mean = sum / n;
  // One more square unit: bins that are always empty must not count for infinitely much.
  const Bins variance = (squares / n - mean * mean).max(0.0) + 1.0;
  std::vector<double> rarity;
  rarity.reserve(descriptors.size());
  for (const FpfhDescriptor& descriptor : descriptors) {
    rarity.push_back(((ToBins(descriptor) - mean).square() / variance).sum());
  }
  return rarity;
}

/// Share of the surface that the viewer saw at its place minus the share that it saw through.
double ViewScore(const std::vector<Eigen::Vector3d>& surface, const StationModel& viewer,
                 const RigidTransform& viewer_from_surface) {
  int score = 0;
  for (const Eigen::Vector3d& sample : surface) {
    const Eigen::Vector3d point = viewer_from_surface * sample;
    const auto farthest = static_cast<double>(viewer.range_image.At(point).max_m);
    if (farthest == 0.0) continue;
    const double range = point.norm();
    // As in the verification: three voxels and what 1 degree of incidence or pointing makes of it.
    const double tolerance = std::min(3.0 * viewer.resolution_m() + 0.02 * range, 1.0);
    if (range < farthest - tolerance) {
      --score;
    } else if (range <= farthest + tolerance) {
      ++score;
    }
  }
  return surface.empty() ? 0.0 : static_cast<double>(score) / static_cast<double>(surface.size());
}

RigidTransform Refit(const Correspondences& c, const RigidTransform& motion, double limit_m) {
  const auto rows = RowsWithin(c, motion, limit_m);
  return FitRigid(c.Subset(rows), {}).value_or(motion);
}

}  // namespace

StationSketch SketchStation(const StationModel& model, const StationFeatures& features,
                            bool levelled, const PrematchOptions& options) {
  StationSketch sketch;
  sketch.model = &model;
  sketch.levelled = levelled;
  const std::vector<double> rarity = Rarity(features.descriptors);
  std::vector<std::size_t> order(rarity.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rarity[a] > rarity[b]; });
  order.resize(std::min(order.size(), static_cast<std::size_t>(options.keypoints)));
  for (const std::size_t i : order) {
    sketch.positions.push_back(model.leaves[features.keypoints[i]].cluster.mean);
    sketch.descriptors.push_back(features.descriptors[i]);
  }
  const std::size_t count =
      std::min(model.leaves.size(), static_cast<std::size_t>(options.surface));
  for (std::size_t i = 0; i < count; ++i) {
    sketch.surface.push_back(model.leaves[i * model.leaves.size() / count].cluster.mean);
  }
  return sketch;
}

double PrematchPair(const StationSketch& source, const StationSketch& target,
                    const PrematchOptions& options, const ExecutionContext& context) {
  const double l = target.model->resolution_m();
  Correspondences c;
  for (const DescriptorMatch& match :
       MatchDescriptors(source.descriptors, target.descriptors, {.neighbors = options.neighbors})) {
    c.Add(source.positions[match.source], target.positions[match.target], match.source,
          match.target);
  }
  if (c.size() < 3) return kNoMotion;
  std::optional<UprightConstraint> upright;
  if (source.levelled && target.levelled) upright = UprightConstraint{kLargestTilt};
  const ReliableNodes nodes = SelectReliableNodes(
      c, {.resolution_m = l, .keep = options.nodes, .upright = upright}, context);
  double best = kNoMotion;
  for (const EdgeHypothesis& hypothesis : FindEdgeHypotheses(c.Subset(nodes.rows),
                                                             {.resolution_m = l,
                                                             .min_compatible = 5,
                                                             .hypotheses = options.hypotheses,
                                                             .upright = upright},
                                                             context)) {
    const RigidTransform motion = Refit(c, hypothesis.target_from_source, 3.0 * l);
    if (upright && RelativeTilt(motion) > kLargestTilt) continue;
    best = std::max(best, ViewScore(source.surface, *target.model, motion) +
                              ViewScore(target.surface, *source.model, motion.Inverse()));
  }
  return best;
}

}  // namespace backsight
