#pragma once

#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "core/point_chunk.h"
#include "core/rigid_transform.h"
#include "io/scene_description.h"
#include "stages/simulation/ray_caster.h"

namespace backsight {

/// One scan as a structured grid, station frame.
struct StationScan {
  int rows = 0;     ///< elevations, from the lowest up
  int columns = 0;  ///< azimuths, counter-clockwise from the station's x axis
  /// rows * columns records, column by column; (0, 0, 0) where nothing came back. Intensity and
  /// rgb are filled.
  PointChunk grid;
  /// Per record of the grid: whether what came back is of a moving material.
  std::vector<std::uint8_t> moving;
  std::uint64_t returns = 0;
};

/// The scanner's grid: rows * columns rays.
struct ScanGridSize {
  int rows = 0;
  int columns = 0;
};
ScanGridSize GridSize(const Scanner& scanner);

/// Standard deviation of one range in metres: sqrt(a^2 + (b range)^2) / cos(incidence), where the
/// cosine counts no less than 0.2.
double RangeSigma(const Scanner& scanner, double range_m, double cos_incidence);

/// Measures a station as a time-of-flight scanner would. Each beam is 8 sub-rays over the footprint
/// (1 where mixed pixels are off); echoes closer together than `mixing_m` blend to one range, of
/// echoes farther apart the strongest counts. A pulse on glass is lost, returns from what lies
/// behind, or, seldom, from the pane. A return is lost where reflectance * cos(incidence) *
/// (max_range / range)^2 < 0.1, and at random (`dropout`). All random numbers of a ray derive from
/// `seed` and the ray's place in the grid, so the result does not depend on the number of threads.
StationScan MeasureStation(const RayCaster& caster, const RigidTransform& world_from_station,
                           const Scanner& scanner, std::uint64_t seed,
                           const ExecutionContext& execution);

}  // namespace backsight
