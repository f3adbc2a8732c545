#include <gtest/gtest.h>

#include <cmath>

#include "stages/simulation/scanner_model.h"

namespace backsight {
namespace {

/// A scanner without any imperfection.
Scanner PerfectScanner() {
  Scanner scanner;
  scanner.step_deg = 0.25;
  scanner.min_elevation_deg = -45.0;
  scanner.max_elevation_deg = 45.0;
  scanner.range_sigma_m = 0.0;
  scanner.mixed_pixels = false;
  return scanner;
}

void AddWallAt(double x, double half_m, MaterialId material, TriangleMesh& mesh) {
  AddQuad({x, -half_m, -half_m}, {x, half_m, -half_m}, {x, half_m, half_m}, {x, -half_m, half_m},
          material, mesh);
}

RayCaster WallCaster(double x, double half_m) {
  TriangleMesh mesh;
  AddWallAt(x, half_m, AddMaterial({0.6, {0.5, 0.5, 0.5}, false}, mesh), mesh);
  return RayCaster(std::move(mesh));
}

StationScan Scan(const RayCaster& caster, const Scanner& scanner, std::uint64_t seed = 1,
                 int threads = 1) {
  return MeasureStation(caster, {}, scanner, seed, ExecutionContext(threads));
}

std::vector<Eigen::Vector3d> Returns(const StationScan& scan) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d p(scan.grid.x[i], scan.grid.y[i], scan.grid.z[i]);
    if (!p.isZero()) points.push_back(p);
  }
  return points;
}

TEST(Scanner, PerfectReturnsLieOnTheWall) {
  const StationScan scan = Scan(WallCaster(8.0, 4.0), PerfectScanner());
  EXPECT_EQ(scan.rows, 361);
  EXPECT_EQ(scan.columns, 1440);
  const auto points = Returns(scan);
  EXPECT_EQ(points.size(), scan.returns);
  EXPECT_GT(points.size(), 10000U);
  for (const Eigen::Vector3d& p : points) EXPECT_NEAR(p.x(), 8.0, 1e-9);
}

TEST(Scanner, DensityFallsWithRangeSquared) {
  Scanner scanner = PerfectScanner();
  scanner.step_deg = 0.1;
  scanner.min_elevation_deg = -8.0;
  scanner.max_elevation_deg = 8.0;
  const auto count = [&](double range) {
    return static_cast<double>(Scan(WallCaster(range, 0.5), scanner).returns);
  };
  const double near = count(5.0);
  EXPECT_NEAR(near / count(10.0), 4.0, 0.2);
  EXPECT_NEAR(near / count(20.0), 16.0, 1.5);
}

TEST(Scanner, NearObjectThrowsAShadow) {
  TriangleMesh mesh;
  const MaterialId id = AddMaterial({}, mesh);
  AddWallAt(10.0, 4.0, id, mesh);
  AddWallAt(5.0, 0.5, id, mesh);
  for (const Eigen::Vector3d& p : Returns(Scan(RayCaster(std::move(mesh)), PerfectScanner()))) {
    if (p.x() < 7.5) continue;
    EXPECT_GT(p.tail<2>().cwiseAbs().maxCoeff(), 0.999);
  }
}

TEST(Scanner, NoiseHasTheStatedDeviation) {
  Scanner scanner = PerfectScanner();
  scanner.range_sigma_m = 0.003;
  scanner.range_sigma_ppm = 200.0;
  for (const bool mixed : {false, true}) {
    scanner.mixed_pixels = mixed;
    const auto points = Returns(Scan(WallCaster(12.0, 11.0), scanner));
    double sum = 0.0;
    double squares = 0.0;
    for (const Eigen::Vector3d& p : points) {
      const double cos_incidence = p.x() / p.norm();
      const double range = 12.0 / cos_incidence;
      const double residual = (p.norm() - range) / RangeSigma(scanner, range, cos_incidence);
      sum += residual;
      squares += residual * residual;
    }
    const auto n = static_cast<double>(points.size());
    ASSERT_GT(n, 30000.0);
    EXPECT_NEAR(sum / n, 0.0, 4.0 / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(squares / n), 1.0, 4.0 / std::sqrt(2.0 * n));
  }
}

