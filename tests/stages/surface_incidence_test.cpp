#include "stages/surface_incidence.h"

#include <gmock/gmock.h>

#include <cmath>

#include "core/random.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

using ::testing::Eq;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kEdge = 0.1;
const Eigen::Vector3d kScanner(1000.0, 2000.0, 30.0);

/// A floor at z = -2 under the scanner, of 3 mm noise, a wall at x = 5 that meets it, and a bush.
class SurfaceIncidenceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    model_.scanner_origin = kScanner;
    Random random(1);
    VoxelClusterer clusterer({.edge_m = kEdge});
    for (int i = 0; i < 60000; ++i) {
      clusterer.Add(
          {random.Uniform(3.0, 4.98), random.Uniform(-1, 1), -1.98 + 0.003 * random.Normal()});
      clusterer.Add(
          {4.98 + 0.003 * random.Normal(), random.Uniform(-1, 1), random.Uniform(-1.98, -1.0)});
      clusterer.Add({random.Uniform(3.0, 3.5), random.Uniform(0, 0.5), random.Uniform(0, 0.5)});
    }
    model_.leaves = clusterer.Finish();
    for (const Eigen::Vector3d& mean : model_.leaves.means()) normals_.push_back(NormalAt(mean));
  }

  static Eigen::Vector3f NormalAt(const Eigen::Vector3d& p) {
    const bool floor = p.z() < -1.9;
    const bool wall = p.x() > 4.9;
    if (floor && wall) return Eigen::Vector3f(-1.0F, 0.0F, 1.0F).normalized();
    if (floor) return Eigen::Vector3f::UnitZ();
    if (wall) return -Eigen::Vector3f::UnitX();
    return Eigen::Vector3f(-1.0F, 0.0F, 0.0F);  // the bush
  }

  SurfaceIncidence Incidence(bool scanner_credible = true) const {
    return SurfaceIncidence({model_, normals_, scanner_credible});
  }

  StationModel model_;
  std::vector<Eigen::Vector3f> normals_;
};

TEST_F(SurfaceIncidenceTest, IsTheAngleBetweenBeamAndNormal) {
  SurfaceIncidence incidence = Incidence();
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d floor(random.Uniform(3.0, 4.85), random.Uniform(-1, 1), -1.98);
    const Eigen::Vector3d wall(4.98, random.Uniform(-1, 1), random.Uniform(-1.85, -1.0));
    for (const Eigen::Vector3d& p : {floor, wall}) {
      const Eigen::Vector3d normal = NormalAt(p).cast<double>();
      const double cos = std::abs(p.dot(normal)) / p.norm();
      const std::optional<double> found = incidence.CosAt(kScanner + p);
      ASSERT_TRUE(found) << p.transpose();
      EXPECT_NEAR(*found, cos, 1e-6);  // normals are float
    }
  }
}

TEST_F(SurfaceIncidenceTest, IsUnknownWhereTheNormalIsNotCredible) {
  SurfaceIncidence incidence = Incidence();
  EXPECT_THAT(incidence.CosAt(kScanner + Eigen::Vector3d(4.98, 0.05, -1.98)), Eq(std::nullopt));
  EXPECT_THAT(incidence.CosAt(kScanner + Eigen::Vector3d(3.25, 0.25, 0.25)), Eq(std::nullopt));
  EXPECT_THAT(incidence.CosAt(kScanner + Eigen::Vector3d(8.0, 0.0, 0.0)), Eq(std::nullopt));
  EXPECT_THAT(incidence.CosAt(kScanner), Eq(std::nullopt));
  EXPECT_THAT(Incidence(false).CosAt(kScanner + Eigen::Vector3d(4.0, 0.0, -1.98)),
              Eq(std::nullopt));
  for (Eigen::Vector3f& normal : normals_) normal.setConstant(kNan);
  EXPECT_THAT(Incidence().CosAt(kScanner + Eigen::Vector3d(4.0, 0.0, -1.98)), Eq(std::nullopt));
}

TEST_F(SurfaceIncidenceTest, DoesNotDependOnThePointsBefore) {
  SurfaceIncidence incidence = Incidence();
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d p =
        kScanner + Eigen::Vector3d(random.Uniform(2.8, 5.2), random.Uniform(-1.2, 1.2),
                                   random.Uniform(-2.2, 0.6));
    EXPECT_EQ(incidence.CosAt(p), Incidence().CosAt(p));
  }
}

}  // namespace
}  // namespace backsight
