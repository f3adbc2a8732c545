#pragma once

#include <span>
#include <vector>

#include "stages/pair_selection.h"

namespace backsight {

/// What hangs together by accepted links. Stations are numbered anew, in order of their first
/// station.
struct LinkStructure {
  std::vector<int> component;
  std::vector<int> block;  ///< 2-edge-connected: within a block any one link may fall
  std::vector<int> links;  ///< accepted links per station
};
LinkStructure FindLinkStructure(int stations, std::span<const PairProspect> candidates);

}  // namespace backsight
