#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// What became of every pair that was tried, in their order.
std::vector<LinkRecord> MakeLinkRecords(const std::vector<Station>& stations,
                                        const std::vector<Pair>& pairs, const Network& network);

/// Misclosures of all triangles of used links, coarse and fine, ascending.
std::vector<ClosureRecord> MakeClosureRecords(const std::vector<Station>& stations,
                                              const std::vector<Pair>& pairs,
                                              const Network& network);

/// How the adjustment of every component ended.
std::vector<ComponentRecord> MakeComponentRecords(const std::vector<Station>& stations,
                                                  const Network& network);

}  // namespace backsight
