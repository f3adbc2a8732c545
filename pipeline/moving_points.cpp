#include "pipeline/moving_points.h"

#include <memory>
#include <unordered_set>

namespace backsight {

PlacedSurface Place(const Station& station, const RigidTransform& frame_from_station) {
  return {station.surface(), *station.index,
          frame_from_station * station.model.StationFromInstrument()};
}

MovingPoints FindMovingPoints(const std::vector<Station>& stations, const Network& network,
                              const MovingObjectOptions& options, const ExecutionContext& context) {
  MovingPoints moving;
  moving.stations.resize(stations.size());
  for (std::size_t part = 0; part < network.parts.size(); ++part) {
    context.Progress("moving objects", part, network.parts.size());
    const std::vector<int>& members = network.parts[part].stations;
    std::vector<PlacedSurface> placed;
    placed.reserve(members.size());
    for (const int member : members) {
      const auto s = static_cast<std::size_t>(member);
      placed.push_back(Place(stations[s], network.survey_from_station[s]));
    }
    std::vector<MovingLeaves> found = FindMovingLeaves(placed, options, context);
    for (std::size_t k = 0; k < members.size(); ++k) {
      moving.stations[static_cast<std::size_t>(members[k])] = std::move(found[k]);
    }
  }
  context.Progress("moving objects", network.parts.size(), network.parts.size());
  return moving;
}

std::function<bool(const Eigen::Vector3d&)> IsMovingFunction(const Station& station,
                                                             const MovingLeaves& moving) {
  if (moving.leaves.empty()) return {};
  auto keys = std::make_shared<std::unordered_set<std::uint64_t>>();
  for (const std::uint32_t leaf : moving.leaves) keys->insert(station.model.leaves.Key(leaf));
  return [keys, lattice = station.model.lattice(), origin = station.model.scanner_origin](
             const Eigen::Vector3d& point) { return keys->contains(lattice.Key(point - origin)); };
}

}  // namespace backsight
