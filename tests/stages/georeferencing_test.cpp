#include "stages/georeferencing.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/control_survey.h"

namespace backsight {
namespace {

using Status = GeoreferencingResult::Status;

/// The first `checks` points as check points, the others as control.
GeoreferencingInput InputOf(const ControlSurvey& survey, std::size_t checks) {
  GeoreferencingInput input{survey.survey_from_station, survey.covariance, {}, {}, survey.tilts};
  for (std::size_t k = 0; k < survey.points.size(); ++k) {
    (k < checks ? input.check : input.control).push_back(survey.points[k]);
  }
  return input;
}

TEST(Georeferencing, CheckPointsErrAsPredicted) {
  double normalised = 0.0;
  int count = 0;
  int false_alarms = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const ControlSurvey survey(seed, 12);
    const GeoreferencingResult result = Georeference(InputOf(survey, 4), {});
    ASSERT_EQ(result.status, Status::kGeoreferenced) << seed;
    ASSERT_EQ(result.check.size(), 4U);
    for (const CheckResidual& residual : result.check) {
      normalised += residual.mean_m.cwiseQuotient(residual.sigma_m).squaredNorm();
      count += 3;
    }
    EXPECT_EQ(result.adjustment.scale, 1.0);
    ASSERT_TRUE(result.scale_test);
    EXPECT_LT(std::abs(result.scale_test->minus_one), 5.0 * result.scale_test->sigma);
    false_alarms += static_cast<int>(std::count(result.excluded.begin(), result.excluded.end(), 1));
  }
  EXPECT_NEAR(normalised / count, 1.0, 0.1);
  EXPECT_LT(false_alarms, 0.01 * 200 * 8);
}

TEST(Georeferencing, ABlunderIsNamedAndLeavesNoTrace) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const ControlSurvey survey(seed, 12);
    GeoreferencingInput input = InputOf(survey, 0);
    const std::size_t moved = seed % 12;
    input.control[moved].enu_m += 0.05 * input.control[moved].axes.col(0);
    const GeoreferencingResult result = Georeference(input, {});
    ASSERT_EQ(result.status, Status::kGeoreferenced) << seed;
    EXPECT_EQ(result.excluded[moved], 1) << seed;
    EXPECT_LT(result.control[moved].w[0], -3.29) << seed;
    EXPECT_NEAR(result.control[moved].adjusted_m[0], -0.05, 0.02) << seed;

    GeoreferencingInput without = InputOf(survey, 0);
    without.control.erase(without.control.begin() + static_cast<std::ptrdiff_t>(moved));
    const GeoreferencingResult clean = Georeference(without, {});
    for (std::size_t s = 0; s < ControlSurvey::kStations; ++s) {
      EXPECT_LT((clean.adjustment.enu_from_station[s].translation -
                 result.adjustment.enu_from_station[s].translation)
                    .norm(),
                1e-3)
          << seed;
    }
  }
}

TEST(Georeferencing, ControlThatCannotBeToldApartIsContradictory) {
  const ControlSurvey survey(4, 3);
  GeoreferencingInput input = InputOf(survey, 0);
  input.control[1].enu_m.x() += 0.2;
  const GeoreferencingResult result = Georeference(input, {});
  EXPECT_EQ(result.status, Status::kContradictory);
  EXPECT_EQ(std::count(result.excluded.begin(), result.excluded.end(), 1), 0);
  EXPECT_GT(result.variance_factor, 10.0);
  // The stated uncertainty must cover what is not understood.
  const double sigma = std::sqrt(result.adjustment.covariance(3, 3));
  EXPECT_GT(sigma, 0.01);
}

/// Control on a horizontal plane, all measured from the datum station.
ControlSurvey PlaneSurvey(const std::vector<Eigen::Vector2d>& places) {
  ControlSurvey survey(6, 0);
  survey.enu_from_survey.rotation = ExpSo3({0.0, 0.0, 1.2});
  for (const Eigen::Vector2d& place : places) {
    survey.AddPoint(1, 1.0);
    const Eigen::Vector3d at(place.x(), place.y(), 1.0);
    survey.points.back().enu_m = survey.enu_from_survey * at;
    survey.points.back().sightings = {{0, at}};
  }
  return survey;
}

const std::vector<Eigen::Vector2d> kSquare = {{40, 38}, {-41, 36}, {-35, -40}, {38, -42}};

