#include "stages/tabulated_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/error.h"
#include "core/execution.h"

namespace backsight {
namespace {

/// Bends as the Earth does, turns a little, and goes far away.
Eigen::Vector3d Bent(const Eigen::Vector3d& p) {
  constexpr double kRadius = 6.37e6;
  const double drop = 0.5 * (p.x() * p.x() + p.y() * p.y()) / kRadius;
  return {690000.0 + 0.9996 * p.x() + 0.01 * p.y(), 5336000.0 - 0.01 * p.x() + 0.9996 * p.y(),
          500.0 + p.z() + drop};
}

std::vector<Eigen::Vector3d> RandomPoints(double extent_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-extent_m, extent_m);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 20000; ++i) points.emplace_back(place(random), place(random), place(random));
  return points;
}

double WorstError(const std::vector<Eigen::Vector3d>& points, TabulatedMap* map,
                  const TabulatedMap::Exact& exact) {
  std::vector<Eigen::Vector3d> mapped = points;
  map->Apply(mapped);
  double worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    worst = std::max(worst, (mapped[i] - exact(points[i])).norm());
  }
  return worst;
}

TEST(TabulatedMap, KeepsItsToleranceWithFewLooksAtTheMap) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    int looks = 0;
    TabulatedMap map(
        [&](const Eigen::Vector3d& p) {
          ++looks;
          return Bent(p);
        },
        4.0, 2e-6);
    EXPECT_LT(WorstError(RandomPoints(20.0, seed), &map, Bent), 2e-6);
    EXPECT_LE(looks, 15 * 11 * 11 * 11);
    const int before = looks;
    EXPECT_LT(WorstError(RandomPoints(19.0, seed + 10), &map, Bent), 2e-6);
    EXPECT_EQ(looks, before) << "cells that were known were made again";
  }
}

TEST(TabulatedMap, MapsExactlyWhereItCannotInterpolate) {
  const auto kinked = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x(), p.y(), p.z() + 1e-3 * std::abs(p.x() - 1.7));
  };
  TabulatedMap map(kinked, 4.0, 2e-6);
  EXPECT_LT(WorstError(RandomPoints(30.0, 4), &map, kinked), 2e-6);
  for (const double place : {0.3, 1.0, 1.7, 2.5}) {  // edges about as faint as the tolerance
    for (const double slope : {1e-6, 2e-6, 4e-6}) {
      const auto faint = [=](const Eigen::Vector3d& p) {
        return Eigen::Vector3d(p.x(), p.y(), p.z() + slope * std::abs(p.x() - place));
      };
      TabulatedMap other(faint, 4.0, 2e-6);
      EXPECT_LT(WorstError(RandomPoints(6.0, 5), &other, faint), 2e-6) << place << " " << slope;
    }
  }
  const std::vector<Eigen::Vector3d> far = {{1e9, 0.0, 0.0}, {0.0, -3e8, 5.0}};
  TabulatedMap bent(Bent, 4.0, 2e-6);
  EXPECT_EQ(WorstError(far, &bent, Bent), 0.0);
}

TEST(TabulatedMap, PlacesThatCannotBeMappedCostNoOthers) {
  const auto half = [](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    if (p.x() > 1.0) throw InputError({"there", "x > 1", "x <= 1", ""});
    return 2.0 * p;
  };
  TabulatedMap map(half, 4.0, 2e-6);
  std::vector<Eigen::Vector3d> points = {{0.5, 0.5, 0.5}};
  map.Apply(points);
  EXPECT_EQ(points[0], Eigen::Vector3d(1.0, 1.0, 1.0));
  points = {{1.5, 0.5, 0.5}};
  EXPECT_THROW(map.Apply(points), InputError);
}

TEST(TabulatedMap, TheSameForAnyNumberOfThreadsAndAnyOrder) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(50.0, 5);
  TabulatedMap alone(Bent, 4.0, 2e-6);
  std::vector<Eigen::Vector3d> expected = points;
  alone.Apply(expected);
  TabulatedMap shared(Bent, 4.0, 2e-6);
  std::vector<Eigen::Vector3d> mapped(points.rbegin(), points.rend());
  ExecutionContext(4).ParallelFor(
      200, [&](std::size_t i) { shared.Apply(std::span(mapped).subspan(100 * i, 100)); });
  std::reverse(mapped.begin(), mapped.end());
  EXPECT_EQ(mapped, expected);
}

}  // namespace
}  // namespace backsight
