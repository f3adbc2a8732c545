#include "pipeline/moving_points.h"

#include <memory>
#include <unordered_set>

namespace backsight {
namespace {

std::vector<std::size_t> Members(int component, const Network& network) {
  std::vector<std::size_t> members;
  for (std::size_t s = 0; s < network.component.size(); ++s) {
    if (network.component[s] == component) members.push_back(s);
  }
  return members;
}

}  // namespace

PlacedSurface Place(const Station& station, const RigidTransform& frame_from_station) {
  return {{station.model, station.features.normals, station.features.scanner_credible},
          *station.index,
          frame_from_station * station.model.StationFromInstrument()};
}

MovingPoints FindMovingPoints(const std::vector<Station>& stations, const Network& network,
                              const MovingObjectOptions& options, const ExecutionContext& context) {
  MovingPoints moving;
  moving.stations.resize(stations.size());
  for (int component = 0; component < static_cast<int>(network.parts.size()); ++component) {
    const std::vector<std::size_t> members = Members(component, network);
    context.Progress("moving objects", static_cast<std::size_t>(component), network.parts.size());
    std::vector<PlacedSurface> placed;
    placed.reserve(members.size());
    for (const std::size_t s : members) {
      placed.push_back(Place(stations[s], network.survey_from_station[s]));
    }
    std::vector<MovingLeaves> found = FindMovingLeaves(placed, options, context);
    for (std::size_t k = 0; k < members.size(); ++k) {
      moving.stations[members[k]] = std::move(found[k]);
    }
  }
  return moving;
}

std::function<bool(const Eigen::Vector3d&)> IsMovingFunction(const Station& station,
                                                             const MovingLeaves& moving) {
  if (moving.leaves.empty()) return {};
  auto keys = std::make_shared<std::unordered_set<std::uint64_t>>();
  for (const std::uint32_t leaf : moving.leaves) keys->insert(station.model.leaves[leaf].key);
  return [keys, lattice = station.model.lattice, origin = station.model.scanner_origin](
             const Eigen::Vector3d& point) { return keys->contains(lattice.Key(point - origin)); };
}

}  // namespace backsight
