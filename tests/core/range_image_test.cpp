#include "core/range_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

using std::numbers::pi;

Eigen::Vector3d Direction(double azimuth_deg, double polar_deg) {
  const double a = azimuth_deg * pi / 180.0;
  const double p = polar_deg * pi / 180.0;
  return {std::sin(p) * std::cos(a), std::sin(p) * std::sin(a), std::cos(p)};
}

TEST(RangeImage, HasSquarePixels) {
  const RangeImage image(Eigen::Vector3d::Zero(), 0.5);
  EXPECT_EQ(image.rows(), 360);
  EXPECT_EQ(image.columns(), 720);
  const RangeImage coarse(Eigen::Vector3d::Zero(), 1000.0);
  EXPECT_EQ(coarse.rows(), 1);
  EXPECT_EQ(coarse.columns(), 2);
}

TEST(RangeImage, KnownDirectionsFallIntoTheirOwnPixels) {
  const Eigen::Vector3d origin(1.0, -2.0, 1.5);
  // Inside the same pixel of 1 deg, across a border in azimuth, across one in polar angle.
  for (const double azimuth : {-179.5, -90.5, 0.5, 44.5, 179.5}) {
    for (const double polar : {0.5, 30.5, 90.5, 150.5, 179.5}) {
      RangeImage image(origin, 1.0);
      image.Add(origin + 7.0 * Direction(azimuth, polar));
      EXPECT_FLOAT_EQ(image.At(origin + 3.0 * Direction(azimuth + 0.4, polar - 0.4)).max_m, 7.0F);
      EXPECT_EQ(image.At(origin + Direction(azimuth + 1.0, polar)).max_m, 0.0F);
      EXPECT_EQ(image.At(origin + Direction(azimuth, polar < 90 ? polar + 1 : polar - 1)).max_m,
                0.0F);
      EXPECT_EQ(image.At(origin + Direction(azimuth + 180.0, polar)).max_m, 0.0F);
    }
  }
}

TEST(RangeImage, AcceptsEveryDirection) {
  RangeImage image(Eigen::Vector3d::Zero(), 10.0);
  for (const double x : {-1.0, -0.0, 0.0, 1.0}) {
    for (const double y : {-1.0, -0.0, 0.0, 1.0}) {
      for (const double z : {-1.0, -0.0, 0.0, 1.0}) {
        image.Add({x, y, z});
        const bool is_origin = x == 0.0 && y == 0.0 && z == 0.0;
        EXPECT_TRUE(is_origin || image.At({x, y, z}).max_m > 0.0F);
      }
    }
  }
}

TEST(RangeImage, KeepsNearestAndFarthest) {
  RangeImage image(Eigen::Vector3d::Zero(), 1.0);
  const Eigen::Vector3d direction = Direction(33.5, 77.5);
  for (const double range : {5.0, 2.0, 9.0, 4.0}) image.Add(range * direction);
  EXPECT_FLOAT_EQ(image.At(direction).min_m, 2.0F);
  EXPECT_FLOAT_EQ(image.At(direction).max_m, 9.0F);
}

