#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "pipeline/last_planes.h"
#include "stages/cloud_agreement.h"
#include "stages/fine_registration.h"
#include "stages/plan_view.h"
#include "stages/surface.h"

namespace backsight {

/// What pairs need of one station alone: made for the first pair that asks, kept for all others
/// (planes: for those that follow), in memory only. Thread-safe. A copy begins with nothing,
/// because the station may change in it.
class PreparedStation {
 public:
  /// `shared` keeps the planes used last of all stations that share it; without, of this one.
  explicit PreparedStation(std::shared_ptr<LastPlanes> shared = nullptr);
  PreparedStation(const PreparedStation& other);
  PreparedStation(PreparedStation&& other) noexcept;
  PreparedStation& operator=(const PreparedStation& other);
  PreparedStation& operator=(PreparedStation&& other) noexcept;
  ~PreparedStation();

  /// MakePlaneTree for the station as a target; made anew where nobody has it any more and another
  /// was asked for in between.
  std::shared_ptr<const PlaneTree> Planes(const Surface& surface, const FineOptions& options) const;

  /// ChooseSurfaces of kRefinedSurfaces, for the station as a source.
  const std::vector<std::uint32_t>& Surfaces(const Surface& surface) const;

  /// PlanCellFor a levelled station, and its view with cells of any edge.
  double PlanCell(const StationModel& model, const StationFeatures& features) const;
  const PlanView& Plan(const StationModel& model, const StationFeatures& features,
                       double cell_m) const;
  /// SampleSurface of kViewSample voxels.
  const std::vector<Eigen::Vector3d>& ViewSample(const StationModel& model) const;

 private:
  struct Kept;
  std::unique_ptr<Kept> kept_;
};

}  // namespace backsight
