#include "graph/control_adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <numbers>
#include <optional>

#include "core/random.h"

namespace backsight {
namespace {

using Status = ControlAdjustmentResult::Status;

constexpr std::size_t kStations = 5;
constexpr double kSightingSigma = 0.001;

Eigen::Vector3d Draw(Random& random, double sigma) {
  const double x = sigma * random.Normal();
  const double y = sigma * random.Normal();
  return {x, y, sigma * random.Normal()};
}

Eigen::Vector3d Somewhere(Random& random, double reach, double height) {
  const double x = random.Uniform(-reach, reach);
  const double y = random.Uniform(-reach, reach);
  return {x, y, random.Uniform(-height, height)};
}

/// A free network with correlated errors, and control with noise, all drawn from a seed.
struct Survey {
  explicit Survey(std::uint64_t seed, std::size_t point_count = 6, double noise = 1.0)
      : random(seed) {
    enu_from_survey = {ExpSo3(Somewhere(random, 3.0, 0.05)), Somewhere(random, 50.0, 2.0)};
    for (std::size_t s = 0; s < kStations; ++s) {
      RigidTransform pose;
      if (s > 0) pose = {ExpSo3(Somewhere(random, 0.01, 3.0)), Somewhere(random, 40.0, 2.0)};
      truth.push_back(pose);
    }
    DrawFreeNetwork(noise);
    for (std::size_t k = 0; k < point_count; ++k) AddPoint(1 + k % 2, noise);
  }

  void DrawFreeNetwork(double noise) {
    const Eigen::Index free = 6 * (kStations - 1);
    Eigen::MatrixXd factor(free, free);
    for (Eigen::Index i = 0; i < free; ++i) {
      const double sigma = i % 6 < 3 ? 1e-4 : 3e-3;
      for (Eigen::Index j = 0; j < free; ++j) {
        factor(i, j) = sigma * random.Normal() / std::sqrt(static_cast<double>(free));
      }
    }
    covariance = Eigen::MatrixXd::Zero(6 * kStations, 6 * kStations);
    covariance.bottomRightCorner(free, free) = factor * factor.transpose();
    Eigen::VectorXd unit(free);
    for (double& value : unit) value = noise * random.Normal();
    const Eigen::VectorXd errors = factor * unit;
    survey_from_station.push_back(truth[0]);
    for (std::size_t s = 1; s < kStations; ++s) {
      const Vector6d xi = errors.segment<6>(static_cast<Eigen::Index>(6 * (s - 1)));
      survey_from_station.push_back(Retract(truth[s], xi));
    }
  }

  void AddPoint(std::size_t sightings, double noise) {
    SurveyedPoint point;
    const Eigen::Vector3d survey = Somewhere(random, 60.0, 6.0);
    point.axes = ExpSo3({0.0, 0.0, 0.03});
    point.sigma_m = {0.002, 0.003, 0.005};
    const Eigen::Vector3d error = Draw(random, noise);
    point.enu_m = enu_from_survey * survey + point.axes * point.sigma_m.cwiseProduct(error);
    for (std::size_t i = 0; i < sightings; ++i) {
      const std::size_t station = (points.size() + i) % kStations;
      point.sightings.push_back(
          {static_cast<int>(station),
           truth[station].Inverse() * survey + Draw(random, noise * kSightingSigma)});
    }
    points.push_back(point);
  }

  ControlAdjustmentInput Input() const {
    return {survey_from_station, covariance, points, kSightingSigma, tilts, false};
  }

  /// The true pose's difference from an estimate.
  Eigen::VectorXd Errors(const std::vector<RigidTransform>& enu_from_station) const {
    Eigen::VectorXd errors(6 * kStations);
    for (std::size_t s = 0; s < kStations; ++s) {
      errors.segment<6>(static_cast<Eigen::Index>(6 * s)) =
          LocalDifference(enu_from_survey * truth[s], enu_from_station[s]);
    }
    return errors;
  }

