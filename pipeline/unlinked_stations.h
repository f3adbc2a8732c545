#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// For the warning that a station stands apart: "; doubtful ones to S2, ..." where links of the
/// station are doubtful, with what could confirm them; otherwise empty.
std::string DescribeDoubtful(const std::vector<LinkRecord>& links, const std::string& station);

/// Why a station is not placed: that it has no accepted link, what became of the pairs that were
/// tried, the most frequent reason first, and of its doubtful ones.
std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station);

}  // namespace backsight
