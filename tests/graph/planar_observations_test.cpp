#include <gtest/gtest.h>

#include <Eigen/LU>

#include "graph/planar_adjustment.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Poses = std::vector<RigidTransform>;

Poses Moved(const Poses& poses, Eigen::Index row, double step) {
  Poses moved = poses;
  Vector6d xi = Vector6d::Zero();
  xi[row % 6] = step;
  auto& pose = moved[static_cast<std::size_t>(row / 6)];
  pose = Retract(pose, xi);
  return moved;
}

Eigen::VectorXd NumericGradient(const PlanarProblem& problem, const Poses& poses) {
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(6 * poses.size()));
  constexpr double kStep = 1e-6;
  for (Eigen::Index row = 0; row < gradient.size(); ++row) {
    gradient[row] = (PlanarCost(problem, Moved(poses, row, kStep)) -
                     PlanarCost(problem, Moved(poses, row, -kStep))) /
                    (2.0 * kStep);
  }
  return gradient;
}

/// Stations that are upright within `tilt_rad`, with any heading.
Poses UprightStations(Random& random, int stations, double tilt_rad) {
  Poses poses;
  for (int s = 0; s < stations; ++s) {
    const Eigen::Vector3d heading(0.0, 0.0, random.Uniform(-3.0, 3.0));
    const Eigen::Vector3d tilt = tilt_rad * random.Rotation().col(0);
    poses.push_back({ExpSo3(tilt) * ExpSo3(heading), RandomPoint(random, 20.0)});
  }
  return poses;
}

TEST(PlanarObservations, GradientOfLinksMatchesFiniteDifferences) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const SyntheticNetwork network = MakeNetwork(seed, 4, 0.7, 1.0);
    const Poses poses = Disturbed(random, network.survey_from_station, -1, 0.05, 0.2);
    const PlanarProblem problem{{}, {{}, network.links, {}}, nullptr};
    const NormalEquations system = AssembleNormalEquations(problem, poses);
    EXPECT_NEAR(system.cost, PlanarCost(problem, poses), 1e-12 * system.cost);
    EXPECT_LT((system.gradient - NumericGradient(problem, poses)).norm(),
              1e-5 * system.gradient.norm())
        << seed;
  }
}

TEST(PlanarObservations, GradientOfTiltsMatchesFiniteDifferences) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const Poses poses = UprightStations(random, 4, 0.02);
    const std::vector<TiltObservation> tilts = {{0, 1e-3}, {1, 2e-3}, {3, 5e-4}};
    const PlanarProblem problem{{}, {{}, {}, tilts}, nullptr};
    const NormalEquations system = AssembleNormalEquations(problem, poses);
    EXPECT_NEAR(system.cost, PlanarCost(problem, poses), 1e-12 * system.cost);
    EXPECT_LT((system.gradient - NumericGradient(problem, poses)).norm(),
              1e-5 * system.gradient.norm())
        << seed;
    EXPECT_EQ(system.gradient.segment<6>(12).norm(), 0.0) << "station 2 is not levelled";
  }
}

TEST(PlanarObservations, MatrixAnnihilatesACommonMotion) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const SyntheticNetwork network = MakeNetwork(seed, 5, 0.5, 1.0);
    const SyntheticPlanes scene = MakePlanes(seed, {.stations = 5, .noise_m = 0.005});
    const Poses poses = Disturbed(random, scene.world_from_station, -1, 0.01, 0.05);
    // A link's Gauss-Newton matrix is invariant wherever the stations stand.
    const PlanarProblem problem{scene.planes, {{}, network.links, {}}, nullptr};
    const Eigen::MatrixXd matrix = AssembleNormalEquations(problem, poses).matrix;
    Eigen::VectorXd common(matrix.rows());
    for (Eigen::Index s = 0; s < 5; ++s) common.segment<6>(6 * s) = RandomTwist(random, 1.0, 1.0);
    for (Eigen::Index s = 1; s < 5; ++s) common.segment<6>(6 * s) = common.head<6>();
    EXPECT_LT((matrix * common).norm(), 1e-11 * matrix.norm() * common.norm());
    EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-12 * matrix.norm());
  }
}

TEST(PlanarObservations, TiltsLeaveHeadingAndPositionsOpen) {
  Random random(3);
  const Poses poses = UprightStations(random, 3, 0.0);
  const std::vector<TiltObservation> tilts = {{0, 1e-3}, {1, 1e-3}, {2, 1e-3}};
  const Eigen::MatrixXd matrix =
      AssembleNormalEquations(PlanarProblem{{}, {{}, {}, tilts}, nullptr}, poses).matrix;
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(matrix);
  EXPECT_EQ(lu.rank(), 4) << "two tilts for each station but one";
}

TEST(PlanarObservations, LevelledStationsComeUpright) {
  Random random(4);
  // Parallel planes leave one tilt and more open; the levels close the tilts.
  Poses truth = UprightStations(random, 3, 0.0);
  const std::vector<TiltObservation> tilts = {{0, 1e-4}, {1, 1e-4}, {2, 1e-4}};
  Poses start = truth;
  start[1] = Retract(start[1], (Vector6d() << 0.01, -0.02, 0, 0, 0, 0).finished());
  std::vector<PosePrior> priors;
  for (int s = 0; s < 3; ++s) {
    priors.push_back({s, start[static_cast<std::size_t>(s)], Matrix6d::Identity() * 1.0});
  }
  const SyntheticPlanes one = MakePlanes(4, {.stations = 3, .planes = 1});
  std::vector<WeightedPlane> planes = one.planes;
  planes[0].weight = 1e-9;
  const auto result =
      AdjustPlanes(PlanarProblem{planes, {priors, {}, tilts}, nullptr}, start, 0, {});
  for (const RigidTransform& pose : result.poses) {
    EXPECT_LT((pose.rotation.col(2) - truth[0].rotation.col(2)).norm(), 1e-4);
  }
}

TEST(PlanarObservations, ThreadsDoNotChangeABit) {
  const SyntheticNetwork network = MakeNetwork(5, 6, 0.5, 1.0);
  const SyntheticPlanes scene =
      MakePlanes(5, {.stations = 6, .planes = 300, .points = 20, .noise_m = 0.005});
  const ExecutionContext four(4);
  const PlanarProblem serial{scene.planes, {{}, network.links, {}}, nullptr};
  const PlanarProblem parallel{scene.planes, {{}, network.links, {}}, &four};
  const Poses& poses = scene.world_from_station;
  const NormalEquations a = AssembleNormalEquations(serial, poses);
  const NormalEquations b = AssembleNormalEquations(parallel, poses);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.matrix, b.matrix);
  EXPECT_EQ(PlanarCost(serial, poses), PlanarCost(parallel, poses));
}

}  // namespace
}  // namespace backsight
