#include "tests/support/synthetic_correspondences.h"

#include "core/random.h"
#include "tests/support/matchers.h"

namespace backsight {

SyntheticMatches MakeMatches(std::uint64_t seed, const SyntheticMatchOptions& options) {
  Random random(seed);
  SyntheticMatches matches;
  matches.target_from_source = RandomTransform(random, 50.0);
  const int rows = options.inliers + options.outliers;
  int inliers_left = options.inliers;
  for (int row = 0; row < rows; ++row) {
    const auto id = static_cast<std::uint32_t>(row);
    const Eigen::Vector3d q = RandomPoint(random, options.extent_m);
    const auto left = static_cast<std::uint64_t>(rows - row);
    if (random.Index(left) < static_cast<std::uint64_t>(inliers_left)) {
      --inliers_left;
      matches.inlier_rows.push_back(id);
      const Eigen::Vector3d noise = RandomNoise(random, options.noise_m);
      matches.c.Add(q, matches.target_from_source * q + noise, id, id);
    } else {
      const Eigen::Vector3d other = RandomPoint(random, options.extent_m);
      matches.c.Add(q, matches.target_from_source * other, id, id);
    }
  }
  return matches;
}

Correspondences Moved(const Correspondences& c, const RigidTransform& new_from_source,
                      const RigidTransform& new_from_target) {
  Correspondences moved = c;
  for (auto& q : moved.source) q = new_from_source * q;
  for (auto& p : moved.target) p = new_from_target * p;
  return moved;
}

}  // namespace backsight
