#pragma once

#include <vector>

#include "core/rigid_transform.h"
#include "graph/correspondences.h"

namespace backsight {

struct SyntheticMatchOptions {
  int inliers = 60;
  int outliers = 0;        ///< target points drawn independently of their source points
  double noise_m = 0.0;    ///< per axis, on the inliers' target points
  double extent_m = 20.0;  ///< half edge of the cube of source points
};

/// Correspondences under a known motion, inliers and outliers shuffled, each row with key points of
/// its own.
struct SyntheticMatches {
  Correspondences c;
  RigidTransform target_from_source;
  std::vector<std::uint32_t> inlier_rows;
};

SyntheticMatches MakeMatches(std::uint64_t seed, const SyntheticMatchOptions& options);

/// The same correspondences with source and target points moved to other frames.
Correspondences Moved(const Correspondences& c, const RigidTransform& new_from_source,
                      const RigidTransform& new_from_target);

}  // namespace backsight