TEST(RangeImage, IgnoresTheOriginAndNonsense) {
  const Eigen::Vector3d origin(1.0, 2.0, 3.0);
  RangeImage image(origin, 5.0);
  image.Add(origin);
  image.Add(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(image.Coverage(), 0.0);
}

TEST(RangeImage, FullSphereIsCoveredOnce) {
  RangeImage image(Eigen::Vector3d::Zero(), 5.0);
  for (double azimuth = -178.75; azimuth < 180.0; azimuth += 2.5) {
    for (double polar = 1.25; polar < 180.0; polar += 2.5)
      image.Add(4.0 * Direction(azimuth, polar));
  }
  EXPECT_NEAR(image.Coverage(), 1.0, 1e-12);
}

TEST(RangeImage, CoverageIsBySolidAngle) {
  RangeImage image(Eigen::Vector3d::Zero(), 1.0);
  // A cap of 60 deg about the zenith is a quarter of the sphere, though a third of the rows.
  for (double azimuth = -179.5; azimuth < 180.0; azimuth += 1.0) {
    for (double polar = 0.5; polar < 60.0; polar += 1.0) image.Add(Direction(azimuth, polar));
  }
  EXPECT_NEAR(image.Coverage(), 0.25, 1e-4);
}

TEST(RangeImage, RandomDirectionsFillIt) {
  Random random(1);
  RangeImage image(Eigen::Vector3d::Zero(), 10.0);
  double last = 0.0;
  for (int k = 0; k < 5; ++k) {
    for (int i = 0; i < 2000; ++i) image.Add(random.Rotation().col(0));
    EXPECT_GE(image.Coverage(), last);
    last = image.Coverage();
  }
  EXPECT_GT(last, 0.99);
}

TEST(RangeImage, WithoutPixelsNothingIsCovered) { EXPECT_EQ(RangeImage().Coverage(), 0.0); }

/// Row and column with the library's arc tangent.
std::pair<int, int> ReferenceCell(const RangeImage& image, const Eigen::Vector3d& d) {
  const double azimuth = std::atan2(d.y(), d.x());
  const double polar = std::atan2(std::hypot(d.x(), d.y()), d.z());
  return {std::clamp(static_cast<int>(polar / pi * image.rows()), 0, image.rows() - 1),
          std::clamp(static_cast<int>((azimuth + pi) / (2.0 * pi) * image.columns()), 0,
                     image.columns() - 1)};
}

TEST(RangeImage, PixelsAreThoseOfTheArcTangent) {
  Random random(5);
  RangeImage image(Eigen::Vector3d::Zero(), 0.25);
  std::map<std::pair<int, int>, float> farthest;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < 200000; ++i) {
    Eigen::Vector3d d(random.Normal(), random.Normal(), random.Normal());
    // On and beside the pixels' edges too, where a quick arc tangent alone would err.
    if (i % 2 == 0) {
      const double azimuth = 0.25 * static_cast<double>(random.Index(1440));
      const double polar = 0.25 * static_cast<double>(random.Index(721));
      d = Direction(azimuth + 1e-9 * random.Normal(), polar + 1e-9 * random.Normal());
    }
    const Eigen::Vector3d point = random.Uniform(1.0, 50.0) * d;
    image.Add(point);
    float& max = farthest[ReferenceCell(image, point)];
    max = std::max(max, static_cast<float>(point.norm()));
    directions.push_back(point);
  }
  for (const Eigen::Vector3d& point : directions) {
    ASSERT_EQ(image.At(point).max_m, farthest[ReferenceCell(image, point)]);
  }
  EXPECT_EQ(image.Measured(), farthest.size());
}

/// Three rows, and in each as many columns as make up a pixel's angle, one by one.
RangeImage::Window ReferenceWindow(const RangeImage& image, const Eigen::Vector3d& point) {
  const auto range = static_cast<float>(point.norm());
  const auto [row, column] = image.PixelOf(point);
  RangeImage::Window window;
  bool any = false;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, image.rows() - 1); ++r) {
    const double polar = pi * (r + 0.5) / image.rows();
    const int reach =
        std::min(static_cast<int>(std::lround(1.0 / std::sin(polar))), image.columns() / 2 - 1);
    for (int step = -reach; step <= reach; ++step) {
      const double azimuth = 2.0 * pi * (column + step + 0.5) / image.columns() - pi;
      const RangeImage::Pixel& pixel =
          image.At(Direction(azimuth * 180.0 / pi, polar * 180.0 / pi));
      if (pixel.max_m == 0.0F) continue;
      const float gap = std::min(std::abs(pixel.min_m - range), std::abs(pixel.max_m - range));
      window.nearest_m = any ? std::min(window.nearest_m, pixel.min_m) : pixel.min_m;
      window.gap_m = any ? std::min(window.gap_m, gap) : gap;
      window.farthest_m = std::max(window.farthest_m, pixel.max_m);
      any = true;
    }
  }
  if (any) window.middle = image.At(point);
  return window;
}

TEST(RangeImage, WindowsHoldThePixelsAroundADirection) {
  Random random(6);
  for (const double pixel_deg : {2.0, 9.0, 60.0}) {
    RangeImage image(Eigen::Vector3d::Zero(), pixel_deg);
    // About a quarter of the pixels, some of them with two ranges.
    for (int i = 0; i < image.rows() * image.columns() / 4; ++i) {
      image.Add(random.Uniform(1.0, 20.0) * random.Rotation().col(0));
    }
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3d point = random.Uniform(1.0, 20.0) * random.Rotation().col(0);
      const RangeImage::Window window = image.Around(point);
      const RangeImage::Window expected = ReferenceWindow(image, point);
      ASSERT_EQ(window.nearest_m, expected.nearest_m);
      ASSERT_EQ(window.farthest_m, expected.farthest_m);
      ASSERT_EQ(window.gap_m, expected.gap_m);
      ASSERT_EQ(window.middle.max_m, expected.middle.max_m);
      ASSERT_EQ(window.middle.min_m, expected.middle.min_m);
    }
  }
}

}  // namespace
}  // namespace backsight
