#include "stages/fine_registration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "stages/surface_choice.h"
#include "stages/surface_refinement.h"
#include "tests/support/hall_scene.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

constexpr double kDeg = 0.017453292519943295;

/// Information of a coarse result: half a degree and five centimetres.
Matrix6d CoarseInformation() {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.5 * kDeg), Eigen::Vector3d::Constant(0.05);
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

struct PairOfScans {
  explicit PairOfScans(std::uint64_t seed, const HallOptions& hall = {}, const HallScan& scan = {})
      : scene(seed, hall),
        target(scene, {-5.0, -2.5, 1.6}, 10 * seed, scan),
        source(scene, {2.0, 2.0, 1.7}, 10 * seed + 1, scan),
        truth(target.world_from_station.Inverse() * source.world_from_station) {}

  FineResult Refine(const RigidTransform& start, const FineOptions& options) const {
    return RefinePair(
        {source.surface(), target.surface(), target.index, start, CoarseInformation(), {}}, options,
        ExecutionContext(1, 0, nullptr));
  }

  HallScene scene;
  HallStation target;
  HallStation source;
  RigidTransform truth;
};

RigidTransform Disturbed(std::uint64_t seed, const RigidTransform& truth) {
  Random random(seed);
  return Retract(truth, RandomTwist(random, 0.3 * kDeg, 0.05));
}

TEST(FineRegistration, RefinesOnPlanesToTheMillimetre) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const PairOfScans pair(seed);
    const FineResult result = pair.Refine(Disturbed(seed, pair.truth), {});
    EXPECT_EQ(result.status, FineResult::Status::kRefined);
    EXPECT_TRANSFORM_NEAR(result.target_from_source, pair.truth, 0.01 * kDeg, 0.001);
    EXPECT_GT(result.planes, 50);
    EXPECT_GT(result.eigenvalue_ratio, 0.0);
  }
}

TEST(FineRegistration, WhatIsMadeBeforehandChangesNothing) {
  const PairOfScans pair(2);
  const RigidTransform start = Disturbed(2, pair.truth);
  const PlaneTree planes = MakePlaneTree(pair.target.surface(), {});
  FineInput input{pair.source.surface(), pair.target.surface(),
                  pair.target.index,     start,
                  CoarseInformation(),   {}};
  input.target_planes = &planes;
  const std::vector<std::uint32_t> surfaces =
      ChooseSurfaces(pair.source.features.normals, kRefinedSurfaces);
  input.source_surfaces = &surfaces;
  const FineResult with = RefinePair(input, {}, ExecutionContext(1));
  const FineResult without = pair.Refine(start, {});
  EXPECT_EQ(with.planes, without.planes);
  EXPECT_EQ(with.target_from_source.Matrix(), without.target_from_source.Matrix());
  EXPECT_EQ(with.information, without.information);
}

/// With planes forbidden, pairs of voxels must do, and their information must be honest: errors of
/// about as many standard deviations as it claims.
TEST(FineRegistration, RefinesOnSurfacesWherePlanesAreFew) {
  FineOptions options;
  options.min_planes = 10000;
  double nees = 0.0;
  constexpr int kSeeds = 6;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const PairOfScans pair(seed);
    const FineResult result = pair.Refine(Disturbed(seed, pair.truth), options);
    EXPECT_EQ(result.status, FineResult::Status::kRefinedOnSurfaces) << "seed " << seed;
    EXPECT_GT(result.surface_matches, 1000);
    EXPECT_TRANSFORM_NEAR(result.target_from_source, pair.truth, 0.1 * kDeg, 0.01);
    const Vector6d error = LocalDifference(result.target_from_source, pair.truth);
    nees += error.dot(result.information * error) / 6.0 / kSeeds;
  }
  EXPECT_LT(nees, 6.0) << "too bold";
  EXPECT_GT(nees, 0.02) << "too timid";
}

struct TunnelCase {
  const char* name;
  HallScan scan;
  FineOptions options;
  double coarse_sigma_m = 0.05;
};
void PrintTo(const TunnelCase& tunnel, std::ostream* out) { *out << tunnel.name; }