  /// Weighted sum of squares, written down from its definition with every point as an unknown that
  /// is eliminated by its own minimum.
  double Chi2(const RigidTransform& motion, const std::vector<RigidTransform>& poses) const {
    const Eigen::Index free = 6 * (kStations - 1);
    Eigen::VectorXd xi(free);
    for (std::size_t s = 1; s < kStations; ++s) {
      xi.segment<6>(static_cast<Eigen::Index>(6 * (s - 1))) =
          LocalDifference(poses[s], survey_from_station[s]);
    }
    double chi2 =
        xi.dot(Eigen::MatrixXd(covariance.bottomRightCorner(free, free)).ldlt().solve(xi));
    for (const SurveyedPoint& point : points) {
      const Eigen::Matrix3d own = point.Covariance().inverse();
      const double each = 1.0 / (kSightingSigma * kSightingSigma);
      Eigen::Matrix3d weight = own;
      Eigen::Vector3d sum = own * point.enu_m;
      for (const Sighting& sighting : point.sightings) {
        weight += each * Eigen::Matrix3d::Identity();
        sum += each * (motion * (At(poses, sighting) * sighting.point_m));
      }
      const Eigen::Vector3d place = weight.inverse() * sum;
      chi2 += (place - point.enu_m).dot(own * (place - point.enu_m));
      for (const Sighting& sighting : point.sightings) {
        chi2 += each * (motion * (At(poses, sighting) * sighting.point_m) - place).squaredNorm();
      }
    }
    return chi2;
  }
  static const RigidTransform& At(const std::vector<RigidTransform>& poses, const Sighting& s) {
    return poses[static_cast<std::size_t>(s.station)];
  }

  Random random;
  RigidTransform enu_from_survey;
  std::vector<RigidTransform> truth, survey_from_station;
  Eigen::MatrixXd covariance;
  std::vector<SurveyedPoint> points;
  std::vector<TiltObservation> tilts;
};

TEST(ControlAdjustment, IsExactWithoutNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Survey survey(seed, 5, 0.0);
    for (const auto& adjust : {FitToControl, AdjustToControl}) {
      const ControlAdjustmentResult result = adjust(survey.Input());
      ASSERT_EQ(result.status, Status::kAdjusted);
      EXPECT_LT(survey.Errors(result.enu_from_station).cwiseAbs().maxCoeff(), 1e-8);
      EXPECT_LT(result.chi2, 1e-6);
    }
  }
}

TEST(ControlAdjustment, EndsAtTheMinimum) {
  const Survey survey(3);
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
    const Survey survey(seed);
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
    Survey survey(seed, 8);
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

TEST(ControlAdjustment, ScaleIsFoundWhereAskedFor) {
  Survey survey(11, 8, 0.0);
  constexpr double kScale = 1.0003;
  for (SurveyedPoint& point : survey.points) point.enu_m *= kScale;
  ControlAdjustmentInput input = survey.Input();
  input.estimate_scale = true;
  const ControlAdjustmentResult result = AdjustToControl(input);
  ASSERT_EQ(result.status, Status::kAdjusted);
  EXPECT_NEAR(result.scale, kScale, 1e-9);
  EXPECT_GT(result.scale_sigma, 1e-6);
  const Sighting& sighting = survey.points[0].sightings[0];
  const RigidTransform& pose = Survey::At(result.enu_from_station, sighting);
  const Eigen::Vector3d placed =
      result.scale * (pose.rotation * sighting.point_m) + pose.translation;
  EXPECT_LT((placed - survey.points[0].enu_m).norm(), 1e-7);
}

TEST(ControlAdjustment, LevelledStationsMakeTwoPointsEnough) {
  Survey survey(5, 2, 0.0);
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
  Survey survey(7, 5, 0.0);
  for (std::size_t k = 0; k < 5; ++k) {
    survey.points[k].enu_m = Eigen::Vector3d(10.0, 4.0, 0.5) * static_cast<double>(k);
  }
  EXPECT_FALSE(IsDetermined(survey.Input()));
  EXPECT_EQ(AdjustToControl(survey.Input()).status, Status::kUndetermined);
  EXPECT_EQ(FitToControl(survey.Input()).status, Status::kUndetermined);
}

}  // namespace
}  // namespace backsight
