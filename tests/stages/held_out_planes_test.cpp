#include "stages/held_out_planes.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace backsight {
namespace {

/// A horizontal patch of one square metre.
PlaneObservation Patch(int station, const Eigen::Vector3d& mean) {
  const Eigen::Vector3d variances(1.0 / 12.0, 1.0 / 12.0, 1e-6);
  return {station, {100.0, mean, 100.0 * Eigen::Matrix3d(variances.asDiagonal())}};
}

/// `count` patches that stations 0 and `other` see, with 1 mm noise and b's higher by `offset_m`.
void AddPlanes(int other, int count, double offset_m, Random& random,
               std::vector<PlaneAssociation>* planes) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d at(random.Uniform(-9.0, 9.0), random.Uniform(-9.0, 9.0), -2.0);
    const double height = offset_m + 0.001 * random.Normal();
    PlaneAssociation plane;
    plane.observations = {Patch(0, at), Patch(other, at + height * Eigen::Vector3d::UnitZ())};
    planes->push_back(plane);
  }
}

TEST(HeldOutPlanes, APairThatLosesIsToldFromTheMean) {
  Random random(1);
  std::vector<PlaneAssociation> planes;
  AddPlanes(1, 30, 0.0, random, &planes);
  AddPlanes(2, 100, 0.010, random, &planes);
  const std::vector<RigidTransform> before(3);
  std::vector<RigidTransform> after = before;
  after[1].translation.z() = 0.002;   // away from station 0
  after[2].translation.z() = -0.010;  // onto it
  const HeldOutComparison comparison = CompareHeldOut(planes, before, after);
  EXPECT_FALSE(comparison.change.IsWorse(2.0)) << "all pairs together gained";
  EXPECT_LT(comparison.change.mean_change_m2, 0.0);
  ASSERT_EQ(comparison.pairs.size(), 2U);
  EXPECT_TRUE(comparison.pairs[0].change.IsWorse(3.0));
  EXPECT_NEAR(comparison.pairs[0].change.mean_change_m2, 0.002 * 0.002, 1.5e-6);
  EXPECT_FALSE(comparison.pairs[1].change.IsWorse(3.0));
}

TEST(HeldOutPlanes, ChangesThatAreSmallOrUncertainAreNone) {
  EXPECT_TRUE((SquaredChange{1e-6, 2e-8, 5e-9}.IsWorse(3.0)));
  EXPECT_FALSE((SquaredChange{1e-6, 2e-8, 9e-9}.IsWorse(3.0))) << "2.2 standard errors";
  EXPECT_FALSE((SquaredChange{1e-6, 9e-9, 1e-10}.IsWorse(3.0))) << "less than a hundredth";
  EXPECT_FALSE((SquaredChange{0.0, 9e-11, 1e-12}.IsWorse(3.0))) << "rounding";
  EXPECT_FALSE(SquaredChange{}.IsWorse(3.0));
  EXPECT_FALSE(CompareHeldOut({}, {}, {}).change.IsWorse(2.0));
}

}  // namespace
}  // namespace backsight
