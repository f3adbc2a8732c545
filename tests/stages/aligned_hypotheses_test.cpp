#include "stages/aligned_hypotheses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "stages/dominant_frame.h"

namespace backsight {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Normals of a building in a frame of its own: floor, two families of walls, noise of `sigma_rad`,
/// and `clutter` of them in any direction.
std::vector<Eigen::Vector3f> BuildingNormals(Random* random, const Eigen::Matrix3d& frame,
                                             double sigma_rad, double clutter) {
  std::vector<Eigen::Vector3f> normals;
  for (int i = 0; i < 3000; ++i) {
    Eigen::Vector3d n(random->Normal(), random->Normal(), random->Normal());
    if (random->Uniform() >= clutter) {
      const double kind = random->Uniform();
      const int axis = kind < 0.4 ? 2 : kind < 0.75 ? 0 : 1;
      n = sigma_rad * n + (random->Index(2) == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(axis);
    }
    normals.emplace_back((frame * n.normalized()).cast<float>());
  }
  return normals;
}

/// Largest angle between an axis of one frame and the nearest axis of the other.
double AxesApart(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d cosines = (a.transpose() * b).cwiseAbs();
  return std::acos(std::min(1.0, cosines.rowwise().maxCoeff().minCoeff()));
}

TEST(DominantFrame, IsTheBuildingsWhateverTheStationsHeading) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Eigen::Matrix3d frame = random.Rotation();
    const auto normals = BuildingNormals(&random, frame, 0.03, 0.3);
    const DominantFrame found = FindDominantFrame(normals);
    EXPECT_TRUE((found.frame_from_cloud * found.frame_from_cloud.transpose()).isIdentity(1e-9));
    EXPECT_NEAR(found.frame_from_cloud.determinant(), 1.0, 1e-9);
    EXPECT_LT(AxesApart(found.frame_from_cloud.transpose(), frame), 1.0 * kDegree) << seed;
    EXPECT_GT(found.wall_share, 0.5);
  }
}

TEST(DominantFrame, KeepsTheVerticalItIsGiven) {
  Random random(3);
  const Eigen::Matrix3d frame(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  const auto normals = BuildingNormals(&random, frame, 0.03, 0.5);
  const DominantFrame found = FindDominantFrame(normals, Eigen::Vector3d(0.0, 0.0, 2.0));
  EXPECT_TRUE(found.frame_from_cloud.row(2).transpose().isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_LT(AxesApart(found.frame_from_cloud.transpose(), frame), 1.0 * kDegree);
}

TEST(DominantFrame, OfATreeHasNoWalls) {
  Random random(4);
  const auto normals = BuildingNormals(&random, Eigen::Matrix3d::Identity(), 0.0, 1.0);
  EXPECT_LT(FindDominantFrame(normals).wall_share, 0.2);
}

TEST(DominantFrame, OfHardlyAnyNormalsIsTheCloudsOwn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Eigen::Vector3f> normals(50, Eigen::Vector3f(nan, nan, nan));
  normals.insert(normals.end(), 9, Eigen::Vector3f(1.0F, 1.0F, 0.0F));
  const DominantFrame found = FindDominantFrame(normals);
  EXPECT_TRUE(found.frame_from_cloud.isIdentity());
  EXPECT_EQ(found.wall_share, 0.0);
}

TEST(AlignedRotations, ContainTheTruthAmongFourOrTwentyFour) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const bool levelled : {true, false}) {
      Random random(seed);
      const auto heading = [&] {
        return Eigen::Matrix3d(
            Eigen::AngleAxisd(random.Uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ()));
      };
      const Eigen::Matrix3d source_from_world = levelled ? heading() : random.Rotation();
      const Eigen::Matrix3d target_from_world = levelled ? heading() : random.Rotation();
      const StationModel none;
      const auto of_source = BuildingNormals(&random, source_from_world, 0.02, 0.2);
      const auto of_target = BuildingNormals(&random, target_from_world, 0.02, 0.2);
      const auto rotations = AlignedRotations({none, of_source}, {none, of_target}, levelled);
      ASSERT_EQ(rotations.size(), levelled ? 4U : 24U);
      const Eigen::Matrix3d truth = target_from_world * source_from_world.transpose();
      double nearest = 10.0;
      for (const Eigen::Matrix3d& rotation : rotations) {
        EXPECT_NEAR(rotation.determinant(), 1.0, 1e-9);
        nearest = std::min(nearest, RotationAngle(rotation, truth));
      }
      EXPECT_LT(nearest, 1.5 * kDegree) << seed;
    }
  }
}

