#include "stages/pair_prematch.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/rigid_fit.h"
#include "stages/matching.h"
#include "stages/plan_motions.h"

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

RigidTransform Refit(const Correspondences& c, const RigidTransform& motion, double limit_m) {
  const auto rows = RowsWithin(c, motion, limit_m);
  return FitRigid(c.Subset(rows), {}).value_or(motion);
}

/// Score of the best motion that the sketches' key points propose.
double BestOfKeypoints(const StationSketch& source, const StationSketch& target,
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
    best = std::max(best, MutualViewScore(source.surface, *source.model, target.surface,
                                          *target.model, motion));
  }
  return best;
}

/// Score of the best motion that the views from above propose; of levelled stations only.
double BestOfPlans(const StationSketch& source, const StationSketch& target,
                   const PrematchOptions& options) {
  if (!source.levelled || !target.levelled) return kNoMotion;
  const double cell_m = std::max(source.plan_cell_m(), target.plan_cell_m());
  const std::vector<ScoredMotion> motions = FindPlanMotions(
      {*source.model, source.PlanAt(cell_m), source.surface},
      {*target.model, target.PlanAt(cell_m), target.surface}, {.tried_turns = options.turns});
  return motions.empty() ? kNoMotion : motions.front().score;
}

}  // namespace

const PlanView& StationSketch::PlanAt(double cell_m) const {
  const auto plan = std::find_if(plans.begin(), plans.end(),
                                 [&](const PlanView& p) { return p.cell_m() == cell_m; });
  BACKSIGHT_CHECK(plan != plans.end(), "plans reach up to the largest cell of all stations");
  return *plan;
}

StationSketch SketchStation(const StationModel& model, const StationFeatures& features,
                            const PlanScale& plans, const PrematchOptions& options) {
  StationSketch sketch;
  sketch.model = &model;
  sketch.levelled = plans.cell_m > 0.0;
  const std::vector<double> rarity = Rarity(features.descriptors);
  std::vector<std::size_t> order(rarity.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rarity[a] > rarity[b]; });
  order.resize(std::min(order.size(), static_cast<std::size_t>(options.keypoints)));
  for (const std::size_t i : order) {
    sketch.positions.push_back(model.leaves.Mean(features.keypoints[i]));
    sketch.descriptors.push_back(features.descriptors[i]);
  }
  sketch.surface = SampleSurface(model, kViewSample);
  if (!sketch.levelled) return sketch;
  double cell_m = plans.cell_m;
  do {
    sketch.plans.emplace_back(model, features, cell_m, kPlanWalls);
    cell_m *= 2.0;
  } while (cell_m <= plans.largest_m);
  return sketch;
}

double PrematchPair(const StationSketch& source, const StationSketch& target,
                    const PrematchOptions& options, const ExecutionContext& context) {
  return std::max(BestOfKeypoints(source, target, options, context),
                  BestOfPlans(source, target, options));
}

}  // namespace backsight
