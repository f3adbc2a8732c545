#pragma once

#include <vector>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_discovery.h"

namespace backsight {

/// DiscoverPairs; where stations stay out only because their scanners did not stand where their
/// scans say (stages/misplaced_scanners.h), their scanners are forgotten and pairs are discovered
/// again, until there is no such station left. `stations` are those of the units. What was found is
/// stored, so that a second run begins with it.
PairDiscovery DiscoverWithCheckedScanners(const PairUnits& units, const PairSpec& spec,
                                          std::vector<Station>* stations);

}  // namespace backsight
