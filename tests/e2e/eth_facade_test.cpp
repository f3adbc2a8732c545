#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <numeric>

#include "core/random.h"
#include "io/pose_files.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

constexpr int kStations = 7;
constexpr int kPairs = 21;

/// Results in `out`; nothing is taken from other runs.
std::string FoldersAt(const std::string& out) {
  return fmt::format("--out '{}' --work '{}-work'", out, out);
}

class EthFacade : public testing::Test {
 protected:
  void SetUp() override {
    const auto data = DataFolder();
    if (!data) GTEST_SKIP() << "skipped: no data";
    facade_ = *data + "/eth_facade";
    setenv("BACKSIGHT_DATA", data->c_str(), 1);
    truth_ = ReadPoses(facade_);
  }

  std::string facade_;
  std::map<std::string, RigidTransform> truth_;
  ScratchFolder folder_;
};

TEST_F(EthFacade, ReachesTheTruthsOwnFloor) {
  const ProgramRun run =
      RunProgram(fmt::format("run projects/eth_facade.yaml {}", FoldersAt(folder_ / "out")));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const LinkErrors links = CompareLinks(folder_ / "out/links.csv", truth_);
  const PairErrors network = CompareNetworks(ReadPoses(folder_ / "out/poses.csv"), truth_);
  PrintErrors("eth_facade coarse links", links.coarse);
  PrintErrors("eth_facade fine links", links.fine);
  PrintErrors("eth_facade network", network);
  EXPECT_EQ(links.fine.pairs, kPairs);
  EXPECT_LE(links.coarse.mean_re_deg, 0.10);
  EXPECT_LE(links.coarse.mean_te_m, 0.020);
  EXPECT_LE(links.fine.mean_re_deg, 0.035);
  EXPECT_LE(links.fine.mean_te_m, 0.0080);
  EXPECT_LE(links.fine.max_te_m, 0.020);
  EXPECT_EQ(network.pairs, kPairs);
  EXPECT_LE(network.mean_re_deg, 0.035);
  EXPECT_LE(network.mean_te_m, 0.0080);
}

TEST_F(EthFacade, GivesTheSameBytesForAnyNumberOfThreadsAndAgain) {
  const std::string files[] = {"poses.csv", "links.csv", "merged.las", "report.json"};
  std::map<std::string, std::string> first;
  for (const char* threads : {"1", "2", "4", "2"}) {
    const std::string out = folder_ / "out";
    ASSERT_EQ(RunProgram(fmt::format("run projects/eth_facade.yaml {} --threads {}", FoldersAt(out),
                                     threads))
                  .exit_code,
              0);
    for (const std::string& file : files) {
      const std::string bytes = ReadBytes(out + "/" + file);
      ASSERT_FALSE(bytes.empty()) << file;
      if (!first.contains(file)) first[file] = bytes;
      EXPECT_TRUE(bytes == first[file]) << file << " differs with " << threads << " threads";
    }
  }
}

/// Its scan of s0 looks as if its scanner had stood at the origin, which is 6.5 m away from it.
constexpr int kLooksRightSeed = 5;

/// 1 to BACKSIGHT_SEEDS, or two.
std::vector<int> TurnedSeeds() {
  const char* variable = std::getenv("BACKSIGHT_SEEDS");
  if (variable == nullptr) return {1, kLooksRightSeed};
  std::vector<int> seeds(static_cast<std::size_t>(std::max(0, std::atoi(variable))));
  std::iota(seeds.begin(), seeds.end(), 1);
  return seeds;
}

/// Every station turned at random on SO(3) and shifted by up to 50 m: its scanner is no longer at
/// its origin. BACKSIGHT_SEEDS sets how many seeds are tried.
TEST_F(EthFacade, DoesNotDependOnTheStationFrames) {
  const std::vector<int> seeds = TurnedSeeds();
  std::vector<PointChunk> scans;
  for (int s = 0; s < kStations; ++s) {
    scans.push_back(ReadAllPoints(fmt::format("{}/s{}.pcd", facade_, s)));
  }
  ASSERT_EQ(RunProgram(fmt::format("run projects/eth_facade.yaml {}", FoldersAt(folder_ / "out")))
                .exit_code,
            0);
  const double unrotated_te =
      CompareNetworks(ReadPoses(folder_ / "out/poses.csv"), truth_).mean_te_m;

  double te_sum = 0.0;
  int whole = 0;
  for (const int seed : seeds) {
    Random random(static_cast<std::uint64_t>(seed));
    std::map<std::string, RigidTransform> moved_from_station;
    std::vector<std::pair<std::string, std::string>> stations;
    for (int s = 0; s < kStations; ++s) {
      const std::string id = fmt::format("s{}", s);
      const Eigen::Vector3d direction = random.Rotation().col(0);
      const RigidTransform moved{random.Rotation(), random.Uniform(0.0, 50.0) * direction};
      moved_from_station[id] = moved;
      WriteMovedPly(scans[static_cast<std::size_t>(s)], moved, folder_ / (id + ".ply"));
      stations.emplace_back(id, id + ".ply");
    }
    WriteBytes(folder_ / "p.yaml", ProjectText(stations, "outputs: {merged: []}\n"));
    const ProgramRun run =
        RunProgram(fmt::format("run '{}' {}", folder_ / "p.yaml", FoldersAt(folder_ / "moved")));
    EXPECT_EQ(run.exit_code, 0) << "seed " << seed << "\n" << run.out << run.err;
    if (run.exit_code != 0) continue;
    const bool warned =
        ReadBytes(folder_ / "moved/report.json").find("does not seem to have stood") !=
        std::string::npos;
    EXPECT_TRUE(warned || seed != kLooksRightSeed) << "that a scanner was forgotten";
    ++whole;
    // Back to the original frames: the lever arm of the shift would multiply the truth's own
    // rotation error.
    auto poses = ReadPoses(folder_ / "moved/poses.csv");
    for (auto& [id, pose] : poses) pose = pose * moved_from_station.at(id);
    const PairErrors network = CompareNetworks(poses, truth_);
    PrintErrors(fmt::format("eth_facade moved, seed {}", seed), network);
    EXPECT_EQ(network.pairs, kPairs);
    EXPECT_LE(network.max_re_deg, 0.2) << "seed " << seed;
    EXPECT_LE(network.max_te_m, 0.05) << "seed " << seed;
    te_sum += network.mean_te_m;
  }
  ASSERT_GT(whole, 0);
  fmt::print("eth_facade moved, {} of {} seeds: mean TE {:.4f} cm, unmoved {:.4f} cm\n", whole,
             seeds.size(), 100.0 * te_sum / whole, 100.0 * unrotated_te);
  EXPECT_NEAR(te_sum / whole, unrotated_te, 0.002);
}

}  // namespace
}  // namespace backsight
