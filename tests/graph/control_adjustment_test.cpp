#include "graph/control_adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/support/control_survey.h"

namespace backsight {
namespace {

using Status = ControlAdjustmentResult::Status;

constexpr std::size_t kStations = ControlSurvey::kStations;

TEST(ControlAdjustment, IsExactWithoutNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ControlSurvey survey(seed, 5, 0.0);
    for (const auto& adjust : {FitToControl, AdjustToControl}) {
      const ControlAdjustmentResult result = adjust(survey.Input());
      ASSERT_EQ(result.status, Status::kAdjusted);
      EXPECT_LT(survey.Errors(result.enu_from_station).cwiseAbs().maxCoeff(), 1e-8);
      EXPECT_LT(result.chi2, 1e-6);
    }
  }
}

TEST(ControlAdjustment, EndsAtTheMinimum) {
  const ControlSurvey survey(3);
  const ControlAdjustmentResult result = AdjustToControl(survey.Input());
  ASSERT_EQ(result.status, Status::kAdjusted);
  std::vector<RigidTransform> poses;
  for (const RigidTransform& pose : result.enu_from_station) {
    poses.push_back(result.enu_from_survey.Inverse() * pose);
  }
  const double least = survey.Chi2(result.enu_from_survey, poses);
  EXPECT_NEAR(result.chi2, least, 1e-3 * least);
  for (std::size_t s = 0; s < kStations; ++s) {
    for (int i = 0; i < 6; ++i) {
      for (const double step : {1e-5, -1e-5}) {
        const Vector6d xi = step * Vector6d::Unit(i);
        std::vector<RigidTransform> moved = poses;
        if (s > 0) moved[s] = Retract(moved[s], xi);
        const RigidTransform motion =
            s == 0 ? Retract(result.enu_from_survey, xi) : result.enu_from_survey;
        EXPECT_GT(survey.Chi2(motion, moved), least) << s << " " << i;
      }
    }
  }
}

TEST(ControlAdjustment, CovarianceAndTestsComeTrue) {
  double nees = 0.0;
  double chi2 = 0.0;
  double w2 = 0.0;
  constexpr int kSeeds = 300;
  int redundancy = 0;
  int tests = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const ControlSurvey survey(seed);
    const ControlAdjustmentResult result = AdjustToControl(survey.Input());
    ASSERT_EQ(result.status, Status::kAdjusted);
    const Eigen::VectorXd errors = survey.Errors(result.enu_from_station);
    nees += errors.dot(result.covariance.ldlt().solve(errors)) / static_cast<double>(errors.size());
    chi2 += result.chi2;
    redundancy = result.redundancy;
    for (const PointResidual& residual : result.residuals) {
      w2 += residual.w.squaredNorm();
      tests += 3;
    }
  }
  EXPECT_NEAR(nees / kSeeds, 1.0, 0.07);
  EXPECT_EQ(redundancy, 3 * (1 + 2 + 1 + 2 + 1 + 2) - 6);
  EXPECT_NEAR(chi2 / kSeeds / redundancy, 1.0, 0.07);
  EXPECT_NEAR(w2 / tests, 1.0, 0.1);
}

TEST(ControlAdjustment, TestsNameTheMovedPoint) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    ControlSurvey survey(seed, 8);
    const std::size_t moved = seed % 8;
    survey.points[moved].enu_m += 0.05 * survey.points[moved].axes.col(1);
    const ControlAdjustmentResult result = AdjustToControl(survey.Input());
    ASSERT_EQ(result.status, Status::kAdjusted);
    for (std::size_t k = 0; k < 8; ++k) {
      if (k == moved) continue;
      EXPECT_GT(result.residuals[moved].w.cwiseAbs().maxCoeff(),
                result.residuals[k].w.cwiseAbs().maxCoeff());
    }
    EXPECT_LT(result.residuals[moved].w[1], -6.0);
  }
}

TEST(ControlAdjustment, NationalCoordinatesOnEitherSideChangeNothing) {
  const ControlSurvey survey(13);
  const ControlAdjustmentResult near = AdjustToControl(survey.Input());
  ASSERT_EQ(near.status, Status::kAdjusted);
  const Eigen::Vector3d far(691000.0, 5336000.0, 500.0);
  ControlSurvey moved = survey;
  for (SurveyedPoint& point : moved.points) point.enu_m += far;
  const ControlAdjustmentResult there = AdjustToControl(moved.Input());
  ASSERT_EQ(there.status, Status::kAdjusted);
  for (std::size_t s = 0; s < kStations; ++s) {
    EXPECT_LT(
        (there.enu_from_station[s].translation - far - near.enu_from_station[s].translation).norm(),
        1e-7);
  }
  // The survey frame may be far away as well: that of a scan in national coordinates.
  ControlSurvey distant = survey;
  for (RigidTransform& pose : distant.survey_from_station) pose.translation += far;
  Matrix6d adjoint = Adjoint({Eigen::Matrix3d::Identity(), far});
  for (Eigen::Index i = 0; i < distant.covariance.rows(); i += 6) {
    for (Eigen::Index j = 0; j < distant.covariance.cols(); j += 6) {
      distant.covariance.block<6, 6>(i, j) =
          adjoint * survey.covariance.block<6, 6>(i, j) * adjoint.transpose();
    }
  }
  const ControlAdjustmentResult from_there = AdjustToControl(distant.Input());
  ASSERT_EQ(from_there.status, Status::kAdjusted);
  for (std::size_t s = 0; s < kStations; ++s) {
    EXPECT_LT(
        (from_there.enu_from_station[s].translation - near.enu_from_station[s].translation).norm(),
        1e-5);
  }
}

