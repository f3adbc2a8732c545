#pragma once

#include <string>

#include "io/scene_description.h"
#include "tests/campaigns/judge.h"

namespace backsight {

/// Simulates a campaign, runs the program on it with these additional lines of the project file,
/// judges the result, prints its line of the table and what was wrong. Scans are PLY files.
Judgement RunCampaign(const Scene& scene, const std::string& project_lines);

/// The same from the text of a scene file with PTX scans.
Judgement RunCampaignText(const std::string& scene_text, const std::string& name,
                          std::uint64_t seed, const std::string& extension,
                          const std::string& project_lines);

/// Whether the sums over all campaigns hold what a network that can be trusted has to: no wrong
/// link, 98 % of the placeable stations placed, errors below 1.5 times the stated sigma at 68 %,
/// NEES per degree of freedom within 0.7 and 1.4. Prints the table again, with the totals.
void ExpectTrustworthy(const std::vector<Judgement>& judgements);

}  // namespace backsight
