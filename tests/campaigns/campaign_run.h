#pragma once

#include <string>

#include "io/scene_description.h"
#include "tests/campaigns/judge.h"

namespace backsight {

/// Simulates a campaign of PLY scans, runs the program on it at this resolution, judges the result,
/// prints its line of the table and what was wrong. Files go to a folder that vanishes; where the
/// variable BACKSIGHT_CAMPAIGNS names a folder, they go to NAME-SEED in it and stay.
Judgement RunCampaign(const Scene& scene, double resolution_m);

/// Whether the sums over all campaigns hold what a network that can be trusted has to: no wrong
/// link, 98 % of the placeable stations placed, errors below 1.5 times the stated sigma at 68 %,
/// NEES per degree of freedom within 0.7 and 1.4. Prints the table again, with the totals.
void ExpectTrustworthy(const std::vector<Judgement>& judgements);

}  // namespace backsight
