#include "stages/open_translations.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <vector>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Normals = SyntheticPlaneOptions::Normals;
constexpr double kTwice = 2.0;
constexpr std::uint64_t kSeeds = 10;

SyntheticPlanes PlanesOfTwo(std::uint64_t seed, Normals normals) {
  return MakePlanes(
      seed,
      {.stations = 2, .planes = 300, .noise_m = 0.003, .normals = normals, .seen_by_all = true});
}

Eigen::Vector3d NormalOf(const WeightedPlane& plane, const std::vector<RigidTransform>& poses) {
  const PlaneObservation& seen = plane.observations.front();
  const RigidTransform& pose = poses[static_cast<std::size_t>(seen.station)];
  const PointCluster cluster = Transformed(pose.rotation, pose.translation, seen.cluster);
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(cluster.scatter).eigenvectors().col(0);
}

/// Planes of a box, of those across one axis no more than `across`.
SyntheticPlanes Tunnel(std::uint64_t seed, int across, const Eigen::Vector3d& axis) {
  SyntheticPlanes tunnel = PlanesOfTwo(seed, Normals::kBox);
  std::vector<WeightedPlane> kept;
  for (const WeightedPlane& plane : tunnel.planes) {
    const bool is_across = std::abs(NormalOf(plane, tunnel.world_from_station).dot(axis)) > 0.9;
    if (is_across && across-- <= 0) continue;
    kept.push_back(plane);
  }
  tunnel.planes = kept;
  return tunnel;
}

TEST(OpenTranslations, NoneWherePlanesFaceAllWays) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const Normals normals : {Normals::kAny, Normals::kBox}) {
      const SyntheticPlanes planes = PlanesOfTwo(seed, normals);
      EXPECT_EQ(OpenTranslations(planes.planes, planes.world_from_station, kTwice).cols(), 0);
    }
  }
}

TEST(OpenTranslations, AlongATunnelUntilSomethingStandsAcross) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    // Along the axis that the first plane of the box faces, whichever that is.
    const SyntheticPlanes box = PlanesOfTwo(seed, Normals::kBox);
    const Eigen::Vector3d axis = NormalOf(box.planes.front(), box.world_from_station);
    const SyntheticPlanes tunnel = Tunnel(seed, 0, axis);
    ASSERT_LT(tunnel.planes.size(), box.planes.size());
    const Eigen::Matrix3Xd open =
        OpenTranslations(tunnel.planes, tunnel.world_from_station, kTwice);
    ASSERT_EQ(open.cols(), 1) << "seed " << seed;
    EXPECT_GT(std::abs(open.col(0).dot(axis)), 0.999);
    EXPECT_NEAR(open.col(0).norm(), 1.0, 1e-12);
    const SyntheticPlanes closed = Tunnel(seed, 1, axis);
    EXPECT_EQ(OpenTranslations(closed.planes, closed.world_from_station, kTwice).cols(), 0);
  }
}

TEST(OpenTranslations, BothWaysAlongParallelPlanes) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SyntheticPlanes floor = PlanesOfTwo(seed, Normals::kParallel);
    const Eigen::Matrix3Xd open = OpenTranslations(floor.planes, floor.world_from_station, kTwice);
    ASSERT_EQ(open.cols(), 2) << "seed " << seed;
    const Eigen::Vector3d normal = NormalOf(floor.planes.front(), floor.world_from_station);
    EXPECT_LT((open.transpose() * normal).norm(), 0.02);
  }
}

/// How far planes of the tunnel that stand across it must be weighed down for it to be open, and
/// what the adjustment's own matrix then knows of the way along it, in units of what it pretends
/// without them. Weights of planes, not only how they lie, must count.
TEST(OpenTranslations, UntilPlanesKnowTwiceWhatTheyPretend) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SyntheticPlanes box = PlanesOfTwo(seed, Normals::kBox);
    const std::vector<RigidTransform>& poses = box.world_from_station;
    const Eigen::Vector3d axis = NormalOf(box.planes.front(), poses);
    const auto known = [&](const std::vector<WeightedPlane>& planes) {
      const Eigen::MatrixXd matrix = AssembleNormalEquations(planes, {}, poses).matrix;
      return axis.dot(matrix.bottomRightCorner<3, 3>() * axis);
    };
    const double pretended = known(Tunnel(seed, 0, axis).planes);
    double open_at = 0.0;
    double closed_at = 1.0;
    const auto weighed = [&](double weight) {
      std::vector<WeightedPlane> planes = box.planes;
      for (WeightedPlane& plane : planes) {
        if (std::abs(NormalOf(plane, poses).dot(axis)) > 0.9) plane.weight *= weight;
      }
      return planes;
    };
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (open_at + closed_at);
      const bool is_open = OpenTranslations(weighed(middle), poses, kTwice).cols() > 0;
      (is_open ? open_at : closed_at) = middle;
    }
    EXPECT_GT(known(weighed(closed_at)) / pretended, 1.05) << "seed " << seed;
    EXPECT_LT(known(weighed(closed_at)) / pretended, 4.0) << "seed " << seed;
  }
}

