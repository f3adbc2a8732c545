#include "stages/surface_pairs.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/neighbors.h"
#include "stages/surface_choice.h"
#include "tests/support/hall_scene.h"
#include "tests/support/instruction_sets.h"

namespace backsight {
namespace {

struct Reference {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  int matches = 0;
};

/// One voxel after the other, each searched anew.
Reference SumOneByOne(const HallStation& source, const HallStation& target,
                      const std::vector<std::uint32_t>& chosen, const RigidTransform& motion,
                      const SurfacePairRule& rule) {
  Reference sums;
  const VoxelPoints& means = target.model.leaves.means();
  const NeighborSearch search(std::vector<Eigen::Vector3d>(means.begin(), means.end()));
  const double less = rule.along_variance - rule.across_variance;
  for (const std::uint32_t i : chosen) {
    const Eigen::Vector3d moved = motion * source.model.leaves.Mean(i);
    std::size_t nearest = 0;
    double distance_m = std::numeric_limits<double>::infinity();
    for (const auto& found : search.Nearest(moved, 1)) {
      nearest = found.index;
      distance_m = found.distance_m;
    }
    if (distance_m > rule.reach_m) continue;
    const Eigen::Vector3d n = motion.rotation * source.features.normals[i].cast<double>();
    const Eigen::Vector3d m = target.features.normals[nearest].cast<double>();
    if (!(n.dot(m) >= rule.least_cosine)) continue;
    const Eigen::Matrix3d covariance = 2.0 * rule.along_variance * Eigen::Matrix3d::Identity() -
                                       less * (n * n.transpose() + m * m.transpose());
    const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(moved);
    const Eigen::Matrix<double, 6, 3> weighted = jacobian.transpose() * covariance.inverse();
    sums.matrix += weighted * jacobian;
    sums.gradient += weighted * (moved - target.model.leaves.Mean(nearest));
    ++sums.matches;
  }
  return sums;
}

Matrix6d Full(const SurfacePairSums& sums) {
  Matrix6d matrix;
  std::size_t term = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) {
      matrix(row, column) = matrix(column, row) = sums.matrix[term++];
    }
  }
  return matrix;
}

TEST(SurfacePairs, EqualsTheSumOneByOneUnderMotionsNearAndFar) {
  const HallScene scene(7, {.boxes = 8});
  const HallStation source(scene, {3.0, 2.0, 1.7}, 12);
  const HallStation target(scene, {-6.0, -3.0, 1.6}, 11);
  const RigidTransform truth = target.world_from_station.Inverse() * source.world_from_station;
  const SurfacePairRule rule{.reach_m = 0.2,
                             .least_cosine = std::sqrt(0.75),
                             .along_variance = 0.01,
                             .across_variance = 4e-6};
  std::vector<RigidTransform> motions;
  for (const double step : {0.0, 0.001, 0.02, 0.3}) {
    Vector6d xi;
    xi << 0.1 * step, -0.2 * step, 0.1 * step, step, -step, 0.5 * step;
    motions.push_back(Retract(truth, xi));
  }
  const std::size_t voxels = source.model.leaves.size();
  for (const std::size_t most : {voxels, voxels / 7}) {
    const std::vector<std::uint32_t> chosen = ChooseSurfaces(source.features.normals, most);
    std::vector<SurfacePairSums> first;  // of the first instruction set
    ForEachInstructionSet([&](const std::string& name) {
      // One after the other on the same object, so that most nearest voxels are remembered.
      SurfacePairs pairs(source.surface(), target.surface(), target.index, chosen, rule.reach_m);
      std::vector<SurfacePairSums> all;
      for (const RigidTransform& motion : motions) {
        all.push_back(pairs.Sum(motion, rule));
        const Reference expected = SumOneByOne(source, target, chosen, motion, rule);
        EXPECT_EQ(all.back().matches, expected.matches) << name;
        EXPECT_GT(expected.matches, 100);
        EXPECT_LT((Full(all.back()) - expected.matrix).norm(), 1e-11 * expected.matrix.norm());
        const Vector6d gradient(all.back().gradient.data());
        EXPECT_LT((gradient - expected.gradient).norm(), 1e-11 * expected.matrix.norm());
      }
      if (first.empty()) first = all;
      for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].matrix, first[i].matrix) << name;
        EXPECT_EQ(all[i].gradient, first[i].gradient) << name;
      }
    });
  }
}

}  // namespace
}  // namespace backsight
