#pragma once

#include <vector>

#include "core/execution.h"
#include "io/picture_record.h"
#include "pipeline/placed_clouds.h"
#include "stages/surface_distances.h"

namespace backsight {

/// The main component from above: points per square metre of all scans, the height of what lies
/// highest, and how far apart surfaces are that several stations measured. `traces`: where sections
/// were cut. Memory: 16 bytes per pixel.
PictureRecord DrawDensity(const PlacedClouds& clouds, const CloudExtent& extent,
                          const std::vector<PictureLine>& traces, const ExecutionContext& context);
PictureRecord DrawHeights(const PlacedClouds& clouds, const CloudExtent& extent,
                          const ExecutionContext& context);

struct DistanceLimits {
  double scale_m = 0.0;   ///< where the colour scale ends
  double search_m = 0.0;  ///< SurfaceDistances
};

/// `samples`: in the frame of the clouds.
PictureRecord DrawDistances(const PlacedClouds& clouds, const CloudExtent& extent,
                            const std::vector<DistanceSample>& samples,
                            const DistanceLimits& limits, const ExecutionContext& context);

}  // namespace backsight
