#include "tests/campaigns/campaign_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "tests/campaigns/scene_text.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

class CampaignFolder {
 public:
  CampaignFolder(const std::string& name, std::uint64_t seed) {
    if (const char* kept = std::getenv("BACKSIGHT_CAMPAIGNS")) {
      path_ = (fs::path(kept) / fmt::format("{}-{}", name, seed)).string();
      fs::create_directories(path_);
    } else {
      scratch_ = std::make_unique<ScratchFolder>();
      path_ = *scratch_ / "campaign";
      fs::create_directories(path_);
    }
  }
  const std::string& path() const { return path_; }

 private:
  std::unique_ptr<ScratchFolder> scratch_;
  std::string path_;
};

ScanPaths ScansIn(const std::string& folder) {
  ScanPaths scans;
  for (const auto& entry : fs::directory_iterator(folder + "/scans")) {
    if (entry.path().extension() == ".ply") scans[entry.path().stem()] = entry.path();
  }
  return scans;
}

/// The project without merged clouds, which nothing here looks at, and without the gate, whose exit
/// code would hide that of a run that is not complete.
std::string WithoutOutputs(const std::string& project) {
  return project.substr(0, project.find("outputs:"));
}

void Print(const std::string& text) {
  fmt::print("{}", text);
  std::fflush(stdout);
}

}  // namespace

Judgement RunCampaign(const Scene& scene, double resolution_m) {
  const CampaignFolder folder(scene.name, scene.seed);
  const std::string scene_file = folder.path() + "/scene.yaml";
  const std::string project = folder.path() + "/" + scene.name + ".yaml";
  WriteBytes(scene_file, SceneText(scene));
  const ProgramRun simulation =
      RunProgram(fmt::format("simulate '{}' '{}'", scene_file, folder.path()));
  Judgement judgement;
  EXPECT_EQ(simulation.exit_code, 0) << simulation.err;
  if (simulation.exit_code != 0) return judgement;
  WriteBytes(project, WithoutOutputs(ReadBytes(project)) +
                          fmt::format("registration: {{resolution_m: {}}}\n", resolution_m));
  const auto start = std::chrono::steady_clock::now();
  const ProgramRun run = RunProgram(fmt::format("run '{}'", project));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.exit_code << run.out << run.err;
  judgement = Judge(folder.path(), ScansIn(folder.path()));
  judgement.name = scene.name;
  judgement.seed = scene.seed;
  judgement.exit_code = run.exit_code;
  judgement.seconds = seconds.count();
  Print(JudgementHeader() + JudgementLine(judgement));
  for (const std::string& fault : judgement.faults) Print(fmt::format("    {}\n", fault));
  return judgement;
}

void ExpectTrustworthy(const std::vector<Judgement>& judgements) {
  if (judgements.empty()) return;
  std::string table = fmt::format("\n{}", JudgementHeader());
  for (const Judgement& judgement : judgements) table += JudgementLine(judgement);
  const Judgement total = Total(judgements);
  Print(table + JudgementLine(total) + "\n");
  EXPECT_EQ(total.wrong_links, 0);
  EXPECT_EQ(total.wrong_pairs, 0);
  EXPECT_GE(total.placed, 0.98 * total.placeable);
  EXPECT_LT(Percentile(total.error_to_sigma, 0.68), 1.5);
  // The stations of one network err together: the mean of one alone scatters by some 0.2.
  EXPECT_GE(Mean(total.nees_per_dof), judgements.size() > 1 ? 0.7 : 0.5);
  EXPECT_LE(Mean(total.nees_per_dof), 1.4);
}

}  // namespace backsight
