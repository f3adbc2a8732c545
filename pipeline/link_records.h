#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// What became of every pair that was tried, in their order.
std::vector<LinkRecord> MakeLinkRecords(const std::vector<Station>& stations,
                                        const std::vector<Pair>& pairs, const Network& network);

/// For the warning that a station is left out: "; doubtful ones to S2, ..." where links of the
/// station are doubtful, with what could confirm them; otherwise empty.
std::string DescribeDoubtful(const std::vector<LinkRecord>& links, const std::string& station);

/// Misclosures of all triangles of used links, coarse and fine, ascending.
std::vector<ClosureRecord> MakeClosureRecords(const std::vector<Station>& stations,
                                              const std::vector<Pair>& pairs,
                                              const Network& network);

/// How the adjustment of every component ended.
std::vector<ComponentRecord> MakeComponentRecords(const std::vector<Station>& stations,
                                                  const Network& network);

}  // namespace backsight
