#pragma once

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/rigid_transform.h"

namespace backsight {

/// Success if both rotations agree within `angle_rad` and both translations within `distance_m`;
/// otherwise says by how much they differ.
testing::AssertionResult TransformNear(const RigidTransform& actual, const RigidTransform& expected,
                                       double angle_rad, double distance_m);

/// A twist with its rotation part of length `angle_rad` and its translation part of length
/// `distance_m`, both in random directions.
Vector6d RandomTwist(Random& random, double angle_rad, double distance_m);

/// Any rotation; each translation coordinate uniform within `extent_m` of 0.
RigidTransform RandomTransform(Random& random, double extent_m);

/// Uniform in the cube of half edge `extent_m` about the origin.
Eigen::Vector3d RandomPoint(Random& random, double extent_m);

/// Three independent normal numbers with standard deviation `sigma`.
Eigen::Vector3d RandomNoise(Random& random, double sigma);

}  // namespace backsight

#define EXPECT_TRANSFORM_NEAR(actual, expected, angle_rad, distance_m) \
  EXPECT_TRUE(::backsight::TransformNear((actual), (expected), (angle_rad), (distance_m)))
