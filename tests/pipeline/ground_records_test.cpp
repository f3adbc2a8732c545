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
  return GroundWarnings(project, ground, MakeGeoreferenceRecords(project, ground));
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

TEST(GroundRecords, PointsOfAComponentThatControlDoesNotPlaceWereMeasuredAllTheSame) {
  SurveyProject project;
  for (const char* id : {"P1", "P2", "P3"}) project.control.emplace_back().id = id;
  GeoreferencedNetwork ground;
  GeoreferencedPart& part = ground.parts.emplace_back();
  part.result.status = GeoreferencingResult::Status::kDiverged;
  part.control = {0};
  part.check = {1};
  const auto warnings = GroundWarnings(project, ground, MakeGeoreferenceRecords(project, ground));
  EXPECT_THAT(warnings, Contains(HasSubstr("check units, ids and stations of the sightings")));
  EXPECT_THAT(warnings, Contains("survey points measured only from stations that are not placed: "
                                 "P3"));
}

TEST(GroundRecords, ASightingFarBeyondItsScanIsNamed) {
  SurveyProject project;
  std::vector<Station> stations(1);
  stations[0].spec.id = "S1";
  stations[0].spec.scanner_origin_m = Eigen::Vector3d(0.0, 100.0, 0.0);
  stations[0].record.extent_m = 20.0;
  ControlPoint& point = project.control.emplace_back();
  point.id = "P1";
  point.measured = {{"S1", {0.0, 130.0, 0.0}}, {"S1", {3.0, 700.0, 0.0}}};
  const auto warnings = SightingWarnings(project, stations);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("P1 was measured 600.0 m from station S1, whose scan reaches "
                                     "20.0 m"));
}

}  // namespace
}  // namespace backsight
