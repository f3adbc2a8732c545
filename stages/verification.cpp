#include "stages/verification.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace backsight {
namespace {

/// Index of the leaf with this key, -1 if there is none.
std::ptrdiff_t FindLeaf(const StationModel& model, std::uint64_t key) {
  const auto found =
      std::lower_bound(model.leaves.begin(), model.leaves.end(), key,
                       [](const VoxelLeaf& leaf, std::uint64_t k) { return leaf.key < k; });
  if (found == model.leaves.end() || found->key != key) return -1;
  return found - model.leaves.begin();
}

/// The leaf in or beside whose voxel the point lies, -1 if there is none.
std::ptrdiff_t FindSurface(const StationModel& model, const Eigen::Vector3d& point) {
  if (!model.lattice.Contains(point)) return -1;
  const Eigen::Vector3i cell = model.lattice.Cell(point);
  std::ptrdiff_t leaf = FindLeaf(model, VoxelLattice::Pack(cell));
  for (int axis = 0; axis < 3 && leaf < 0; ++axis) {
    for (const int step : {-1, 1}) {
      if (leaf >= 0) break;
      leaf = FindLeaf(model, VoxelLattice::Pack(cell + step * Eigen::Vector3i::Unit(axis)));
    }
  }
  return leaf;
}

/// What a scanner says of a point that another scan measured.
enum class Sight { kNotInView, kAgrees, kSeenThrough };

Sight Look(const StationModel& viewer, const Eigen::Vector3d& point) {
  const float farthest = viewer.range_image.At(point).max_m;
  if (farthest == 0.0F) return Sight::kNotInView;
  const double range = point.norm();
  const double tolerance = std::min(3.0 * viewer.resolution_m() + 0.02 * range, 1.0);
  if (range > farthest + tolerance) return Sight::kNotInView;  // hidden behind something
  return range < farthest - tolerance ? Sight::kSeenThrough : Sight::kAgrees;
}

/// Angle between the vertical axes of both stations.
double RelativeTilt(const RigidTransform& target_from_source) {
  const Eigen::Vector3d up = target_from_source.rotation.col(2);
  return std::atan2(std::hypot(up.x(), up.y()), up.z());
}

VerificationResult::Reason FindFault(const VerificationInput& input,
                                     const VerificationOptions& options, double overlap,
                                     double conflict) {
  using Reason = VerificationResult::Reason;
  const int needed =
      std::max(options.min_consensus, input.coarse.consensus_null + options.min_above_chance);
  if (input.coarse.consensus < needed) return Reason::kNotSignificant;
  if (input.fine.status == FineResult::Status::kDiverged) return Reason::kFineDiverged;
  if (overlap < options.min_overlap) return Reason::kLowOverlap;
  if (input.level_sigma_rad) {
    constexpr double kModelError = 0.3 * 0.017453292519943295;  // 0.3 deg
    const double limit = 5.0 * *input.level_sigma_rad + kModelError;
    if (RelativeTilt(input.fine.target_from_source) > limit) return Reason::kTilted;
  }
  if (conflict > options.max_conflict) return Reason::kFreeSpace;
  return Reason::kNone;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, VerificationOptions& options) {
  visitor.Integer("min_consensus", options.min_consensus, "1", 3, 10000,
                  "fewest corresponding key points of an accepted pair");
  visitor.Integer("min_above_chance", options.min_above_chance, "1", 0, 1000,
                  "by how many they must exceed what shuffled correspondences reach");
  visitor.Real("min_overlap", options.min_overlap, "1", 0.0, 1.0,
               "least share of each cloud that must fall on the other");
  visitor.Real("max_conflict", options.max_conflict, "1", 0.0, 1.0,
               "largest share of the surfaces in view that a scanner may have seen through");
}

std::string ToString(VerificationResult::Reason reason) {
  static constexpr std::array<const char*, 8> kNames = {
      "",       "not_registered",      "not_significant",  "low_overlap", "fine_diverged",
      "tilted", "free_space_conflict", "contradicts_prior"};
  return kNames.at(static_cast<std::size_t>(reason));
}

double OverlapShare(const StationModel& moved, const StationModel& reference,
                    const RigidTransform& reference_from_moved) {
  constexpr std::size_t kSample = 20000;
  const std::size_t stride = std::max<std::size_t>(1, moved.leaves.size() / kSample);
  std::size_t met = 0;
  std::size_t tried = 0;
  for (std::size_t i = 0; i < moved.leaves.size(); i += stride, ++tried) {
    if (FindSurface(reference, reference_from_moved * moved.leaves[i].cluster.mean) >= 0) ++met;
  }
  return tried > 0 ? static_cast<double>(met) / static_cast<double>(tried) : 0.0;
}

double FreeSpaceConflict(const StationModel& moved, const StationModel& reference,
                         const RigidTransform& reference_from_moved) {
  constexpr std::size_t kSample = 20000;
  const std::size_t stride = std::max<std::size_t>(1, moved.leaves.size() / kSample);
  std::size_t agreed = 0;
  std::size_t through = 0;
  for (std::size_t i = 0; i < moved.leaves.size(); i += stride) {
    const Sight sight = Look(reference, reference_from_moved * moved.leaves[i].cluster.mean);
    agreed += sight == Sight::kAgrees ? 1 : 0;
    through += sight == Sight::kSeenThrough ? 1 : 0;
  }
  return agreed + through > 0 ? static_cast<double>(through) / static_cast<double>(agreed + through)
                              : 0.0;
}

double CloudScore(const Surface& moved, const Surface& reference,
                  const RigidTransform& reference_from_moved, bool scanners_credible) {
  constexpr std::size_t kSample = 3000;
  constexpr float kLikeNormal = 0.8F;
  const Eigen::Matrix3f rotation = reference_from_moved.rotation.cast<float>();
  const std::size_t stride = std::max<std::size_t>(1, moved.model.leaves.size() / kSample);
  double score = 0.0;
  std::size_t tried = 0;
  for (std::size_t i = 0; i < moved.model.leaves.size(); i += stride, ++tried) {
    const Eigen::Vector3d point = reference_from_moved * moved.model.leaves[i].cluster.mean;
    const std::ptrdiff_t leaf = FindSurface(reference.model, point);
    if (leaf >= 0) {
      const Eigen::Vector3f& normal = reference.normals[static_cast<std::size_t>(leaf)];
      if (normal.dot(rotation * moved.normals[i]) > kLikeNormal) score += 1.0;
    } else if (scanners_credible && Look(reference.model, point) == Sight::kSeenThrough) {
      score -= 1.0;
    }
  }
  // Kept above zero, so that even a poor hypothesis beats none; the verification judges it.
  return tried > 0 ? 2.0 + score / static_cast<double>(tried) : 0.0;
}

VerificationResult VerifyPair(const VerificationInput& input, const VerificationOptions& options) {
  VerificationResult result;
  if (input.coarse.status != CoarseResult::Status::kRegistered) {
    result.reason = VerificationResult::Reason::kNotRegistered;
    return result;
  }
  const RigidTransform& motion = input.fine.target_from_source;
  BACKSIGHT_CHECK(motion.IsValid(), "a registered pair has a rigid motion");
  result.overlap = std::min(OverlapShare(input.source, input.target, motion),
                            OverlapShare(input.target, input.source, motion.Inverse()));
  if (input.scanners_credible) {
    result.conflict = std::max(FreeSpaceConflict(input.source, input.target, motion),
                               FreeSpaceConflict(input.target, input.source, motion.Inverse()));
  }
  result.reason = FindFault(input, options, result.overlap, result.conflict);
  return result;
}

}  // namespace backsight
