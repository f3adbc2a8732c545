#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "stages/features.h"
#include "stages/fpfh.h"
#include "stages/ingest.h"
#include "stages/leaf_grid.h"
#include "stages/normals.h"
#include "tests/support/feature_scene.h"
#include "tests/support/pcl_features.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.1;

std::string ScanPath(const std::string& name) {
  const char* root = std::getenv("BACKSIGHT_DATA");
  return std::string(root != nullptr ? root : "../shared/data") + "/eth_facade/" + name;
}

class FeaturesData : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string path = ScanPath(GetParam());
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "skipped: no data";
    const auto reader = OpenScan(path);
    model_ = IngestScan(GetParam(), *reader, {}, {.resolution_m = kResolution}, context_).model;
    points_ = LeafPositions(model_);
  }

  StationModel model_;
  std::vector<Eigen::Vector3f> points_;
  ExecutionContext context_{2};
};

TEST_P(FeaturesData, KeypointsEqualPcl) {
  const LeafGrid grid(points_, 3.0 * kResolution);
  for (const double radius : {4.0, 2.0}) {
    const IssParameters parameters{.salient_radius_m = 6.0 * kResolution,
                                   .non_max_radius_m = radius * kResolution};
    EXPECT_EQ(FindIssKeypoints(grid, parameters, context_), PclIssKeypoints(points_, parameters));
  }
}

TEST_P(FeaturesData, NormalsAndDescriptorsEqualPcl) {
  const LeafGrid grid(points_, 3.0 * kResolution);
  const auto normals = EstimateNormals(grid, 3.0 * kResolution, context_);
  const auto expected_normals = PclNormals(points_, 3.0 * kResolution);
  std::size_t defined = 0;
  std::size_t alike = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    ASSERT_EQ(normals[i].allFinite(), expected_normals[i].allFinite());
    if (!normals[i].allFinite()) continue;
    ++defined;
    if (normals[i].cross(expected_normals[i]).norm() < 1e-3F) ++alike;
  }
  EXPECT_GT(alike, defined * 995 / 1000);  // the rest have no clear plane
  const IssParameters parameters{.salient_radius_m = 6.0 * kResolution,
                                 .non_max_radius_m = 4.0 * kResolution};
  const auto keypoints = FindIssKeypoints(grid, parameters, context_);
  const double difference =
      MedianRelativeDifference(ComputeFpfh(grid, normals, keypoints, 8.0 * kResolution, context_),
                               PclFpfh(points_, normals, keypoints, 8.0 * kResolution));
  EXPECT_LT(difference, 1e-3);
}

TEST_P(FeaturesData, ReachTheWantedNumberOfKeypoints) {
  const StationFeatures features = ComputeFeatures(model_, {}, context_);
  EXPECT_GE(features.keypoints.size(), 1500U);
  EXPECT_TRUE(features.scanner_credible);
}

INSTANTIATE_TEST_SUITE_P(EthFacade, FeaturesData, ::testing::Values("s0.pcd", "s3.pcd"),
                         [](const auto& test) { return test.param.substr(0, 2); });

}  // namespace
}  // namespace backsight
