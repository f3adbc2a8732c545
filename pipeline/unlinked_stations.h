#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// For the warning that a station stands apart: "; doubtful ones to S2, ..." where links of the
/// station are doubtful, with what could confirm them; otherwise empty.
std::string DescribeDoubtful(const std::vector<LinkRecord>& links, const std::string& station);

/// Why a station is not placed: that it has no accepted link, its doubtful ones, and how many of
/// its pairs ended for which reason, or why none was tried; the most frequent reasons first.
std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station);

}  // namespace backsight
