#include "tests/support/matchers.h"

namespace backsight {

testing::AssertionResult TransformNear(const RigidTransform& actual, const RigidTransform& expected,
                                       double angle_rad, double distance_m) {
  const double angle = RotationAngle(actual.rotation, expected.rotation);
  const double distance = (actual.translation - expected.translation).norm();
  if (actual.IsValid() && angle <= angle_rad && distance <= distance_m) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure()
         << (actual.IsValid() ? "" : "not a rigid transform; ") << "rotations differ by " << angle
         << " rad (allowed " << angle_rad << "), translations by " << distance << " m (allowed "
         << distance_m << ")";
}

Vector6d RandomTwist(Random& random, double angle_rad, double distance_m) {
  Vector6d xi;
  xi << angle_rad * random.Rotation().col(0), distance_m * random.Rotation().col(0);
  return xi;
}

RigidTransform RandomTransform(Random& random, double extent_m) {
  const Eigen::Matrix3d rotation = random.Rotation();
  return {rotation, RandomPoint(random, extent_m)};
}

Eigen::Vector3d RandomPoint(Random& random, double extent_m) {
  Eigen::Vector3d point;
  for (double& x : point) x = random.Uniform(-extent_m, extent_m);
  return point;
}

Eigen::Vector3d RandomNoise(Random& random, double sigma) {
  Eigen::Vector3d noise;
  for (double& x : noise) x = sigma * random.Normal();
  return noise;
}

}  // namespace backsight
