#pragma once

#include <span>
#include <vector>

#include "stages/motion_pool.h"
#include "stages/plan_correlation.h"

namespace backsight {

/// A levelled station as the search for motions wants it; all must outlive it.
struct PlannedStation {
  const StationModel& model;
  const PlanView& view;
  std::span<const Eigen::Vector3d> surface;  ///< an even sample of its voxels, instrument frame
};

/// Voxels of a station that tell how well a motion lays two views on each other.
inline constexpr std::size_t kViewSample = 400;

/// An even sample of at most `count` voxels. Instrument frame.
std::vector<Eigen::Vector3d> SampleSurface(const StationModel& model, std::size_t count);

/// How well a motion lays two stations' views on each other: per direction the share of the surface
/// sample that the other scanner saw at its place minus the share that it saw through, both
/// directions summed. -2 to 2. Some 10 us for 400 samples.
double MutualViewScore(std::span<const Eigen::Vector3d> source_surface, const StationModel& source,
                       std::span<const Eigen::Vector3d> target_surface, const StationModel& target,
                       const RigidTransform& target_from_source);

/// The motions that CorrelatePlans proposes, each moved in small steps of heading and place to
/// where the scanners agree most; best first by MutualViewScore. Good to about a quarter of a cell
/// and one degree. Some 10 ms beside CorrelatePlans' own time.
std::vector<ScoredMotion> FindPlanMotions(const PlannedStation& source,
                                          const PlannedStation& target,
                                          const PlanCorrelationOptions& options);

}  // namespace backsight
