#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pipeline/pair_pipeline.h"
#include "tests/support/hall_scene.h"

namespace backsight {

/// Stations S1, S2, ... in a hall, ready for the registration of their pairs.
struct HallStations {
  HallStations(const HallScene& scene, std::span<const Eigen::Vector3d> places,
               std::uint64_t seed) {
    for (const Eigen::Vector3d& place : places) {
      HallStation scanned(scene, place, DeriveSeed(seed, std::to_string(stations.size())));
      Station& station = stations.emplace_back();
      station.spec.id.append("S").append(std::to_string(stations.size()));
      station.model = std::move(scanned.model);
      station.features = std::move(scanned.features);
      station.index = std::make_shared<const CloudIndex>(station.model);
      world_from_station.push_back(scanned.world_from_station);
    }
  }

  /// A pair that nothing was proposed for yet.
  static Pair MakePair(int source, int target) {
    Pair pair;
    pair.source = source;
    pair.target = target;
    return pair;
  }

  RigidTransform Truth(int source, int target) const {
    return Moved(source, target, RigidTransform{});
  }

  /// The hall entered from its other end: walls, floor and ceiling coincide.
  RigidTransform HalfTurned(int source, int target) const {
    RigidTransform turn;
    turn.rotation = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
    return Moved(source, target, turn);
  }

  /// What the pair's motion would be if the source were moved in the world.
  RigidTransform Moved(int source, int target, const RigidTransform& motion) const {
    return world_from_station[static_cast<std::size_t>(target)].Inverse() * motion *
           world_from_station[static_cast<std::size_t>(source)];
  }

  std::vector<Station> stations;
  std::vector<RigidTransform> world_from_station;
};

}  // namespace backsight