TEST(AlignedRotations, AreNoneWithoutWalls) {
  Random random(5);
  const StationModel none;
  const auto tree = BuildingNormals(&random, Eigen::Matrix3d::Identity(), 0.0, 1.0);
  const auto house = BuildingNormals(&random, Eigen::Matrix3d::Identity(), 0.02, 0.1);
  EXPECT_TRUE(AlignedRotations({none, tree}, {none, house}, true).empty());
  EXPECT_TRUE(AlignedRotations({none, house}, {none, tree}, false).empty());
}

/// `common` true correspondences to within `noise_m` among `false_ones` in a corridor's bounds.
Correspondences Corridor(std::uint64_t seed, const RigidTransform& motion, int common,
                         int false_ones, double noise_m) {
  Random random(seed);
  const auto place = [&] {
    return Eigen::Vector3d(random.Uniform(-20.0, 20.0), random.Uniform(-3.0, 3.0),
                           random.Uniform(-1.5, 1.5));
  };
  Correspondences c;
  for (int i = 0; i < common + false_ones; ++i) {
    const Eigen::Vector3d source = place();
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector3d target =
        i < common ? Eigen::Vector3d(motion * source + noise_m * noise) : place();
    const auto id = static_cast<std::uint32_t>(i);
    c.Add(source, target, id, id);
  }
  return c;
}

TEST(VoteForTranslations, FindsAMotionThatSixOfThreeThousandAskFor) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const RigidTransform truth{
        Eigen::Matrix3d(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ())),
        {7.3, -1.2, 0.1}};
    const std::vector<Eigen::Matrix3d> rotations{Eigen::Matrix3d::Identity(), truth.rotation};
    const Correspondences c = Corridor(seed, truth, 6, 3000, 0.05);
    const auto motions = VoteForTranslations(c, rotations, 0.1, 100);
    ASSERT_LE(motions.size(), 100U);
    const bool found =
        std::any_of(motions.begin(), motions.end(), [&](const RigidTransform& motion) {
          return RotationAngle(motion.rotation, truth.rotation) < 1e-9 &&
                 (motion.translation - truth.translation).norm() < 0.3;
        });
    EXPECT_TRUE(found) << seed;
  }
}

TEST(VoteForTranslations, CountsAKeyPointOnceAndPutsMostFirst) {
  const std::vector<Eigen::Matrix3d> rotations{Eigen::Matrix3d::Identity()};
  Correspondences c;
  // One key point asks twenty times for (5, 0, 0), four for (-5, 0, 0), three for (0, 5, 0).
  for (std::uint32_t i = 0; i < 20; ++i) c.Add({0.1 * i, 0, 0}, {5.0 + 0.1 * i, 0, 0}, 0, i);
  for (std::uint32_t i = 1; i <= 4; ++i) c.Add({0.0, 1.0 * i, 0}, {-5.0, 1.0 * i, 0}, i, 20 + i);
  for (std::uint32_t i = 5; i <= 7; ++i) c.Add({1.0 * i, 0, 0}, {1.0 * i, 5.0, 0}, i, 30 + i);
  const auto motions = VoteForTranslations(c, rotations, 0.1, 100);
  ASSERT_EQ(motions.size(), 2U);
  EXPECT_TRUE(motions[0].translation.isApprox(Eigen::Vector3d(-5.0, 0.0, 0.0), 1e-9));
  EXPECT_TRUE(motions[1].translation.isApprox(Eigen::Vector3d(0.0, 5.0, 0.0), 1e-9));
  EXPECT_EQ(VoteForTranslations(c, rotations, 0.1, 1).size(), 1U);
  EXPECT_TRUE(VoteForTranslations({}, rotations, 0.1, 100).empty());
  EXPECT_TRUE(VoteForTranslations(c, {}, 0.1, 100).empty());
}

}  // namespace
}  // namespace backsight