struct Case {
  explicit Case(std::uint64_t seed)
      : random(seed),
        start(RandomTransform(random, 10.0)),
        point(RandomPoint(random, 20.0)),
        motion(Retract(start, RandomTwist(random, 0.05, 0.3))) {
    Eigen::Matrix<double, 6, 20> rows;
    for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = random.Normal();
    information = rows * rows.transpose();
    open.resize(3, static_cast<Eigen::Index>(1 + random.Index(2)));
    for (Eigen::Index i = 0; i < open.cols(); ++i) {
      open.col(i) = RandomPoint(random, 1.0).normalized();
    }
  }

  Random random;
  RigidTransform start;
  Eigen::Vector3d point;  // source frame
  RigidTransform motion;
  Matrix6d information;
  Eigen::Matrix3Xd open;
};

/// By the way of the point itself, and against any other motion that keeps it as well.
TEST(HoldTranslations, KeepsThePointAndChangesAsLittleAsTheInformationLets) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Case c(seed);
    c.motion = c.start;
    c.motion.translation += 1e-4 * RandomPoint(c.random, 1.0);
    const RigidTransform held = HoldTranslations(c.open, c.point, c.start, c.information, c.motion);
    EXPECT_LT((c.open.transpose() * (held * c.point - c.start * c.point)).norm(), 1e-7);
    const auto cost = [&](const RigidTransform& motion) {
      const Vector6d change = LocalDifference(motion, c.motion);
      return change.dot(c.information * change);
    };
    const Eigen::MatrixXd constraint = c.open.transpose() * PointJacobian(held * c.point);
    for (int trial = 0; trial < 20; ++trial) {
      Vector6d other = RandomTwist(c.random, 1e-5, 1e-4);
      other -= constraint.completeOrthogonalDecomposition().solve(constraint * other);
      EXPECT_GT(cost(Retract(held, other)), cost(held));
    }
  }
}

TEST(HoldTranslations, KeepsThePointWhereTheMotionHasTurnedIt) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Case c(seed);
    c.information.topLeftCorner<3, 3>() *= 1e4;  // turns are known, as planes know them
    const RigidTransform held = HoldTranslations(c.open, c.point, c.start, c.information, c.motion);
    const double before = (c.open.transpose() * (c.motion * c.point - c.start * c.point)).norm();
    const double after = (c.open.transpose() * (held * c.point - c.start * c.point)).norm();
    EXPECT_LT(after, 0.01 * before) << "seed " << seed;
  }
}

TEST(HoldTranslations, ChangesNothingWhereNothingIsOpen) {
  const Case c(1);
  const RigidTransform held =
      HoldTranslations(Eigen::Matrix3Xd(3, 0), c.point, c.start, c.information, c.motion);
  EXPECT_EQ(held.Matrix(), c.motion.Matrix());
  EXPECT_EQ(WithoutTranslations(Eigen::Matrix3Xd(3, 0), c.information), c.information);
}

TEST(WithoutTranslations, KnowsWhatIsLeftAfterTheBestTranslation) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Case c(seed);
    const Matrix6d without = WithoutTranslations(c.open, c.information);
    const Eigen::LLT<Matrix6d> root(c.information);
    const Matrix6d upper = root.matrixU();
    Eigen::MatrixXd along = Eigen::MatrixXd::Zero(6, c.open.cols());
    along.bottomRows(3) = c.open;
    for (int trial = 0; trial < 20; ++trial) {
      const Vector6d xi = RandomTwist(c.random, 1.0, 1.0);
      const Eigen::MatrixXd design = upper * along;
      const Eigen::VectorXd best = design.colPivHouseholderQr().solve(upper * xi);
      const double left = (upper * (xi - along * best)).squaredNorm();
      EXPECT_NEAR(xi.dot(without * xi), left, 1e-9 * c.information.norm());
    }
  }
}

}  // namespace
}  // namespace backsight
