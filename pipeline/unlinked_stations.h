#pragma once

#include <set>
#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// Why nothing connects these stations with others, as the end of a sentence: "; doubtful: S9 - S8
/// (far from start) ..." with what could confirm them, those first of which least was seen through,
/// and "; of 31 pair(s) that were tried: ..." with how many ended for which reason, the most
/// frequent first, or why none was tried.
std::string DescribeGap(const std::vector<LinkRecord>& links,
                        const std::set<std::string>& stations);

/// The same of one station that is not placed, as a whole sentence.
std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station);

}  // namespace backsight
