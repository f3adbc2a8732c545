#include "stages/link_structure.h"

#include <algorithm>

#include "graph/graph_connectivity.h"

namespace backsight {

LinkStructure FindLinkStructure(int stations, std::span<const PairProspect> candidates) {
  LinkStructure structure;
  structure.links.resize(static_cast<std::size_t>(stations), 0);
  std::vector<PoseGraphLink> links;
  for (const PairProspect& pair : candidates) {
    if (!pair.accepted) continue;
    PoseGraphLink& link = links.emplace_back();
    link.source = pair.source;
    link.target = pair.target;
    ++structure.links[static_cast<std::size_t>(pair.source)];
    ++structure.links[static_cast<std::size_t>(pair.target)];
  }
  structure.component = FindComponents(stations, links, {});
  std::vector<char> within_block = FindBridges(stations, links, {});
  std::transform(within_block.begin(), within_block.end(), within_block.begin(),
                 [](char is_bridge) { return is_bridge != 0 ? 0 : 1; });
  structure.block = FindComponents(stations, links, within_block);
  return structure;
}

}  // namespace backsight
