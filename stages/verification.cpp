#include "stages/verification.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace backsight {
namespace {

bool IsOccupied(const StationModel& model, std::uint64_t key) {
  const auto found =
      std::lower_bound(model.leaves.begin(), model.leaves.end(), key,
                       [](const VoxelLeaf& leaf, std::uint64_t k) { return leaf.key < k; });
  return found != model.leaves.end() && found->key == key;
}

bool MeetsSurface(const StationModel& model, const Eigen::Vector3d& point) {
  if (!model.lattice.Contains(point)) return false;
  const Eigen::Vector3i cell = model.lattice.Cell(point);
  if (IsOccupied(model, VoxelLattice::Pack(cell))) return true;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-1, 1}) {
      if (IsOccupied(model, VoxelLattice::Pack(cell + step * Eigen::Vector3i::Unit(axis)))) {
        return true;
      }
    }
  }
  return false;
}

/// Angle between the vertical axes of both stations.
double RelativeTilt(const RigidTransform& target_from_source) {
  const Eigen::Vector3d up = target_from_source.rotation.col(2);
  return std::atan2(std::hypot(up.x(), up.y()), up.z());
}

VerificationResult::Reason FindFault(const VerificationInput& input,
                                     const VerificationOptions& options, double overlap) {
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
}

std::string ToString(VerificationResult::Reason reason) {
  static constexpr std::array<const char*, 6> kNames = {
      "", "not_registered", "not_significant", "low_overlap", "fine_diverged", "tilted"};
  return kNames.at(static_cast<std::size_t>(reason));
}

double OverlapShare(const StationModel& moved, const StationModel& reference,
                    const RigidTransform& reference_from_moved) {
  constexpr std::size_t kSample = 20000;
  const std::size_t stride = std::max<std::size_t>(1, moved.leaves.size() / kSample);
  std::size_t met = 0;
  std::size_t tried = 0;
  for (std::size_t i = 0; i < moved.leaves.size(); i += stride, ++tried) {
    if (MeetsSurface(reference, reference_from_moved * moved.leaves[i].cluster.mean)) ++met;
  }
  return tried > 0 ? static_cast<double>(met) / static_cast<double>(tried) : 0.0;
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
  result.reason = FindFault(input, options, result.overlap);
  return result;
}

}  // namespace backsight
