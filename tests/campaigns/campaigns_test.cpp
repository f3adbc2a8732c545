// Campaigns with exact truth. `Small` is what every change runs; `Big` repeats the scenes with
// other seeds, `Town` has 200 stations.

#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include "tests/campaigns/campaign_run.h"
#include "tests/campaigns/campaign_scenes.h"
#include "tests/campaigns/town_scene.h"

namespace backsight {
namespace {

struct CampaignCase {
  std::string name;
  std::function<Scene(std::uint64_t)> scene;
  double resolution_m = 0.15;
  /// Nothing, or too little, tells the scene's places apart, so that all that is asked is to place
  /// nothing wrongly.
  bool undecidable = false;
  int components = 1;
};

void PrintTo(const CampaignCase& c, std::ostream* out) { *out << c.name; }

Scene FurnishedHall(std::uint64_t seed) { return SymmetricHall(seed, true); }
Scene EmptyHall(std::uint64_t seed) { return SymmetricHall(seed, false); }
Scene Courtyard(std::uint64_t seed) { return Reseeded("tests/e2e/scenes/courtyard.yaml", seed); }
Scene Yard(std::uint64_t seed) { return Reseeded("tests/e2e/scenes/yard.yaml", seed); }

const CampaignCase kSmallCases[] = {
    {.name = "street", .scene = RepeatedStreet, .resolution_m = 0.2},
    {.name = "hall", .scene = FurnishedHall},
    {.name = "emptyhall", .scene = EmptyHall, .undecidable = true},
    {.name = "forest", .scene = Forest, .resolution_m = 0.1},
    {.name = "openfield", .scene = OpenField, .undecidable = true},
    {.name = "twobuildings", .scene = TwoBuildings, .components = 2},
    {.name = "courtyard", .scene = Courtyard},
    {.name = "yard", .scene = Yard},
};
const CampaignCase kRings[] = {
    {.name = "corridor", .scene = RingCorridor, .resolution_m = 0.1},
    {.name = "hiddencorners", .scene = HiddenCorners, .resolution_m = 0.1, .undecidable = true},
};
const CampaignCase kTown = {.name = "town", .scene = Town, .resolution_m = 0.3};

class Campaigns : public testing::TestWithParam<std::tuple<CampaignCase, std::uint64_t>> {
 protected:
  static void TearDownTestSuite() {
    ExpectTrustworthy(judgements_);
    judgements_.clear();
  }
  static inline std::vector<Judgement> judgements_;
};

TEST_P(Campaigns, HaveNothingWrong) {
  const auto& [campaign, seed] = GetParam();
  Judgement judgement = RunCampaign(campaign.scene(seed), campaign.resolution_m);
  EXPECT_EQ(judgement.wrong_links, 0);
  EXPECT_EQ(judgement.wrong_pairs, 0);
  if (campaign.undecidable) {
    judgement.placed = judgement.placeable = 0;
  } else if (judgement.placed == judgement.stations) {
    EXPECT_EQ(judgement.components, campaign.components);
    EXPECT_EQ(judgement.exit_code, campaign.components == 1 ? 0 : 3);
  }
  judgements_.push_back(judgement);
}

std::string NameOf(const testing::TestParamInfo<std::tuple<CampaignCase, std::uint64_t>>& test) {
  return std::get<0>(test.param).name + std::to_string(std::get<1>(test.param));
}

INSTANTIATE_TEST_SUITE_P(Small, Campaigns,
                         testing::Combine(testing::ValuesIn(kSmallCases), testing::Values(1U)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Big, Campaigns,
                         testing::Combine(testing::ValuesIn(kSmallCases),
                                          testing::Values(2U, 3U, 4U, 5U)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(BigRings, Campaigns,
                         testing::Combine(testing::ValuesIn(kRings),
                                          testing::Values(1U, 2U, 3U, 4U, 5U)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Town, Campaigns,
                         testing::Combine(testing::Values(kTown), testing::Values(1U)), NameOf);

}  // namespace
}  // namespace backsight
