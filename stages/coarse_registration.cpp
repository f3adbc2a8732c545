#include "stages/coarse_registration.h"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "core/random.h"
#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/rigid_fit.h"
#include "stages/matching.h"

namespace backsight {
namespace {

std::vector<EdgeHypothesis> FindHypotheses(const Correspondences& c, double resolution_m,
                                           const CoarseOptions& options, int hypotheses,
                                           const ExecutionContext& context) {
  const ReliableNodes nodes =
      SelectReliableNodes(c, {.resolution_m = resolution_m, .keep = options.nodes}, context);
  return FindEdgeHypotheses(c.Subset(nodes.rows),
                            {.resolution_m = resolution_m,
                             .edges_per_node = options.edges_per_node,
                             .hypotheses = hypotheses},
                            context);
}

int DistinctSources(const Correspondences& c, const RigidTransform& transform, double limit_m) {
  std::unordered_set<std::uint32_t> ids;
  for (const std::uint32_t row : RowsWithin(c, transform, limit_m)) ids.insert(c.source_id[row]);
  return static_cast<int>(ids.size());
}

/// MSAC score over distinct source key points: sum of 1 - r^2 / limit^2, each key point's best row.
double Score(const Correspondences& c, const RigidTransform& transform, double limit_m) {
  std::unordered_map<std::uint32_t, double> best;
  for (std::size_t a = 0; a < c.size(); ++a) {
    const double r2 = (transform * c.source[a] - c.target[a]).squaredNorm();
    const double gain = 1.0 - r2 / (limit_m * limit_m);
    if (gain <= 0.0) continue;
    double& entry = best[c.source_id[a]];
    entry = std::max(entry, gain);
  }
  std::vector<double> gains;  // summed in sorted order, so that hashing does not reach the result
  gains.reserve(best.size());
  for (const auto& [id, gain] : best) gains.push_back(gain);
  std::sort(gains.begin(), gains.end());
  double sum = 0.0;
  for (const double gain : gains) sum += gain;
  return sum;
}

/// A few rounds of collecting and refitting pull a hypothesis from one edge to its whole consensus.
RigidTransform Refine(const Correspondences& c, RigidTransform transform, double limit_m) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const auto rows = RowsWithin(c, transform, limit_m);
    const auto fit = FitRigid(c.Subset(rows), {});
    if (!fit) break;
    transform = *fit;
  }
  return transform;
}

int NullConsensus(const Correspondences& c, double resolution_m, const CoarseOptions& options,
                  std::uint64_t seed, const ExecutionContext& context) {
  int best = 0;
  for (int run = 0; run < options.permutations; ++run) {
    Correspondences shuffled = c;
    Random random(DeriveSeed(seed, "permutation " + std::to_string(run)));
    for (std::size_t i = c.size() - 1; i > 0; --i) {
      const std::size_t j = random.Index(i + 1);
      std::swap(shuffled.target[i], shuffled.target[j]);
      std::swap(shuffled.target_id[i], shuffled.target_id[j]);
    }
    for (const EdgeHypothesis& h :
         FindHypotheses(shuffled, resolution_m, options, /*hypotheses=*/1, context)) {
      best = std::max(best, h.consensus);
    }
  }
  return best;
}

/// C2: all of C1 within 3 l of the hypothesis, and the key points that positions match there.
Correspondences CollectInliers(const CoarseInput& input, const RigidTransform& hypothesis) {
  const double limit_m = 3.0 * input.resolution_m;
  const Correspondences& c1 = input.correspondences;
  Correspondences c2 = c1.Subset(RowsWithin(c1, hypothesis, limit_m));
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;
  for (std::size_t a = 0; a < c2.size(); ++a) known.emplace(c2.source_id[a], c2.target_id[a]);
  const Correspondences near =
      MatchPositions(input.source_keypoints, input.target_keypoints, hypothesis, limit_m);
  for (std::size_t a = 0; a < near.size(); ++a) {
    if (known.contains({near.source_id[a], near.target_id[a]})) continue;
    c2.Add(near.source[a], near.target[a], near.source_id[a], near.target_id[a]);
  }
  return c2;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, CoarseOptions& options) {
  visitor.Integer("nodes", options.nodes, "1", 10, 20000,
                  "correspondences kept by node reliability (K_opt)");
  visitor.Integer("edges_per_node", options.edges_per_node, "1", 1, 100,
                  "edges tried per correspondence");
  visitor.Integer("hypotheses", options.hypotheses, "1", 1, 1000,
                  "distinct coarse hypotheses compared");
  visitor.Integer("permutations", options.permutations, "1", 0, 100,
                  "runs on shuffled correspondences that tell consensus from chance");
}

CoarseResult RegisterCoarse(const CoarseInput& input, const CoarseOptions& options,
                            const ExecutionContext& context) {
  CoarseResult result;
  const Correspondences& c = input.correspondences;
  if (c.size() < 3) return result;
  const double l = input.resolution_m;
  result.status = CoarseResult::Status::kNoConsensus;
  result.consensus_null = NullConsensus(c, l, options, input.seed, context);

  double best_score = 0.0;
  RigidTransform best;
  for (const EdgeHypothesis& h : FindHypotheses(c, l, options, options.hypotheses, context)) {
    const RigidTransform refined = Refine(c, h.target_from_source, 3.0 * l);
    const double score =
        input.cloud_score ? input.cloud_score(refined) : Score(c, refined, 3.0 * l);
    if (score > best_score) best_score = score, best = refined;
  }
  if (best_score == 0.0) return result;

  const Correspondences c2 = CollectInliers(input, best);
  const GncWelschResult gnc = EstimateGncWelsch(c2, best, {.resolution_m = l});
  if (gnc.status == GncWelschResult::Status::kDegenerate) {
    result.status = CoarseResult::Status::kDegenerate;
    return result;
  }
  result.status = CoarseResult::Status::kRegistered;
  result.target_from_source = gnc.target_from_source;
  result.information = gnc.information;
  result.sigma_m = gnc.residual_sd_m;
  result.consensus = DistinctSources(c, gnc.target_from_source, 2.0 * l);
  result.inliers = RowsWithin(c, gnc.target_from_source, 4.0 * l);
  return result;
}

}  // namespace backsight
