#include "pipeline/plan_proposals.h"

#include <algorithm>

#include "stages/plan_motions.h"

namespace backsight {

std::vector<RigidTransform> ProposeByPlans(const Station& source, const Station& target) {
  constexpr std::size_t kWalls = 100;
  constexpr std::size_t kSurface = 400;
  constexpr std::size_t kMost = 6;
  if (!source.spec.levelled || !target.spec.levelled) return {};
  const double cell_m = std::max(PlanCellFor(source.model, source.features),
                                 PlanCellFor(target.model, target.features));
  const PlanView source_view(source.model, source.features, cell_m, kWalls);
  const PlanView target_view(target.model, target.features, cell_m, kWalls);
  const std::vector<Eigen::Vector3d> source_surface = SampleSurface(source.model, kSurface);
  const std::vector<Eigen::Vector3d> target_surface = SampleSurface(target.model, kSurface);
  std::vector<RigidTransform> motions;
  for (const ScoredMotion& found :
       FindPlanMotions({source.model, source_view, source_surface},
                       {target.model, target_view, target_surface}, {})) {
    if (motions.size() < kMost) motions.push_back(found.motion);
  }
  return motions;
}

}  // namespace backsight
