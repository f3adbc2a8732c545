#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "graph/correspondences.h"
#include "graph/gnc_welsch.h"

namespace backsight {

struct CoarseOptions {
  int nodes = 800;  ///< K_opt, correspondences kept by node reliability
  int edges_per_node = 2;
  int hypotheses = 40;
  int votes = 100;       ///< translations that are tried where the rotation is known
  int rivals = 3;        ///< other hypotheses, nearly as good as the best, that are kept
  int permutations = 1;  ///< runs on shuffled correspondences for the significance test
};
void VisitOptions(OptionVisitor& visitor, CoarseOptions& options);

/// One motion that the correspondences or the clouds' symmetries propose.
struct CoarseCandidate {
  RigidTransform target_from_source;        ///< T_c
  Matrix6d information = Matrix6d::Zero();  ///< of T_c, Retract's convention
  int consensus = 0;                        ///< distinct source key points within 2 l under T_c
  std::vector<std::uint32_t> inliers;       ///< C3: rows within 4 l under T_c
  double sigma_m = 0.0;                     ///< per-axis noise of the inliers
  double cloud_score = 0.0;                 ///< of the clouds under T_c; MSAC without clouds
};

struct CoarseResult {
  enum class Status {
    kRegistered,
    kTooFewCorrespondences,  ///< fewer than three
    kNoConsensus,            ///< no edge gathers enough key points
    kDegenerate,             ///< the consensus lies on one line
  };
  Status status = Status::kTooFewCorrespondences;
  int consensus_null = 0;  ///< the best that shuffled correspondences reach: chance alone
  /// The best, then its rivals by falling score: motions farther from each other than 5 deg or 10 l
  /// (at the overlap's centre) whose score is not too low. Empty unless
  /// registered.
  std::vector<CoarseCandidate> candidates;
};

struct CoarseInput {
  Correspondences correspondences;  ///< C1
  double resolution_m = 0.1;        ///< l
  /// All key points, ids as in C1; may be empty. Once the motion is roughly known, key points that
  /// descriptors did not match but positions do join the estimate.
  std::vector<Eigen::Vector3d> source_keypoints;
  std::vector<Eigen::Vector3d> target_keypoints;
  /// Both instruments were levelled: motions that tilt them against each other by more than this
  /// are not considered.
  std::optional<double> max_tilt_rad;
  std::uint64_t seed = 0;  ///< drives the shuffles of the significance test
  /// How well a motion lays the clouds themselves on each other, larger is better, 0 and less is
  /// worthless; decides between the hypotheses. Without it the correspondences alone decide.
  std::function<double(const RigidTransform&)> cloud_score;
  /// No less than cloud_score, in less time: motions that it rules out are not scored. May be
  /// absent.
  std::function<double(const RigidTransform&)> cloud_score_bound;
  /// cloud_score from more of the clouds, for the few that remain.
  std::function<double(const RigidTransform&)> full_cloud_score;
  /// A rival whose score is less than this, or a smaller share of the best one's, is dropped.
  double least_rival_score = 0.0;
  double least_rival_share = 0.0;
  /// Improves a motion by the clouds; without it the correspondences' fit is scored.
  std::function<RigidTransform(const RigidTransform&)> cloud_refine;
  /// Rough motions that need no correspondences to be proposed; improved by the clouds before they
  /// compete.
  std::vector<RigidTransform> proposals;
  /// Motions that carry the source's own cloud onto itself, and the target's: where they are, what
  /// fits may fit elsewhere too, and the true motion may gather too few key points to be found.
  std::vector<RigidTransform> source_symmetries;
  std::vector<RigidTransform> target_symmetries;
  /// Rotations that the correspondences need not tell, such as those that lay walls on walls: they
  /// then vote for translations (stages/aligned_hypotheses.h).
  std::vector<Eigen::Matrix3d> rotations;
  Correspondences ballots;  ///< that vote besides C1: more of them, and worse ones
  /// Other motions that fit the clouds' structure as the given one does; may be absent.
  std::function<std::vector<RigidTransform>(const RigidTransform&)> structure_images;
};

/// A few rounds of collecting the rows within `limit_m` and refitting pull a motion from one edge
/// to its whole consensus.
RigidTransform RefineOnInliers(const Correspondences& c, RigidTransform transform, double limit_m);

/// Micro-structures graph registration of one pair from putative correspondences: RGN, RGE, choice
/// among the best hypotheses and their mirror images by the clouds (or by MSAC over distinct key
/// points), GNC-Welsch on each that remains.
CoarseResult RegisterCoarse(const CoarseInput& input, const CoarseOptions& options,
                            const ExecutionContext& context);

}  // namespace backsight
