#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace backsight {

/// Quantiles of distances between surfaces, metres, without sign.
struct DistanceFigures {
  static constexpr std::uint64_t kFewest = 50;  ///< samples that speak of a pair of stations

  std::uint64_t samples = 0;
  double median_m = 0.0;
  double p68_m = 0.0;  ///< 68 % of the samples are no further apart
  double p95_m = 0.0;
};

/// Distances between two stations, in both directions.
struct PairDistanceRecord {
  std::array<std::string, 2> stations;
  DistanceFigures figures;
};

/// How far apart the surfaces are that several stations of a component measured: distances of the
/// mean of a patch of plane from the plane of the patch about the nearest voxel of another station.
struct DistanceRecord {
  double search_m = 0.0;  ///< voxels further apart are different surfaces and do not count
  DistanceFigures total;
  double bin_m = 0.0;               ///< width of the histogram's bins, the first from 0
  std::vector<std::uint64_t> bins;  ///< samples
  std::uint64_t beyond = 0;         ///< samples above the last bin
  std::vector<PairDistanceRecord> pairs;
};

}  // namespace backsight
