#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "graph/control_adjustment.h"

namespace backsight {

/// A free network of five stations with correlated errors, and control with noise that its sigmas
/// state, all drawn from a seed.
struct ControlSurvey {
  static constexpr std::size_t kStations = 5;
  static constexpr double kSightingSigma = 0.001;

  explicit ControlSurvey(std::uint64_t seed, std::size_t point_count = 6, double noise = 1.0)
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

  static Eigen::Vector3d Draw(Random& random, double sigma) {
    const double x = sigma * random.Normal();
    const double y = sigma * random.Normal();
    return {x, y, sigma * random.Normal()};
  }

  static Eigen::Vector3d Somewhere(Random& random, double reach, double height) {
    const double x = random.Uniform(-reach, reach);
    const double y = random.Uniform(-reach, reach);
    return {x, y, random.Uniform(-height, height)};
  }

  Random random;
  RigidTransform enu_from_survey;
  std::vector<RigidTransform> truth, survey_from_station;
  Eigen::MatrixXd covariance;
  std::vector<SurveyedPoint> points;
  std::vector<TiltObservation> tilts;
};

}  // namespace backsight