TEST(ControlAdjustment, ScaleIsFoundWhereAskedFor) {
  ControlSurvey survey(11, 8, 0.0);
  constexpr double kScale = 1.0003;
  for (SurveyedPoint& point : survey.points) point.enu_m *= kScale;
  ControlAdjustmentInput input = survey.Input();
  input.estimate_scale = true;
  const ControlAdjustmentResult result = AdjustToControl(input);
  ASSERT_EQ(result.status, Status::kAdjusted);
  EXPECT_NEAR(result.scale, kScale, 1e-9);
  EXPECT_GT(result.scale_sigma, 1e-6);
  const Sighting& sighting = survey.points[0].sightings[0];
  const RigidTransform& pose = ControlSurvey::At(result.enu_from_station, sighting);
  const Eigen::Vector3d placed =
      result.scale * (pose.rotation * sighting.point_m) + pose.translation;
  EXPECT_LT((placed - survey.points[0].enu_m).norm(), 1e-7);
}

TEST(ControlAdjustment, TheVerticalIsTheWeightedMeanAxis) {
  const std::vector<RigidTransform> poses = {{}, {ExpSo3({0.03, 0.0, 0.0}), {}}};
  const std::vector<TiltObservation> tilts = {{0, 1e-3}, {1, 2e-3}};
  const Vertical vertical = EstimateVertical(tilts, poses);
  EXPECT_NEAR(vertical.weight, 1.25e6, 1.0);
  EXPECT_LT(
      (vertical.mean - (0.8 * poses[0].rotation.col(2) + 0.2 * poses[1].rotation.col(2))).norm(),
      1e-15);
  const Vertical none = EstimateVertical({}, poses);
  EXPECT_EQ(none.weight, 0.0);
  EXPECT_EQ(none.mean, Eigen::Vector3d::Zero());
}

TEST(ControlAdjustment, LevelledStationsMakeTwoPointsEnough) {
  ControlSurvey survey(5, 2, 0.0);
  EXPECT_FALSE(IsDetermined(survey.Input()));
  EXPECT_EQ(AdjustToControl(survey.Input()).status, Status::kUndetermined);
  // Tell the truth about the vertical: the survey frame is enu turned about it.
  survey.enu_from_survey.rotation = ExpSo3({0.0, 0.0, 1.2});
  for (std::size_t s = 0; s < kStations; ++s) {
    survey.truth[s].rotation = ExpSo3({0.0, 0.0, 0.4 * static_cast<double>(s)});
    survey.survey_from_station[s] = survey.truth[s];
    survey.tilts.push_back({static_cast<int>(s), 1e-4});
  }
  survey.points.clear();
  survey.AddPoint(1, 0.0);
  survey.AddPoint(2, 0.0);
  ASSERT_TRUE(IsDetermined(survey.Input()));
  const ControlAdjustmentResult result = AdjustToControl(survey.Input());
  ASSERT_EQ(result.status, Status::kAdjusted);
  EXPECT_LT(survey.Errors(result.enu_from_station).cwiseAbs().maxCoeff(), 1e-8);
  survey.points[1].enu_m = survey.points[0].enu_m + Eigen::Vector3d(0.0, 0.0, 4.0);
  EXPECT_FALSE(IsDetermined(survey.Input()));
}

TEST(ControlAdjustment, PointsOnALineDetermineNothing) {
  ControlSurvey survey(7, 5, 0.0);
  for (std::size_t k = 0; k < 5; ++k) {
    survey.points[k].enu_m = Eigen::Vector3d(10.0, 4.0, 0.5) * static_cast<double>(k);
  }
  EXPECT_FALSE(IsDetermined(survey.Input()));
  EXPECT_EQ(AdjustToControl(survey.Input()).status, Status::kUndetermined);
  EXPECT_EQ(FitToControl(survey.Input()).status, Status::kUndetermined);
}

}  // namespace
}  // namespace backsight
