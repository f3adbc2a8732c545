#include "graph/pair_planes.h"

#include <gtest/gtest.h>

#include "tests/support/instruction_sets.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

/// A room and things in it that hold no planes, or small and tilted ones; by `noise_m` thick.
std::vector<Eigen::Vector3d> FurnishedRoom(Random& random, double noise_m) {
  std::vector<Eigen::Vector3d> points =
      RoomPoints(random, {-3.1, -2.3, -1.2}, {3.3, 2.5, 1.6}, 0.05, noise_m);
  for (int thing = 0; thing < 30; ++thing) {
    const Eigen::Vector3d place(random.Uniform(-3.0, 3.0), random.Uniform(-2.0, 2.0),
                                random.Uniform(-1.0, 1.5));
    const Eigen::Matrix3d turn = RandomTransform(random, 1.0).rotation;
    const double thin = thing % 3 == 0 ? 0.2 : 0.003;
    for (int i = 0; i < 400; ++i) {
      points.push_back(place + turn * Eigen::Vector3d(0.3 * random.Normal(), 0.3 * random.Normal(),
                                                      thin * random.Normal()));
    }
  }
  return points;
}

void ExpectSamePlanes(const std::vector<PlaneAssociation>& found,
                      const std::vector<PlaneAssociation>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].cell, expected[k].cell);
    ASSERT_EQ(found[k].observations.size(), expected[k].observations.size());
    for (std::size_t o = 0; o < found[k].observations.size(); ++o) {
      const PlaneObservation& ours = found[k].observations[o];
      const PlaneObservation& theirs = expected[k].observations[o];
      EXPECT_EQ(ours.station, theirs.station);
      EXPECT_EQ(ours.cluster.count, theirs.cluster.count);
      EXPECT_LT((ours.cluster.mean - theirs.cluster.mean).norm(), 1e-12);
      const double rounding = o == 0 ? 1e-6 : 1e-9;  // the tree keeps the first in floats
      EXPECT_LT((ours.cluster.scatter - theirs.cluster.scatter).norm(),
                rounding * theirs.cluster.scatter.norm());
    }
  }
}

TEST(PairPlaneSearch, FindsThePlanesOfTheSearchThatKnowsNothing) {
  std::size_t planes = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Random random(seed);
    const auto points = FurnishedRoom(random, seed % 2 == 0 ? 0.003 : 0.01);
    const std::vector<RigidTransform> truth{RandomTransform(random, 5.0),
                                            RandomTransform(random, 5.0)};
    const auto first = StationClusters(points, truth[0]);
    const auto second = StationClusters(points, truth[1]);
    PlaneSearchOptions options;
    options.max_depth = static_cast<int>(seed % 4);
    const PlaneTree tree(first, truth[0], options);
    PairPlaneSearch search(tree, second);
    for (const double off : {0.0, 0.05, 0.002}) {  // the second station moves
      RigidTransform pose = truth[1];
      pose.translation.x() += off;
      options.max_offset_m = std::max(0.03, off);
      const std::vector<RigidTransform> poses{truth[0], pose};
      const auto expected = FindPlanes(std::vector{&first, &second}, poses, options);
      ExpectSamePlanes(search.Find(pose, options), expected);
      planes += expected.size();
    }
  }
  EXPECT_GT(planes, 1000U);
}

TEST(PairPlaneSearch, TheSameBitsWithEveryInstructionSet) {
  Random random(7);
  const auto points = FurnishedRoom(random, 0.003);
  const RigidTransform pose = RandomTransform(random, 5.0);
  const auto clusters = StationClusters(points, pose);
  const auto find = [&] {
    const PlaneTree tree(clusters, pose, {});
    return PairPlaneSearch(tree, clusters).Find(pose, {});
  };
  const auto expected = find();
  ASSERT_GT(expected.size(), 50U);
  ForEachInstructionSet([&](const std::string& name) {
    const auto found = find();
    ASSERT_EQ(found.size(), expected.size()) << name;
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].cell, expected[k].cell);
      for (std::size_t o = 0; o < 2; ++o) {
        EXPECT_EQ(found[k].observations[o].cluster.mean, expected[k].observations[o].cluster.mean);
        EXPECT_EQ(found[k].observations[o].cluster.scatter,
                  expected[k].observations[o].cluster.scatter);
      }
    }
  });
}

TEST(PairPlaneSearch, NothingInCommonIsNoPlane) {
  const std::vector<PointCluster> none;
  Random random(8);
  const auto clusters = StationClusters(FurnishedRoom(random, 0.003), {});
  const PlaneTree nothing(none, {}, {});
  const PlaneTree tree(clusters, {}, {});
  EXPECT_TRUE(PairPlaneSearch(nothing, clusters).Find({}, {}).empty());
  EXPECT_TRUE(PairPlaneSearch(tree, none).Find({}, {}).empty());
  const RigidTransform away{Eigen::Matrix3d::Identity(), Eigen::Vector3d(100.0, 0.0, 0.0)};
  EXPECT_TRUE(PairPlaneSearch(tree, clusters).Find(away, {}).empty());
}

}  // namespace
}  // namespace backsight
