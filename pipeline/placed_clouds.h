#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// Where the clouds of a station are delivered: in the frame of the control where that ties its
/// component to the ground, otherwise in the survey frame; none where the station has no place.
/// Where control stretched the network, its places are shrunk back, so that scans fit as they are.
std::optional<RigidTransform> DeliveredPlace(const Network& network,
                                             const GeoreferencedNetwork& ground,
                                             std::size_t station);

/// A station of the main component, where its pictures are drawn.
struct PlacedStation {
  const Station* station = nullptr;
  std::size_t index = 0;                 ///< among all stations: it decides the colour
  RigidTransform frame_from_instrument;  ///< the frame of DeliveredPlace
};

/// The main component in one frame: that of the control where it is tied to the ground, otherwise
/// the survey frame.
struct PlacedClouds {
  std::vector<PlacedStation> stations;
  std::string across;  ///< what the frame's x stands for: "local E"
  std::string up;      ///< y
  std::string height;  ///< z
  std::string origin;  ///< where its zero is, for captions

  std::size_t voxels() const;
  double resolution_m() const;  ///< the largest of the stations
};

PlacedClouds PlaceClouds(const std::vector<Station>& stations, const Network& network,
                         const GeoreferencedNetwork& ground);

/// The middle 98 % of the means of all voxels, from a million of them, evenly chosen.
struct CloudExtent {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
};
CloudExtent ExtentOf(const PlacedClouds& clouds);

/// The middle 98 % of values, of which there is at least one.
std::pair<double, double> MiddleOf(std::vector<double> values);

}  // namespace backsight
