#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/e2e/program.h"

namespace backsight {
namespace {

RigidTransform ReadMatrix(std::istream& numbers) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) numbers >> matrix(i / 4, i % 4);
  return RigidTransform::FromMatrix(matrix);
}

void ExpectNear(const std::string& name, const ProgramRun& run, const std::string& truth_path,
                double max_re_deg, double max_te_m) {
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const std::string key = "target_from_source:\n";
  std::istringstream printed(run.out.substr(run.out.find(key) + key.size()));
  const RigidTransform estimate = ReadMatrix(printed);
  std::ifstream file(truth_path);
  const RigidTransform truth = ReadMatrix(file);
  const double re = RotationErrorDeg(estimate, truth);
  const double te = (estimate.translation - truth.translation).norm();
  fmt::print("{}: RE {:.3f} deg, TE {:.2f} cm\n", name, re, 100.0 * te);
  EXPECT_LE(re, max_re_deg);
  EXPECT_LE(te, max_te_m);
}

TEST(CorrespondenceFiles, SixColumnsOf3DMatch) {
  const auto data = DataFolder();
  if (!data) GTEST_SKIP() << "skipped: no data";
  const std::string folder = *data + "/corr/mac_3dmatch_pair";
  ExpectNear("3dmatch correspondences",
             RunProgram(fmt::format("register --correspondences '{}/corr_data.txt' "
                                    "--resolution-m 0.05",
                                    folder)),
             folder + "/GTmat.txt", 15.0, 0.3);
}

TEST(CorrespondenceFiles, MatchedListsOfLidar) {
  const auto data = DataFolder();
  if (!data) GTEST_SKIP() << "skipped: no data";
  for (const char* name : {"000", "010", "020"}) {
    const std::string stem = fmt::format("{}/corr/turboreg_kitti/{}", *data, name);
    ExpectNear(fmt::format("lidar correspondences {}", name),
               RunProgram(fmt::format("register --matched '{0}_fpfh_kpts_src.txt' "
                                      "'{0}_fpfh_kpts_dst.txt' --resolution-m 0.3",
                                      stem)),
               stem + "_trans.txt", 5.0, 0.6);
  }
}

}  // namespace
}  // namespace backsight
