#include "pipeline/ground_records.h"

#include <gmock/gmock.h>

namespace backsight {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

/// A component that control places, without any survey point.
GeoreferencedNetwork PlacedNetwork() {
  GeoreferencedNetwork ground;
  GeoreferencedPart& part = ground.parts.emplace_back();
  part.result.status = GeoreferencingResult::Status::kGeoreferenced;
  part.result.scale_test = ScaleTest{8e-5, 1e-5};
  return ground;
}

std::vector<std::string> WarningsOf(const GeoreferencedNetwork& ground) {
  const SurveyProject project;
  return GroundWarnings(project, MakeGeoreferenceRecords(project, ground));
}

TEST(GroundRecords, ScaleThatIsOffIsNamed) {
  EXPECT_THAT(WarningsOf(PlacedNetwork()), Contains(HasSubstr("off by 80 ppm (sigma 10)")));
}

TEST(GroundRecords, AScaleTestThatFailedIsNamed) {
  GeoreferencedNetwork ground = PlacedNetwork();
  ground.parts.front().result.scale_test.reset();
  EXPECT_THAT(WarningsOf(ground),
              Contains(HasSubstr("component 1: the network's scale could not be tested")));
  // Where nothing is placed there is nothing to test.
  ground.parts.front().result.status = GeoreferencingResult::Status::kTooFewPoints;
  EXPECT_THAT(WarningsOf(ground), Each(Not(HasSubstr("scale"))));
}

}  // namespace
}  // namespace backsight
