#pragma once

#include <functional>
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
  int permutations = 1;  ///< runs on shuffled correspondences for the significance test
};
void VisitOptions(OptionVisitor& visitor, CoarseOptions& options);

struct CoarseResult {
  enum class Status {
    kRegistered,
    kTooFewCorrespondences,  ///< fewer than three
    kNoConsensus,            ///< no edge gathers enough key points
    kDegenerate,             ///< the consensus lies on one line
  };
  Status status = Status::kTooFewCorrespondences;
  RigidTransform target_from_source;        ///< T_c
  Matrix6d information = Matrix6d::Zero();  ///< of T_c, Retract's convention
  int consensus = 0;                        ///< distinct source key points within 2 l under T_c
  int consensus_null = 0;  ///< the best that shuffled correspondences reach: chance alone
  std::vector<std::uint32_t> inliers;  ///< C3: rows within 4 l under T_c
  double sigma_m = 0.0;                ///< per-axis noise of the inliers
};

struct CoarseInput {
  Correspondences correspondences;  ///< C1
  double resolution_m = 0.1;        ///< l
  /// All key points, ids as in C1; may be empty. Once the motion is roughly known, key points that
  /// descriptors did not match but positions do join the estimate.
  std::vector<Eigen::Vector3d> source_keypoints;
  std::vector<Eigen::Vector3d> target_keypoints;
  std::uint64_t seed = 0;  ///< drives the shuffles of the significance test
  /// How well a motion lays the clouds themselves on each other, larger is better; decides between
  /// the hypotheses. Without it the correspondences alone decide.
  std::function<double(const RigidTransform&)> cloud_score;
};

/// Micro-structures graph registration of one pair from putative correspondences: RGN, RGE, choice
/// among the best hypotheses by the clouds (or by MSAC over distinct key points), GNC-Welsch.
CoarseResult RegisterCoarse(const CoarseInput& input, const CoarseOptions& options,
                            const ExecutionContext& context);

}  // namespace backsight
