#include "core/angular_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// All beams between two polar angles, at ranges that differ wildly, of which a share returns.
AngularStep Scan(double azimuth_step_deg, double polar_step_deg, double share) {
  Random random(7);
  const Eigen::Vector3d scanner(4.0, -7.0, 1.6);
  AngularStep step(scanner);
  for (double polar = 30.0; polar < 140.0; polar += polar_step_deg) {
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += azimuth_step_deg) {
      if (random.Uniform() > share) continue;
      const double p = polar * kDegree;
      const double a = azimuth * kDegree;
      const Eigen::Vector3d beam(std::sin(p) * std::cos(a), std::sin(p) * std::sin(a), std::cos(p));
      step.Add(scanner + random.Uniform(0.5, 80.0) * beam);
    }
  }
  return step;
}

TEST(AngularStep, IsThatOfTheGrid) {
  for (const double step : {0.1, 0.35, 0.8, 1.3}) {
    EXPECT_NEAR(Scan(step, step, 1.0).Radians(), step * kDegree, 0.05 * step * kDegree);
  }
}

TEST(AngularStep, IsTheMeanOfTwoStepsAndGrowsWhereBeamsDoNotReturn) {
  EXPECT_NEAR(Scan(0.2, 0.8, 1.0).Radians(), 0.4 * kDegree, 0.02 * kDegree);
  EXPECT_NEAR(Scan(0.2, 0.2, 0.25).Radians(), 0.4 * kDegree, 0.02 * kDegree);
}

TEST(AngularStep, IsZeroWithoutPoints) {
  EXPECT_EQ(AngularStep(Eigen::Vector3d::Zero()).Radians(), 0.0);
  ;
}

}  // namespace
}  // namespace backsight
