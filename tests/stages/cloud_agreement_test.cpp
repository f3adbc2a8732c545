#include "stages/cloud_agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/random.h"
#include "tests/support/hall_scene.h"

namespace backsight {
namespace {

struct Counts {
  double score = 0.0;
  int met = 0, agrees = 0, through = 0;
};

/// One leaf after the other, all leaves of the reference searched by key, every sight taken.
Counts CountBlock(const Surface& moved, const CloudSample& sample, std::size_t block,
                  const Surface& reference, const std::map<std::uint64_t, std::size_t>& leaf_of,
                  const RigidTransform& motion, double tolerance_m) {
  Counts counts;
  const Eigen::Matrix3f rotation = motion.rotation.cast<float>();
  for (std::uint32_t k = sample.begins[block]; k < sample.begins[block + 1]; ++k) {
    const std::uint32_t leaf = sample.leaves[k];
    const Eigen::Vector3d point = motion * moved.model.leaves.Mean(leaf);
    const Eigen::Vector3f normal = rotation * moved.normals[leaf];
    bool met = false;
    double score = 0.0;
    const Eigen::Vector3i cell = reference.model.lattice().Cell(point);
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i step(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      if (step.cwiseAbs().sum() > 1) continue;
      const auto place = leaf_of.find(VoxelLattice::Pack(cell + step));
      if (place == leaf_of.end()) continue;
      const Eigen::Vector3f& n = reference.normals[place->second];
      if (n.dot(normal) < 0.0F) continue;
      met = true;
      if (!(n.dot(normal) > 0.8F)) continue;
      const Eigen::Vector3d& mean = reference.model.leaves.Mean(place->second);
      const double distance = n.cast<double>().dot(point - mean) / tolerance_m;
      score = std::max(score, 1.0 - distance * distance);
    }
    counts.met += met ? 1 : 0;
    counts.score += score;
    const Sight sight = met ? Sight::kAgrees : LookAt(reference.model, point, normal);
    counts.agrees += sight == Sight::kAgrees ? 1 : 0;
    counts.through += sight == Sight::kSeenThrough ? 1 : 0;
  }
  return counts;
}

class CloudAgreementTest : public testing::Test {
 protected:
  HallScene scene_{7, {.boxes = 8}};
  HallStation first_{scene_, {-6.0, -3.0, 1.6}, 11};
  HallStation second_{scene_, {3.0, 2.0, 1.7}, 12};
};

TEST_F(CloudAgreementTest, EqualsTheComparisonOfEveryLeaf) {
  const RigidTransform truth = first_.world_from_station.Inverse() * second_.world_from_station;
  const Surface moved = second_.surface();
  const Surface reference = first_.surface();
  std::map<std::uint64_t, std::size_t> leaf_of;
  for (std::size_t i = 0; i < reference.model.leaves.size(); ++i) {
    leaf_of[reference.model.leaves.Key(i)] = i;
  }
  const CloudSample sample = SampleCloud(moved.model, 6000);
  constexpr double kTolerance = 0.2;
  Random random(3);
  int seen_through = 0;
  for (int trial = 0; trial < 12; ++trial) {
    RigidTransform motion = truth;
    if (trial > 0) {
      motion.rotation = ExpSo3({0.0, 0.0, 0.05 * trial * random.Normal()}) * motion.rotation;
      motion.translation +=
          0.2 * trial * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    }
    double score = 0.0, part = 0.0, whole = 0.0;
    int met = 0, through = 0, in_view = 0;
    for (std::size_t b = 0; b < sample.blocks(); ++b) {
      const Counts c = CountBlock(moved, sample, b, reference, leaf_of, motion, kTolerance);
      const bool is_through = c.through >= 4 && c.through > c.agrees;
      through += is_through ? 1 : 0;
      in_view += is_through || c.agrees >= 4 ? 1 : 0;
      part += c.score - (is_through ? c.through : 0);
      whole += c.met + (is_through ? c.through : 0);
      score += c.score;
      met += c.met;
    }
    const CloudAgreement agreement =
        CompareClouds(moved, sample, reference, first_.index, motion, kTolerance);
    const auto leaves = static_cast<double>(sample.leaves.size());
    EXPECT_EQ(agreement.overlap, met / leaves);
    EXPECT_DOUBLE_EQ(agreement.score, score / leaves);
    EXPECT_EQ(agreement.blocks_in_view, in_view);
    EXPECT_DOUBLE_EQ(agreement.conflict.value, in_view > 0 ? through / (1.0 * in_view) : 0.0);
    EXPECT_NEAR(agreement.quality.value, part / whole, 1e-12);
    EXPECT_EQ(ScoreClouds(moved, sample, reference, first_.index, motion, kTolerance),
              agreement.score);
    seen_through += through;
  }
  EXPECT_GT(seen_through, 20) << "some motions must contradict";
}

}  // namespace
}  // namespace backsight
