#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/pose_files.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

struct SimulatedCase {
  std::string scene;
  std::string name;
  double max_te_m = 0.0;
  double max_re_deg = 0.0;
};

void PrintTo(const SimulatedCase& c, std::ostream* out) { *out << c.scene; }

class SimulatedCampaign : public testing::TestWithParam<SimulatedCase> {};

TEST_P(SimulatedCampaign, ComesOutAtItsTruth) {
  const SimulatedCase& c = GetParam();
  const ScratchFolder folder;
  ASSERT_EQ(RunProgram(fmt::format("simulate '{}' '{}'", c.scene, folder / "")).exit_code, 0);
  const ProgramRun run = RunProgram(fmt::format("run '{}'", folder / (c.name + ".yaml")));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const auto truth = ReadPoses(folder / "truth.csv");
  const PairErrors errors = CompareNetworks(ReadPoses(folder / "out/poses.csv"), truth);
  PrintErrors("simulated " + c.name, errors);
  EXPECT_EQ(errors.pairs, static_cast<int>(truth.size() * (truth.size() - 1) / 2));
  EXPECT_LE(errors.max_te_m, c.max_te_m);
  EXPECT_LE(errors.max_re_deg, c.max_re_deg);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SimulatedCampaign,
    testing::Values(SimulatedCase{"tests/e2e/scenes/courtyard.yaml", "courtyard", 0.005, 0.01},
                    SimulatedCase{"tests/e2e/scenes/yard.yaml", "yard", 0.005, 0.01}),
    [](const auto& test) { return test.param.name; });

TEST(Demo, PlacesEveryStationWithinTwoMillimetres) {
  const ScratchFolder folder;
  const ProgramRun run = RunProgram(fmt::format("demo '{}'", folder / "demo"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const PairErrors errors = CompareNetworks(ReadPoses(folder / "demo/out/poses.csv"),
                                            ReadPoses(folder / "demo/truth.csv"));
  PrintErrors("demo", errors);
  EXPECT_EQ(errors.pairs, 10);
  EXPECT_LE(errors.max_te_m, 0.002);
  EXPECT_LE(errors.max_re_deg, 0.005);
  EXPECT_NE(run.out.find("report.html"), std::string::npos);
  EXPECT_NE(ReadBytes(folder / "demo/out/report.html").find("data:image/png"), std::string::npos);
}

}  // namespace
}  // namespace backsight
