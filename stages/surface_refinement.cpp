#include "stages/surface_refinement.h"

#include <cmath>
#include <vector>

#include "core/even_choice.h"
#include "stages/motion_descent.h"
#include "stages/surface_pairs.h"

namespace backsight {
namespace {

constexpr double kReach = 2.0;                       // voxels, between matched means
const double kLargestAngleCosine = std::sqrt(0.75);  // 30 deg between matched normals

MotionEquations EquationsOf(const SurfacePairSums& sums) {
  MotionEquations equations;
  equations.matches = static_cast<int>(sums.matches);
  equations.gradient = Vector6d(sums.gradient.data());
  std::size_t term = 0;
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = 0; column <= row; ++column) {
      equations.matrix(row, column) = equations.matrix(column, row) = sums.matrix[term++];
    }
  }
  return equations;
}

/// Voxels with a normal, evenly chosen: faster than by their directions.
std::vector<std::uint32_t> ChooseEvenly(const Surface& source, std::size_t most) {
  const EvenChoice even(source.normals.size(), most);
  std::vector<std::uint32_t> chosen;
  chosen.reserve(even.count());
  for (std::size_t i = 0; i < even.count(); ++i) {
    if (source.normals[even[i]].allFinite()) chosen.push_back(static_cast<std::uint32_t>(even[i]));
  }
  return chosen;
}

}  // namespace

RigidTransform RefineOnSurfaces(const Surface& source, std::span<const std::uint32_t> chosen,
                                const Surface& target, const CloudIndex& target_index,
                                const RigidTransform& start, const Matrix6d& prior,
                                double normal_sigma_m, int max_iterations) {
  const double l = target.model.resolution_m();
  SurfacePairs pairs(source, target, target_index, chosen, kReach * l);
  const SurfacePairRule rule{.reach_m = kReach * l,
                             .least_cosine = kLargestAngleCosine,
                             .along_variance = l * l,
                             .across_variance = normal_sigma_m * normal_sigma_m};
  const auto equations_at = [&](const RigidTransform& motion) {
    return EquationsOf(pairs.Sum(motion, rule));
  };
  return Descend(start, prior, max_iterations, equations_at).target_from_source;
}

RigidTransform RefineRoughly(const Surface& source, const Surface& target,
                             const CloudIndex& target_index,
                             const RigidTransform& target_from_source) {
  constexpr std::size_t kVoxels = 4000;
  constexpr int kSteps = 6;
  return RefineOnSurfaces(source, ChooseEvenly(source, kVoxels), target, target_index,
                          target_from_source, Matrix6d::Zero(), 0.1 * target.model.resolution_m(),
                          kSteps);
}

}  // namespace backsight
