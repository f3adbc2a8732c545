#pragma once

#include <set>
#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// Why no link joins these stations with others, as the end of a sentence: "; 11 pair(s) doubtful
/// or ambiguous, the least seen through first: S9 - S8 (far from start, 0.4 %), ..." with what
/// could decide, and "; of 31 pair(s) that were tried: ..." with how many ended for which reason,
/// the most frequent first, or why none was tried.
std::string DescribeGap(const std::vector<LinkRecord>& links,
                        const std::set<std::string>& stations);

/// The same of one station that is not placed, as a whole sentence.
std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station);

}  // namespace backsight
