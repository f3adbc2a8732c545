#include "core/voxel_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/archive.h"
#include "core/random.h"

namespace backsight {
namespace {

Eigen::Vector3d Anywhere(Random& random, double reach) {
  return {random.Uniform(-reach, reach), random.Uniform(-reach, reach),
          random.Uniform(-reach, reach)};
}

TEST(VoxelPoints, MoveByLessThanAPlaceAndStayInTheirVoxels) {
  Random random(1);
  for (const double edge_m : {0.01, 0.1, 1.0}) {
    const VoxelLattice lattice{edge_m, Anywhere(random, 1e6)};
    VoxelPoints points(lattice);
    std::vector<Eigen::Vector3d> added;
    for (int i = 0; i < 5000; ++i) {
      added.emplace_back(lattice.origin + Anywhere(random, 5000.0 * edge_m));
      points.Add(lattice.Key(added.back()), added.back());
    }
    ASSERT_EQ(points.size(), added.size());
    std::size_t i = 0;
    for (const Eigen::Vector3d& point : points) {
      EXPECT_EQ(point, points[i]);
      EXPECT_EQ(lattice.Key(point), points.Key(i));
      EXPECT_LT((point - added[i]).lpNorm<Eigen::Infinity>(), 0x1p-17 * edge_m + 1e-9);
      ++i;
    }
    EXPECT_EQ(i, added.size());
  }
}

TEST(VoxelPoints, AreNoFartherOnOneSideThanOnTheOther) {
  Random random(2);
  const VoxelLattice lattice{.edge_m = 0.1};
  VoxelPoints points(lattice);
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  constexpr int kPoints = 20000;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d point = Anywhere(random, 30.0);
    points.Add(lattice.Key(point), point);
    shift += (points[points.size() - 1] - point) / kPoints;
  }
  // A place is 1.5 um wide; its errors' standard deviation is 0.44 um.
  EXPECT_LT(shift.lpNorm<Eigen::Infinity>(), 5.0 * 0.44e-6 / std::sqrt(kPoints));
}

TEST(VoxelPoints, BesideTheirVoxelArePutToItsFace) {
  const VoxelLattice lattice{.edge_m = 1.0};
  VoxelPoints points(lattice);
  const std::uint64_t key = VoxelLattice::Pack({4, -2, 0});
  points.Add(key, {5.0, -2.0 - 1e-12, 0.5});
  EXPECT_EQ(lattice.Key(points[0]), key);
  EXPECT_LT((points[0] - Eigen::Vector3d(5.0, -2.0, 0.5)).lpNorm<Eigen::Infinity>(), 0x1.01p-17);
}

TEST(VoxelPoints, AreTranslatedWithoutRounding) {
  Random random(3);
  VoxelPoints points({.edge_m = 0.1, .origin = {5e5, 6e6, 80.0}});
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point = points.lattice().origin + Anywhere(random, 9.0);
    points.Add(points.lattice().Key(point), point);
  }
  VoxelPoints moved = points;
  moved.Translate(-points.lattice().origin);
  EXPECT_EQ(moved.lattice().origin, Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(moved.Key(i), points.Key(i));
    EXPECT_LT((moved[i] + points.lattice().origin - points[i]).norm(), 2e-9);
  }
}

TEST(VoxelPoints, OfDamagedArchivesAreRefused) {
  VoxelPoints points({.edge_m = 0.1});
  for (int i = 0; i < 9; ++i) points.Add(VoxelLattice::Pack({i, i, i}), Eigen::Vector3d::Zero());
  const std::string bytes = ToBytes(points);
  const auto back = FromBytes<VoxelPoints>(bytes);
  ASSERT_EQ(back.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(back[i], points[i]);
  std::string fewer_places = bytes;
  const std::size_t at = bytes.size() - 9 * 3 * sizeof(std::uint16_t) - sizeof(std::uint64_t);
  fewer_places[at] = 8;
  fewer_places.resize(bytes.size() - 3 * sizeof(std::uint16_t));
  EXPECT_THROW(FromBytes<VoxelPoints>(fewer_places), DamagedArchive);
  EXPECT_THROW(FromBytes<VoxelPoints>(bytes.substr(0, bytes.size() - 1)), DamagedArchive);
}

}  // namespace
}  // namespace backsight