/// A tunnel whose ends no scanner sees: what lies in the voxels of its walls is the same wherever
/// along it the scanners stood. Nothing may claim to know it, nor move the start along it.
class Tunnel : public ::testing::TestWithParam<TunnelCase> {};

TEST_P(Tunnel, LeavesTheWayAlongItToTheStart) {
  const TunnelCase& tunnel = GetParam();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const PairOfScans pair(seed, {.boxes = 0, .size_m = {2000.0, 11.0, 5.0}}, tunnel.scan);
    const RigidTransform start = Disturbed(seed, pair.truth);
    Matrix6d coarse = CoarseInformation();
    coarse.bottomRightCorner<3, 3>() =
        Eigen::Matrix3d::Identity() / (tunnel.coarse_sigma_m * tunnel.coarse_sigma_m);
    const FineResult result = RefinePair(
        {pair.source.surface(), pair.target.surface(), pair.target.index, start, coarse, {}},
        tunnel.options, ExecutionContext(1));
    EXPECT_GT(result.planes, 200);
    EXPECT_EQ(result.status, FineResult::Status::kWeak) << "seed " << seed;
    EXPECT_EQ(result.weakest_sigma_m, 100.0) << "nothing holds it";
    const Eigen::Matrix3d world_from_target = pair.target.world_from_station.rotation;
    const Eigen::Vector3d open = result.weakest_direction.tail<3>();
    EXPECT_GT(std::abs((world_from_target * open).x()), 0.99);
    const double known = open.dot((result.information - coarse).bottomRightCorner<3, 3>() * open);
    EXPECT_NEAR(known, 0.0, 1.0) << "beside what the start knows, 1 / m^2";
    const Eigen::Vector3d error =
        world_from_target * (result.target_from_source.translation - pair.truth.translation);
    const Eigen::Vector3d before = world_from_target * (start.translation - pair.truth.translation);
    EXPECT_NEAR(error.x(), before.x(), 0.02) << "the start's turn moves the middle of the planes";
    EXPECT_LT(error.tail<2>().norm(), std::max(0.003, tunnel.scan.noise_m));
  }
}

INSTANTIATE_TEST_SUITE_P(
    FineRegistration, Tunnel,
    ::testing::Values(TunnelCase{"Usual", {}, {}}, TunnelCase{"OneRound", {}, {.rounds = 1}},
                      TunnelCase{"SmallVoxels", {.step_deg = 0.25, .resolution_m = 0.05}, {}},
                      TunnelCase{"MuchNoise", {.noise_m = 0.02}, {}},
                      TunnelCase{"SureStart", {}, {}, 0.001}),
    [](const auto& param) { return param.param.name; });

TEST(FineRegistration, OneWallAcrossATunnelHoldsIt) {
  const PairOfScans pair(1, {.boxes = 0, .size_m = {60.0, 11.0, 5.0}});
  const FineResult result = pair.Refine(Disturbed(1, pair.truth), {});
  EXPECT_EQ(result.status, FineResult::Status::kRefined);
  EXPECT_TRANSFORM_NEAR(result.target_from_source, pair.truth, 0.01 * kDeg, 0.002);
}

TEST(FineRegistration, ReturnsTheStartWhereNothingMatches) {
  const PairOfScans pair(2);
  RigidTransform far = pair.truth;
  far.translation += Eigen::Vector3d(0.0, 0.0, 200.0);
  const FineResult result = pair.Refine(far, {});
  EXPECT_EQ(result.status, FineResult::Status::kTooFewPlanes);
  EXPECT_EQ(result.target_from_source.Matrix(), far.Matrix());
  EXPECT_EQ(result.information, CoarseInformation());
}

TEST(FineRegistration, DoesNotCountSurfacesWherePlanesSuffice) {
  const PairOfScans pair(3);
  FineOptions without;
  without.surfaces = false;
  const RigidTransform start = Disturbed(3, pair.truth);
  const FineResult result = pair.Refine(start, {});
  EXPECT_EQ(result.surface_matches, 0);
  EXPECT_TRUE(result.information.isApprox(pair.Refine(start, without).information, 1e-9));
}

}  // namespace
}  // namespace backsight
