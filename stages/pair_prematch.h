#pragma once

#include <vector>

#include "core/execution.h"
#include "stages/plan_view.h"
#include "stages/station_model.h"

namespace backsight {

struct PrematchOptions {
  int keypoints = 600;  ///< of each station, the most unusual ones
  int neighbors = 3;    ///< mutual nearest descriptors
  int nodes = 300;      ///< correspondences kept by node reliability
  int hypotheses = 20;  ///< motions compared by what the scanners saw
  int turns = 24;  ///< of 72 headings, those under which the plans of levelled ones are compared
};

/// Edges of cells in a station's plans.
struct PlanScale {
  double cell_m = 0.0;     ///< PlanCellFor the station; 0: it is not levelled and has no plans
  double largest_m = 0.0;  ///< of all stations that are to be compared
};

/// A station reduced to what a cheap comparison needs; instrument frame, metres. Refers to the
/// model, which must outlive it.
struct StationSketch {
  const StationModel* model = nullptr;
  std::vector<Eigen::Vector3d> positions;   ///< of the chosen key points
  std::vector<FpfhDescriptor> descriptors;  ///< of the same
  std::vector<Eigen::Vector3d> surface;     ///< an even sample of the voxels
  bool levelled = false;                    ///< z is up
  /// Of levelled stations: views from above, each with cells twice as large as the one before.
  std::vector<PlanView> plans;

  double plan_cell_m() const { return plans.empty() ? 0.0 : plans.front().cell_m(); }
  /// The one with cells of this size, which must be there.
  const PlanView& PlanAt(double cell_m) const;
};

/// Chooses the key points whose descriptors lie farthest from the station's mean, each bin in units
/// of its own spread: the same corner looks unusual from everywhere, plain ground and walls do not.
/// Plans of levelled stations have cells up to the largest.
StationSketch SketchStation(const StationModel& model, const StationFeatures& features,
                            const PlanScale& plans, const PrematchOptions& options);

/// How well the best of a few motions, found from the sketches' key points and, between levelled
/// stations, from their plans, lays the two stations' views on each other (MutualViewScore): -2 to
/// 2; -2 where no motion was found. Motions that tilt levelled stations by more than 2 degrees do
/// not count. Ranks pairs; proves nothing. Some 3 ms, between levelled stations 15.
double PrematchPair(const StationSketch& source, const StationSketch& target,
                    const PrematchOptions& options, const ExecutionContext& context);

}  // namespace backsight
