#pragma once

#include <vector>

#include "core/execution.h"
#include "stages/station_model.h"

namespace backsight {

struct PrematchOptions {
  int keypoints = 600;  ///< of each station, the most unusual ones
  int neighbors = 3;    ///< mutual nearest descriptors
  int nodes = 300;      ///< correspondences kept by node reliability
  int hypotheses = 20;  ///< motions compared by what the scanners saw
  int surface = 400;    ///< voxels of each station that are looked at
};

/// A station reduced to what a cheap comparison needs; instrument frame, metres. Refers to the
/// model, which must outlive it.
struct StationSketch {
  const StationModel* model = nullptr;
  std::vector<Eigen::Vector3d> positions;   ///< of the chosen key points
  std::vector<FpfhDescriptor> descriptors;  ///< of the same
  std::vector<Eigen::Vector3d> surface;     ///< an even sample of the voxels
  bool levelled = false;                    ///< z is up
};

/// Chooses the key points whose descriptors lie farthest from the station's mean, each bin in units
/// of its own spread: the same corner looks unusual from everywhere, plain ground and walls do not.
StationSketch SketchStation(const StationModel& model, const StationFeatures& features,
                            bool levelled, const PrematchOptions& options);

/// How well the best of a few motions, found from the sketches' key points alone, lays the two
/// stations' views on each other: per direction the share of the surface sample that the other
/// scanner saw at its place minus the share that it saw through, both directions summed. -2 to 2;
/// -2 where no motion was found. Motions that tilt levelled stations by more than 2 degrees do not
/// count. Ranks pairs; proves nothing. Some 8 ms.
double PrematchPair(const StationSketch& source, const StationSketch& target,
                    const PrematchOptions& options, const ExecutionContext& context);

}  // namespace backsight
