// Small campaigns, one seed for each scene. BACKSIGHT_CAMPAIGN_SEEDS=5 runs five of each.

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/campaigns/campaign_run.h"
#include "tests/campaigns/campaign_scenes.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

class Campaigns : public testing::Test {
 protected:
  static void TearDownTestSuite() { ExpectTrustworthy(judgements_); }

  /// Seeds 1 and on, or those that BACKSIGHT_CAMPAIGN_SEEDS asks for.
  static std::vector<std::uint64_t> Seeds() {
    const char* count = std::getenv("BACKSIGHT_CAMPAIGN_SEEDS");
    const std::uint64_t last = count != nullptr ? std::strtoull(count, nullptr, 10) : 1;
    std::vector<std::uint64_t> seeds;
    for (std::uint64_t seed = 1; seed <= last; ++seed) seeds.push_back(seed);
    return seeds;
  }

  static void Run(const std::function<Scene(std::uint64_t)>& scene,
                  const std::function<void(const Judgement&)>& expect) {
    for (const std::uint64_t seed : Seeds()) {
      judgements_.push_back(RunCampaign(scene(seed), kProjectLines));
      expect(judgements_.back());
    }
  }

  /// No merged cloud, which nothing here looks at.
  static constexpr const char* kProjectLines = "";

  static inline std::vector<Judgement> judgements_;
};

void ExpectNothingWrong(const Judgement& judgement) {
  EXPECT_EQ(judgement.wrong_links, 0) << judgement.name << " " << judgement.seed;
  EXPECT_EQ(judgement.wrong_pairs, 0) << judgement.name << " " << judgement.seed;
}

TEST_F(Campaigns, RepeatedStreet) { Run(RepeatedStreet, ExpectNothingWrong); }

TEST_F(Campaigns, FurnishedHall) {
  Run([](std::uint64_t seed) { return SymmetricHall(seed, true); }, ExpectNothingWrong);
}

TEST_F(Campaigns, Forest) { Run(Forest, ExpectNothingWrong); }

TEST_F(Campaigns, TwoBuildingsStayTwoComponents) {
  Run(TwoBuildings, [](const Judgement& judgement) {
    ExpectNothingWrong(judgement);
    EXPECT_EQ(judgement.components, 2);
    EXPECT_EQ(judgement.exit_code, 3);
  });
}

TEST_F(Campaigns, RingCorridor) { Run(RingCorridor, ExpectNothingWrong); }

}  // namespace
}  // namespace backsight
