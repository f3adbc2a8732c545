#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/execution.h"
#include "stages/moving_objects.h"

namespace backsight {

struct OccupancyMapOptions {
  double resolution_m = 0.2;  ///< edge of the voxels
  double scale = 1.0;         ///< of coordinates measured in the stations
  std::size_t memory_bytes = std::size_t{2} << 30U;
};

/// A map of occupied, free and unknown space from what placed stations measured, as the bytes of an
/// OctoMap file of octree type "OcTree" (Hornung et al. 2013, doi 10.1007/s10514-012-9321-0), in
/// the frame that the stations share.
///
/// A voxel is occupied where a station measured something that does not move, as often as stations
/// did; free where beams from the stations pass on their way there. Beams do not clear voxels that
/// hold a surface, however many graze it. `moving[s]` are the leaves of surfaces[s] that are left
/// out. Time about 0.1 us per voxel that a beam crosses, with one beam per station and occupied
/// voxel. Throws InputError where the stations' points reach farther from the frame's origin than
/// the map's 32768 voxels, and where it would need more memory than given.
std::string DrawOccupancyMap(const std::vector<PlacedSurface>& surfaces,
                             const std::vector<MovingLeaves>& moving,
                             const OccupancyMapOptions& options, const ExecutionContext& context);

}  // namespace backsight
