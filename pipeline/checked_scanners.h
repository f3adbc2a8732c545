#pragma once

#include <vector>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_discovery.h"

namespace backsight {

/// DiscoverPairs; where a station stays out only because its scanner did not stand where its scan
/// says (stages/misplaced_scanners.h), its scanner is forgotten and pairs are discovered again, one
/// station after the other until there is none left. `stations` are those of the units; `early`
/// pairs are not registered again unless a station has changed. What was found is stored, so that a
/// second run begins with it.
PairDiscovery DiscoverWithCheckedScanners(const PairUnits& units, const PairSpec& spec,
                                          RegisteredPairs early, std::vector<Station>* stations);

}  // namespace backsight
