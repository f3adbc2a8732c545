#include "pipeline/placed_clouds.h"

#include <algorithm>
#include <tuple>

namespace backsight {

std::size_t PlacedClouds::voxels() const {
  std::size_t count = 0;
  for (const PlacedStation& placed : stations) count += placed.station->model.leaves.size();
  return count;
}

double PlacedClouds::resolution_m() const {
  double edge_m = 0.0;
  for (const PlacedStation& placed : stations) {
    edge_m = std::max(edge_m, placed.station->model.resolution_m());
  }
  return edge_m;
}

std::optional<RigidTransform> DeliveredPlace(const Network& network,
                                             const GeoreferencedNetwork& ground,
                                             std::size_t station) {
  const int component = network.component[station];
  if (component < 0) return std::nullopt;
  if (station >= ground.enu_from_station.size() || !ground.enu_from_station[station]) {
    return network.survey_from_station[station];
  }
  RigidTransform place = *ground.enu_from_station[station];
  place.translation /= ground.ScaleOf(component);
  return place;
}

PlacedClouds PlaceClouds(const std::vector<Station>& stations, const Network& network,
                         const GeoreferencedNetwork& ground) {
  PlacedClouds clouds;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (!stations[s].usable() || network.component[s] != 0) continue;
    clouds.stations.push_back(
        {&stations[s], s,
         *DeliveredPlace(network, ground, s) * stations[s].model.StationFromInstrument()});
  }
  const bool on_ground = !ground.parts.empty() && ground.parts.front().placed();
  const std::string axes = on_ground ? "ENH" : "xyz";
  const std::string local = on_ground && ground.frame ? "local " : "";
  clouds.across = local + axes[0];
  clouds.up = local + axes[1];
  clouds.height = local + axes[2];
  clouds.origin = !on_ground     ? "in the survey frame"
                  : ground.frame ? "in the local frame (east, true north, up) amid the control"
                                 : "in the local grid of the control";
  return clouds;
}

std::pair<double, double> MiddleOf(std::vector<double> values) {
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / 100);
  const auto low = values.begin() + cut;
  const auto high = values.end() - 1 - cut;
  std::nth_element(values.begin(), low, values.end());
  const double lowest = *low;
  std::nth_element(low, high, values.end());
  return {lowest, *high};
}

namespace {

/// One coordinate of the means of voxels, evenly chosen.
std::vector<double> SampleAxis(const PlacedClouds& clouds, int axis) {
  constexpr std::size_t kMost = 1'000'000;
  const std::size_t stride = 1 + clouds.voxels() / kMost;
  std::vector<double> values;
  values.reserve(clouds.voxels() / stride + 1);
  std::size_t next = 0;
  for (const PlacedStation& placed : clouds.stations) {
    const VoxelLeaves& leaves = placed.station->model.leaves;
    for (; next < leaves.size(); next += stride) {
      values.push_back((placed.frame_from_instrument * leaves.Mean(next))[axis]);
    }
    next -= leaves.size();
  }
  return values;
}

}  // namespace

CloudExtent ExtentOf(const PlacedClouds& clouds) {
  CloudExtent extent;
  if (clouds.voxels() == 0) return extent;
  for (int axis = 0; axis < 3; ++axis) {  // in turn: a million values are enough memory
    std::tie(extent.min[axis], extent.max[axis]) = MiddleOf(SampleAxis(clouds, axis));
  }
  return extent;
}

}  // namespace backsight
