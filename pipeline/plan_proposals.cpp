#include "pipeline/plan_proposals.h"

#include <algorithm>

#include "stages/plan_motions.h"

namespace backsight {

std::vector<RigidTransform> ProposeByPlans(const Station& source, const Station& target) {
  constexpr std::size_t kMost = 6;
  if (!source.spec.levelled || !target.spec.levelled) return {};
  const double cell_m = std::max(source.prepared.PlanCell(source.model, source.features),
                                 target.prepared.PlanCell(target.model, target.features));
  const auto planned = [&](const Station& station) {
    return PlannedStation{station.model,
                          station.prepared.Plan(station.model, station.features, cell_m),
                          station.prepared.ViewSample(station.model)};
  };
  std::vector<RigidTransform> motions;
  for (const ScoredMotion& found : FindPlanMotions(planned(source), planned(target), {})) {
    if (motions.size() < kMost) motions.push_back(found.motion);
  }
  return motions;
}

}  // namespace backsight
