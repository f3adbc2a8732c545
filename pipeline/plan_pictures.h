#pragma once

#include <vector>

#include "io/picture_record.h"
#include "pipeline/placed_clouds.h"
#include "stages/surface_distances.h"

namespace backsight {

/// The main component from above: points per square metre of all scans, the height of what lies
/// highest, and how far apart surfaces are that several stations measured. `traces`: where sections
/// were cut. Memory: 16 bytes per pixel.
PictureRecord DrawDensity(const PlacedClouds& clouds, const CloudExtent& extent,
                          const std::vector<PictureLine>& traces);
PictureRecord DrawHeights(const PlacedClouds& clouds, const CloudExtent& extent);
/// `samples`: in the frame of the clouds. `limit_m`: where the colour scale ends.
PictureRecord DrawDistances(const PlacedClouds& clouds, const CloudExtent& extent,
                            const std::vector<DistanceSample>& samples, double limit_m);

}  // namespace backsight
