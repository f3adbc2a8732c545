#include "stages/coarse_registration.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "core/random.h"
#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/rigid_fit.h"
#include "stages/aligned_hypotheses.h"
#include "stages/matching.h"
#include "stages/motion_pool.h"

namespace backsight {
namespace {

std::vector<EdgeHypothesis> FindHypotheses(const Correspondences& c, const CoarseInput& input,
                                           const CoarseOptions& options, int hypotheses,
                                           const ExecutionContext& context) {
  std::optional<UprightConstraint> upright;
  if (input.max_tilt_rad) upright = UprightConstraint{*input.max_tilt_rad};
  const ReliableNodes nodes = SelectReliableNodes(
      c, {.resolution_m = input.resolution_m, .keep = options.nodes, .upright = upright}, context);
  return FindEdgeHypotheses(c.Subset(nodes.rows),
                            {.resolution_m = input.resolution_m,
                             .edges_per_node = options.edges_per_node,
                             .hypotheses = hypotheses,
                             .upright = upright},
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

int NullConsensus(const CoarseInput& input, const CoarseOptions& options,
                  const ExecutionContext& context) {
  const Correspondences& c = input.correspondences;
  int best = 0;
  for (int run = 0; run < options.permutations; ++run) {
    Correspondences shuffled = c;
    Random random(DeriveSeed(input.seed, "permutation " + std::to_string(run)));
    for (std::size_t i = c.size() - 1; i > 0; --i) {
      const std::size_t j = random.Index(i + 1);
      std::swap(shuffled.target[i], shuffled.target[j]);
      std::swap(shuffled.target_id[i], shuffled.target_id[j]);
    }
    for (const EdgeHypothesis& h :
         FindHypotheses(shuffled, input, options, /*hypotheses=*/1, context)) {
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

/// Score of the correspondences alone; `input` must outlive it.
MotionScore ScoreOfRows(const CoarseInput& input) {
  return [&input](const RigidTransform& motion) {
    return Score(input.correspondences, motion, 3.0 * input.resolution_m);
  };
}

MotionPool MakePool(const CoarseInput& input, MotionScore score, MotionScore bound) {
  const Correspondences& c = input.correspondences;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : c.source) center += point / static_cast<double>(c.size());
  return {center, 10.0 * input.resolution_m, input.max_tilt_rad, std::move(score),
          std::move(bound)};
}

/// What RGE found, what votes for known rotations found, what others propose, and the images of the
/// best of it under the clouds' own symmetries.
MotionPool CollectMotions(const CoarseInput& input, const CoarseOptions& options,
                          const ExecutionContext& context) {
  const Correspondences& c = input.correspondences;
  const double limit_m = 3.0 * input.resolution_m;
  MotionPool pool = MakePool(input, input.cloud_score ? input.cloud_score : ScoreOfRows(input),
                             input.cloud_score_bound);
  for (const EdgeHypothesis& h : FindHypotheses(c, input, options, options.hypotheses, context)) {
    pool.Add(RefineOnInliers(c, h.target_from_source, limit_m));
  }
  for (const Correspondences* ballots : {&c, &input.ballots}) {
    for (const RigidTransform& motion :
         VoteForTranslations(*ballots, input.rotations, input.resolution_m,
                             static_cast<std::size_t>(options.votes))) {
      pool.Add(motion);
    }
  }
  for (const RigidTransform& proposal : input.proposals) {
    pool.Add(input.cloud_refine ? input.cloud_refine(proposal) : proposal);
  }
  if (pool.empty()) return pool;
  const RigidTransform best = pool.Best(1).front().motion;
  for (const RigidTransform& symmetry : input.target_symmetries) pool.Add(symmetry * best);
  for (const RigidTransform& symmetry : input.source_symmetries) pool.Add(best * symmetry);
  if (input.structure_images) {
    for (const RigidTransform& image : input.structure_images(best)) pool.Add(image);
  }
  return pool;
}

/// The best few improved, so that votes, which are rough, compete fairly.
MotionPool ImproveRough(const CoarseInput& input, MotionPool* pool) {
  constexpr std::size_t kImproved = 30;
  MotionPool improved = MakePool(input, input.cloud_score, input.cloud_score_bound);
  for (const ScoredMotion& entry : pool->Best(kImproved)) {
    improved.Add(input.cloud_refine(entry.motion));
  }
  return improved;
}

/// The motion and its neighbours 3 l away, each improved by the clouds; the best of them. Repeated
/// details, such as shelves, hold a motion in place that is off by one of them.
RigidTransform ImproveFromAround(const CoarseInput& input, const RigidTransform& motion) {
  RigidTransform best = input.cloud_refine(motion);
  double best_score = input.cloud_score(best);
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      if (x == 0 && y == 0) continue;
      RigidTransform start = motion;
      start.translation += 3.0 * input.resolution_m * Eigen::Vector3d(x, y, 0.0);
      const RigidTransform improved = input.cloud_refine(start);
      const double score = input.cloud_score(improved);
      if (score <= best_score) continue;
      best_score = score;
      best = improved;
    }
  }
  return best;
}

/// The best few, improved by the clouds and scored on more of them; all but the first two must be
/// worth something before.
std::vector<ScoredMotion> ImproveByClouds(const CoarseInput& input, std::size_t count,
                                          MotionPool* pool) {
  MotionPool improved =
      MakePool(input, input.full_cloud_score ? input.full_cloud_score : ScoreOfRows(input), {});
  constexpr std::size_t kRough = 2;  // these may look bad before they are improved
  const std::vector<ScoredMotion> best = pool->Best(count, kRough);
  for (std::size_t i = 0; i < best.size(); ++i) {
    const ScoredMotion& entry = best[i];
    if (i >= kRough && entry.score <= 0.0) break;
    if (!input.cloud_refine) {
      improved.Add(entry.motion);
    } else if (input.cloud_score && !input.rotations.empty() && entry.score > 0.0) {
      improved.Add(ImproveFromAround(input, entry.motion));
    } else {
      improved.Add(input.cloud_refine(entry.motion));
    }
  }
  return improved.Best();
}

std::optional<CoarseCandidate> EstimateCandidate(const CoarseInput& input,
                                                 const RigidTransform& motion) {
  const double l = input.resolution_m;
  const Correspondences& c = input.correspondences;
  const GncWelschResult gnc =
      EstimateGncWelsch(CollectInliers(input, motion), motion, {.resolution_m = l});
  if (gnc.status == GncWelschResult::Status::kDegenerate) return std::nullopt;
  CoarseCandidate candidate;
  candidate.target_from_source = gnc.target_from_source;
  // Few key points estimate a motion worse than the clouds have improved it already.
  if (input.cloud_score && input.cloud_score(motion) > input.cloud_score(gnc.target_from_source)) {
    candidate.target_from_source = motion;
  }
  candidate.information = gnc.information;
  candidate.sigma_m = gnc.residual_sd_m;
  candidate.consensus = DistinctSources(c, candidate.target_from_source, 2.0 * l);
  candidate.inliers = RowsWithin(c, candidate.target_from_source, 4.0 * l);
  return candidate;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, CoarseOptions& options) {
  visitor.Integer("nodes", options.nodes, "1", 10, 20000,
                  "correspondences kept by node reliability (K_opt)");
  visitor.Integer("edges_per_node", options.edges_per_node, "1", 1, 100,
                  "edges tried per correspondence");
  visitor.Integer("hypotheses", options.hypotheses, "1", 1, 1000,
                  "distinct coarse hypotheses compared");
  visitor.Integer("votes", options.votes, "1", 0, 10000,
                  "translations that are tried where walls tell the rotation and nothing else did");
  visitor.Integer("rivals", options.rivals, "1", 0, 10,
                  "other hypotheses, nearly as good as the best, that are refined and compared");
  visitor.Integer("permutations", options.permutations, "1", 0, 100,
                  "runs on shuffled correspondences that tell consensus from chance");
}

RigidTransform RefineOnInliers(const Correspondences& c, RigidTransform transform, double limit_m) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const auto rows = RowsWithin(c, transform, limit_m);
    const auto fit = FitRigid(c.Subset(rows), {});
    if (!fit) break;
    transform = *fit;
  }
  return transform;
}

CoarseResult RegisterCoarse(const CoarseInput& input, const CoarseOptions& options,
                            const ExecutionContext& context) {
  CoarseResult result;
  const Correspondences& c = input.correspondences;
  if (c.size() < 3) return result;
  result.status = CoarseResult::Status::kNoConsensus;
  result.consensus_null = NullConsensus(input, options, context);

  MotionPool pool = CollectMotions(input, options, context);
  if (pool.empty()) return result;
  if (!input.rotations.empty() && input.cloud_score && input.cloud_refine) {
    pool = ImproveRough(input, &pool);
  }

  const auto wanted = static_cast<std::size_t>(options.rivals) + 1;
  const std::vector<ScoredMotion> improved = ImproveByClouds(input, 2 * wanted, &pool);
  if (improved.empty()) return result;
  const double least_score =
      std::max(input.least_rival_score, input.least_rival_share * improved.front().score);
  for (const ScoredMotion& entry : improved) {
    const bool rival = !result.candidates.empty();
    // A true motion between stations far apart may overlap little beside a false one that lays the
    // scanners on mirrored places. The comparison of the refined clouds decides.
    if (rival && entry.score < least_score) break;
    std::optional<CoarseCandidate> candidate = EstimateCandidate(input, entry.motion);
    if (!candidate) continue;
    candidate->cloud_score = entry.score;
    result.candidates.push_back(std::move(*candidate));
    if (result.candidates.size() == wanted) break;
  }
  result.status = result.candidates.empty() ? CoarseResult::Status::kDegenerate
                                            : CoarseResult::Status::kRegistered;
  return result;
}

}  // namespace backsight