TEST(Scanner, SigmaGrowsWithRangeAndIncidenceUpToACap) {
  Scanner scanner;
  scanner.range_sigma_m = 0.003;
  scanner.range_sigma_ppm = 100.0;
  EXPECT_NEAR(RangeSigma(scanner, 40.0, 1.0), 0.005, 1e-12);
  EXPECT_NEAR(RangeSigma(scanner, 40.0, 0.5), 0.010, 1e-12);
  EXPECT_EQ(RangeSigma(scanner, 40.0, 0.2), RangeSigma(scanner, 40.0, 0.01));
}

/// How many returns lie clearly between a plate at 6 m and a wall behind it.
int CountBetween(double wall_m, bool mixed_pixels) {
  TriangleMesh mesh;
  const MaterialId id = AddMaterial({}, mesh);
  AddWallAt(6.0, 2.0, id, mesh);
  AddWallAt(wall_m, 5.0, id, mesh);
  Scanner scanner = PerfectScanner();
  scanner.mixed_pixels = mixed_pixels;
  scanner.beam_divergence_deg = 0.05;
  int between = 0;
  for (const Eigen::Vector3d& p : Returns(Scan(RayCaster(std::move(mesh)), scanner))) {
    if (p.x() > 6.005 && p.x() < wall_m - 0.005) ++between;
  }
  return between;
}

TEST(Scanner, FootprintsOnEdgesBlend) {
  EXPECT_GT(CountBetween(6.3, true), 20);
  EXPECT_EQ(CountBetween(6.3, false), 0);
  EXPECT_EQ(CountBetween(8.0, true), 0);  // farther apart than mixing_m
}

TEST(Scanner, DropoutLosesTheStatedShare) {
  Scanner scanner = PerfectScanner();
  const RayCaster caster = WallCaster(8.0, 6.0);
  const auto all = static_cast<double>(Scan(caster, scanner).returns);
  scanner.dropout = 0.2;
  const auto kept = static_cast<double>(Scan(caster, scanner).returns);
  EXPECT_NEAR(kept / all, 0.8, 4.0 * std::sqrt(0.16 / all));
}

TEST(Scanner, DarkOrGrazedSurfacesAreLostEarlier) {
  TriangleMesh mesh;
  AddWallAt(20.0, 2.0, AddMaterial({0.05, {0, 0, 0}, false}, mesh), mesh);
  const RayCaster caster(std::move(mesh));
  Scanner scanner = PerfectScanner();
  scanner.max_range_m = 30.0;
  EXPECT_GT(Scan(caster, scanner).returns, 0U);
  scanner.max_range_m = 25.0;  // 0.05 * (25 / 20)^2 < 0.1
  EXPECT_EQ(Scan(caster, scanner).returns, 0U);
}

TEST(Scanner, GlassMostlyLetsThePulseThrough) {
  TriangleMesh mesh;
  AddWallAt(5.0, 3.0, AddMaterial({0.1, {0, 0, 0}, true}, mesh), mesh);
  AddWallAt(8.0, 10.0, AddMaterial({}, mesh), mesh);
  Scanner scanner = PerfectScanner();
  int pane = 0;
  int behind = 0;
  for (const Eigen::Vector3d& p : Returns(Scan(RayCaster(std::move(mesh)), scanner))) {
    if (std::abs(p.y() / p.x()) > 0.55 || std::abs(p.z() / p.x()) > 0.55) continue;
    ++(p.x() < 6.0 ? pane : behind);
  }
  EXPECT_GT(pane, 100);
  EXPECT_GT(behind, 4 * pane);
}

TEST(Scanner, SameSeedSameBytesForAnyThreads) {
  Scanner scanner = PerfectScanner();
  scanner.step_deg = 0.5;
  scanner.range_sigma_m = 0.002;
  scanner.mixed_pixels = true;
  scanner.dropout = 0.1;
  const RayCaster caster = WallCaster(8.0, 4.0);
  const StationScan one = Scan(caster, scanner, 7, 1);
  const StationScan four = Scan(caster, scanner, 7, 4);
  EXPECT_EQ(one.grid.x, four.grid.x);
  EXPECT_EQ(one.grid.y, four.grid.y);
  EXPECT_EQ(one.grid.z, four.grid.z);
  EXPECT_EQ(one.grid.intensity, four.grid.intensity);
  EXPECT_EQ(one.grid.rgb, four.grid.rgb);
  EXPECT_EQ(one.returns, four.returns);
  EXPECT_NE(one.grid.x, Scan(caster, scanner, 8, 1).grid.x);
}

}  // namespace
}  // namespace backsight
