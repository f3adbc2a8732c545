#include "pipeline/prepared_station.h"

#include <map>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "stages/plan_motions.h"
#include "stages/surface_choice.h"
#include "stages/surface_refinement.h"

namespace backsight {
namespace {

/// The options that a plane tree depends on.
using TreeOptions = std::tuple<double, double, double>;

}  // namespace

struct PreparedStation::Kept {
  std::shared_ptr<LastPlanes> last_planes;
  std::mutex mutex;
  std::map<TreeOptions, std::weak_ptr<const PlaneTree>> planes;
  std::optional<std::vector<std::uint32_t>> surfaces;
  std::optional<double> plan_cell_m;
  std::map<double, PlanView> plans;  // by the edge of their cells; what is in a map stays there
  std::optional<std::vector<Eigen::Vector3d>> view_sample;
};

PreparedStation::PreparedStation(std::shared_ptr<LastPlanes> shared)
    : kept_(std::make_unique<Kept>()) {
  kept_->last_planes = shared ? std::move(shared) : std::make_shared<LastPlanes>();
}
PreparedStation::PreparedStation(const PreparedStation& other)
    : PreparedStation(other.kept_ ? other.kept_->last_planes : nullptr) {}
PreparedStation::PreparedStation(PreparedStation&& other) noexcept = default;
PreparedStation& PreparedStation::operator=(const PreparedStation& other) {
  if (this != &other) *this = PreparedStation(other);
  return *this;
}
PreparedStation& PreparedStation::operator=(PreparedStation&& other) noexcept = default;
PreparedStation::~PreparedStation() = default;

std::shared_ptr<const PlaneTree> PreparedStation::Planes(const Surface& surface,
                                                         const FineOptions& options) const {
  const TreeOptions key{options.root_edge, options.max_thickness_m, options.max_thinness};
  const auto tree = [&] {
    const std::lock_guard lock(kept_->mutex);
    std::weak_ptr<const PlaneTree>& kept = kept_->planes[key];
    std::shared_ptr<const PlaneTree> found = kept.lock();
    if (!found) {
      found = kept_->last_planes->Make([&] { return MakePlaneTree(surface, options); });
      kept = found;
    }
    return found;
  }();
  kept_->last_planes->Use(tree);
  return tree;
}

const std::vector<std::uint32_t>& PreparedStation::Surfaces(const Surface& surface) const {
  const std::lock_guard lock(kept_->mutex);
  if (!kept_->surfaces) kept_->surfaces = ChooseSurfaces(surface.normals, kRefinedSurfaces);
  return *kept_->surfaces;
}

double PreparedStation::PlanCell(const StationModel& model, const StationFeatures& features) const {
  const std::lock_guard lock(kept_->mutex);
  if (!kept_->plan_cell_m) kept_->plan_cell_m = PlanCellFor(model, features);
  return *kept_->plan_cell_m;
}

const PlanView& PreparedStation::Plan(const StationModel& model, const StationFeatures& features,
                                      double cell_m) const {
  const std::lock_guard lock(kept_->mutex);
  const auto found = kept_->plans.find(cell_m);
  if (found != kept_->plans.end()) return found->second;
  return kept_->plans.emplace(cell_m, PlanView(model, features, cell_m, kPlanWalls)).first->second;
}

const std::vector<Eigen::Vector3d>& PreparedStation::ViewSample(const StationModel& model) const {
  const std::lock_guard lock(kept_->mutex);
  if (!kept_->view_sample) kept_->view_sample = SampleSurface(model, kViewSample);
  return *kept_->view_sample;
}

}  // namespace backsight
