#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/pose_files.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

/// The transform that `backsight register` printed, whatever it thinks of it.
RigidTransform PrintedTransform(const std::string& out) {
  const std::string key = "target_from_source:\n";
  const std::size_t at = out.find(key);
  if (at == std::string::npos) return {};
  std::istringstream numbers(out.substr(at + key.size()));
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 16; ++i) numbers >> matrix(i / 4, i % 4);
  return RigidTransform::FromMatrix(matrix);
}

TEST(Kitchen, RegistersFragmentsInAnyOrientation) {
  const auto data = DataFolder();
  if (!data) GTEST_SKIP() << "skipped: no data";
  const std::string kitchen = *data + "/3dmatch_kitchen";
  int successes = 0;
  const auto truth = ReadRelativeLog(kitchen + "/gt.log");
  ASSERT_EQ(truth.size(), 13U);
  for (const auto& [pair, expected] : truth) {
    const ProgramRun run =
        RunProgram(fmt::format("register '{0}/{1}.ply' '{0}/{2}.ply' --resolution-m 0.025", kitchen,
                               pair.first, pair.second));
    const RigidTransform estimate = PrintedTransform(run.out);
    const double re = RotationErrorDeg(estimate, expected);
    const double te = (estimate.translation - expected.translation).norm();
    const bool success = re <= 15.0 && te <= 0.3;
    fmt::print("3dmatch_kitchen {} - {}: RE {:.3f} deg, TE {:.2f} cm, exit code {}\n", pair.first,
               pair.second, re, 100.0 * te, run.exit_code);
    successes += success ? 1 : 0;
    EXPECT_TRUE(success || run.exit_code != 0) << "accepted, but wrong";
  }
  fmt::print("3dmatch_kitchen: {} of {} pairs\n", successes, truth.size());
  EXPECT_GE(successes, 12);
}

}  // namespace
}  // namespace backsight