TEST(Georeferencing, NoGoodPointIsBlamedForTheHeightOfAnother) {
  // Four heights over the three unknowns of a plane: residuals alone cannot tell which is wrong.
  for (std::size_t moved = 0; moved < 4; ++moved) {
    ControlSurvey survey = PlaneSurvey(kSquare);
    survey.points[moved].enu_m.z() += 0.1;
    const GeoreferencingResult result = Georeference(InputOf(survey, 0), {});
    EXPECT_EQ(result.status, Status::kContradictory) << moved;
    EXPECT_EQ(std::count(result.excluded.begin(), result.excluded.end(), 1), 0) << moved;
  }
}

TEST(Georeferencing, HeightsOfThreePointsAreNotChecked) {
  const auto checks = [](const std::vector<Eigen::Vector2d>& places) {
    std::vector<std::array<bool, 3>> checked;
    const GeoreferencingResult result = Georeference(InputOf(PlaneSurvey(places), 0), {});
    for (const ControlResidual& residual : result.control) checked.push_back(residual.checked);
    return checked;
  };
  for (const auto& point : checks({kSquare.begin(), kSquare.begin() + 3})) {
    EXPECT_TRUE(point[0] && point[1]);
    EXPECT_FALSE(point[2]);
  }
  for (const auto& point : checks(kSquare)) EXPECT_TRUE(point[0] && point[1] && point[2]);
}

TEST(Georeferencing, GridDistancesShowAsScale) {
  ControlSurvey survey(8, 12);
  for (SurveyedPoint& point : survey.points) point.enu_m *= 1.0004;
  const GeoreferencingResult result = Georeference(InputOf(survey, 0), {});
  ASSERT_TRUE(result.scale_test);
  EXPECT_GT(result.scale_test->minus_one, 2e-4);
  EXPECT_EQ(result.adjustment.scale, 1.0);
}

TEST(Georeferencing, CheckPointsErrAsPredictedWhereScaleIsEstimated) {
  // Seen from 300 m, far outside the control: what is not known of scale counts most.
  double normalised = 0.0;
  int count = 0;
  GeoreferencingOptions options;
  options.estimate_scale = true;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    ControlSurvey survey(seed, 8);
    const Eigen::Vector3d far(300.0, -200.0, 10.0);
    SurveyedPoint point = survey.points[0];
    const Eigen::Vector3d noise = ControlSurvey::Draw(survey.random, 1.0);
    point.enu_m = survey.enu_from_survey * far + point.axes * point.sigma_m.cwiseProduct(noise);
    point.sightings = {{1, survey.truth[1].Inverse() * far +
                               ControlSurvey::Draw(survey.random, ControlSurvey::kSightingSigma)}};
    GeoreferencingInput input = InputOf(survey, 0);
    input.check.push_back(point);
    const GeoreferencingResult result = Georeference(input, options);
    ASSERT_EQ(result.status, Status::kGeoreferenced) << seed;
    const CheckResidual& residual = result.check.front();
    normalised += residual.mean_m.cwiseQuotient(residual.sigma_m).squaredNorm();
    count += 3;
  }
  // Standard deviation of the mean of 600 squares of standard normals, were they independent: 0.06.
  EXPECT_NEAR(normalised / count, 1.0, 0.2);
}

TEST(Georeferencing, AScaleTestThatFailsIsAbsent) {
  // Heights upside down, by more than the points lie apart: only a scale of zero would fit.
  ControlSurvey survey(6, 0);
  survey.enu_from_survey.rotation.setIdentity();
  for (int k = 0; k < 8; ++k) {
    survey.AddPoint(1, 0.0);
    const Eigen::Vector3d at(2.0 * std::cos(k), 2.0 * std::sin(k), k % 2 == 0 ? 3.0 : -3.0);
    survey.points.back().enu_m = {at.x(), at.y(), -at.z()};
    survey.points.back().sightings = {{0, at}};
  }
  survey.tilts = {{0, 1e-6}};
  const GeoreferencingResult result = Georeference(InputOf(survey, 0), {});
  ASSERT_EQ(result.status, Status::kContradictory);
  EXPECT_FALSE(result.scale_test);
}

TEST(Georeferencing, TooFewPointsPlaceNothing) {
  const ControlSurvey survey(2, 6);
  const GeoreferencingResult result = Georeference(InputOf(survey, 4), {});
  EXPECT_EQ(result.status, Status::kTooFewPoints);
  EXPECT_TRUE(result.check.empty());
}

}  // namespace
}  // namespace backsight
