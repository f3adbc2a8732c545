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
}

/// Every cell that a point lies in, looked for one by one.
double StepByCells(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& scanner) {
  RangeImage covered(scanner, 2.0);
  for (const Eigen::Vector3d& point : points) covered.Add(point);
  const auto cells = static_cast<double>(covered.Measured());
  return covered.PixelAngle() * std::sqrt(cells / static_cast<double>(points.size()));
}

TEST(AngularStep, CoversWhatIsFoundCellByCell) {
  const Eigen::Vector3d scanner(700.0, -90.0, 3.0);
  Random random(11);
  std::vector<Eigen::Vector3d> points;
  const auto add = [&](double polar, double azimuth, double range) {
    points.push_back(scanner + range * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                       std::sin(polar) * std::sin(azimuth),
                                                       std::cos(polar)));
  };
  // Lines that creep across borders of cells, by less than any margin and by more, along borders,
  // through the poles and across azimuth 180 degrees.
  for (int line = 0; line < 300; ++line) {
    const double step = std::pow(10.0, random.Uniform(-9.0, -2.0));
    const double polar = 2.0 * kDegree * static_cast<double>(random.Index(91)) - 20 * step;
    const double azimuth = 2.0 * kDegree * static_cast<double>(random.Index(181)) - 20 * step;
    for (int i = 0; i < 40; ++i) {
      const double range = random.Uniform(0.5, 90.0);
      if (line % 3 != 0) add(polar + i * step, azimuth + 0.01, range);
      if (line % 3 != 1) add(polar + 0.01, azimuth + i * step, range);
    }
  }
  // The scanner's own place lies in no direction; beams to the zenith behind it count.
  points[points.size() / 2] = scanner;
  points[points.size() / 2 + 1] = scanner + Eigen::Vector3d(0.0, 0.0, 3.0);
  AngularStep whole(scanner);
  std::vector<AngularStep> parts(3, AngularStep(scanner));
  for (std::size_t i = 0; i < points.size(); ++i) {
    whole.Add(points[i]);
    parts[i / 1000 % 3].Add(points[i]);
  }
  EXPECT_EQ(whole.Radians(), StepByCells(points, scanner));
  for (const AngularStep& part : {parts[1], parts[2]}) parts[0].Add(part);
  EXPECT_EQ(parts[0].Radians(), whole.Radians());
}

}  // namespace
}  // namespace backsight
