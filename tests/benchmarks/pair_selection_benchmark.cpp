#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/error.h"
#include "io/pose_files.h"
#include "io/survey_project.h"
#include "pipeline/pair_discovery.h"
#include "stages/overlap_prediction.h"
#include "stages/pair_prematch.h"
#include "stages/station_signature.h"
#include "tests/support/town_scene.h"

// How well the cheap rankings of stages/pair_ranking.h find the pairs that truly overlap.
//   pair_selection_benchmark scene COLUMNS ROWS SEED STEP_DEG > town.yaml
//       a town for `backsight simulate`
//   pair_selection_benchmark rank PROJECT.yaml TRUTH.csv
//       for each ranking: of the pairs among the k best of either station, how many overlap
//       (precision); how many of all that overlap are among them (recall); the share of stations
//       with at least one such pair

namespace backsight {
namespace {

constexpr double kOverlaps = 0.3;

class Clock {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct RatedPair {
  std::size_t source = 0;
  std::size_t target = 0;
  bool overlaps = false;
};

double Ratio(std::size_t a, std::size_t b) {
  return b > 0 ? static_cast<double>(a) / static_cast<double>(b) : 0.0;
}

void PrintRow(const std::string& name, const std::vector<RatedPair>& pairs,
              const std::vector<double>& scores, std::size_t stations, double seconds) {
  fmt::print("| {} | {:.3f} |", name, 1000.0 * seconds / static_cast<double>(pairs.size()));
  const auto all = static_cast<std::size_t>(std::count_if(
      pairs.begin(), pairs.end(), [](const RatedPair& pair) { return pair.overlaps; }));
  for (const std::size_t k : {1, 3, 5, 10}) {
    std::vector<char> chosen(pairs.size(), 0);
    std::size_t helped = 0;
    for (std::size_t s = 0; s < stations; ++s) {
      std::vector<std::size_t> own;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].source == s || pairs[i].target == s) own.push_back(i);
      }
      std::stable_sort(own.begin(), own.end(),
                       [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
      own.resize(std::min(own.size(), k));
      bool hit = false;
      for (const std::size_t i : own) chosen[i] = 1, hit = hit || pairs[i].overlaps;
      helped += hit ? 1 : 0;
    }
    std::size_t found = 0;
    std::size_t taken = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      taken += chosen[i] != 0 ? 1 : 0;
      found += chosen[i] != 0 && pairs[i].overlaps ? 1 : 0;
    }
    fmt::print(" {:.2f} / {:.2f} / {:.2f} |", Ratio(found, taken), Ratio(found, all),
               Ratio(helped, stations));
  }
  fmt::print("\n");
  std::fflush(stdout);
}

std::vector<RatedPair> RatePairs(const std::vector<Station>& stations,
                                 const std::string& truth_path) {
  const auto truth = ReadPoses(truth_path);
  std::vector<RatedPair> pairs;
  std::vector<CoarseOccupancy> occupancy;
  for (const Station& station : stations) occupancy.emplace_back(station.model);
  const Clock clock;
  std::size_t overlapping = 0;
  for (std::size_t t = 0; t < stations.size(); ++t) {
    for (std::size_t s = t + 1; s < stations.size(); ++s) {
      const RigidTransform motion =
          truth.at(stations[t].spec.id).Inverse() * truth.at(stations[s].spec.id);
      const bool overlaps = PredictOverlap(occupancy[s], occupancy[t], motion) >= kOverlaps;
      pairs.push_back({s, t, overlaps});
      overlapping += overlaps ? 1 : 0;
    }
  }
  fmt::print("{} pairs, {} with an overlap of {} ({:.0f} us to predict one)\n", pairs.size(),
             overlapping, kOverlaps, 1e6 * clock.Seconds() / static_cast<double>(pairs.size()));
  return pairs;
}

std::vector<double> Standardised(std::vector<double> values) {
  double mean = 0.0;
  double squares = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values) squares += std::pow(value - mean, 2);
  const double deviation = std::sqrt(squares / static_cast<double>(values.size()));
  for (double& value : values) value = (value - mean) / deviation;
  return values;
}

int Rank(const std::string& project_path, const std::string& truth_path) {
  SurveyOptions options;
  const SurveyProject project = ReadSurveyProject(project_path, OptionSections(options));
  const ExecutionContext context(1);
  const std::vector<Station> stations = LoadStations(project.stations, options, context);
  const std::vector<RatedPair> pairs = RatePairs(stations, truth_path);
  fmt::print(
      "| ranking | ms a pair | k = 1: precision / recall / stations | k = 3 | k = 5 | k = 10 |\n"
      "|---|---|---|---|---|---|\n");
  std::vector<const StationFeatures*> features;
  for (const Station& station : stations) features.push_back(&station.features);
  std::vector<double> signature;
  for (const int words : {16, 64, 128}) {
    const Clock clock;
    const auto signatures = ComputeSignatures(features, {.words = words}, context);
    std::vector<double> scores;
    for (const RatedPair& pair : pairs) {
      scores.push_back(static_cast<double>(signatures[pair.source].dot(signatures[pair.target])));
    }
    PrintRow(fmt::format("signature, {} words", words), pairs, scores, stations.size(),
             clock.Seconds());
    if (words == 64) signature = Standardised(scores);
  }
  std::vector<double> cells_m;
  for (const Station& station : stations) {
    cells_m.push_back(station.spec.levelled ? PlanCellFor(station.model, station.features) : 0.0);
  }
  for (const auto& [keypoints, neighbors, nodes] :
       {std::array{400, 2, 100}, std::array{600, 2, 150}, std::array{600, 3, 300},
        std::array{1000, 2, 300}}) {
    PrematchOptions prematch;
    prematch.keypoints = keypoints;
    prematch.neighbors = neighbors;
    prematch.nodes = nodes;
    const Clock clock;
    std::vector<StationSketch> sketches;
    const double largest_m = *std::max_element(cells_m.begin(), cells_m.end());
    for (std::size_t s = 0; s < stations.size(); ++s) {
      sketches.push_back(SketchStation(stations[s].model, stations[s].features,
                                       {cells_m[s], largest_m}, prematch));
    }
    std::vector<double> scores;
    for (const RatedPair& pair : pairs) {
      scores.push_back(
          PrematchPair(sketches[pair.source], sketches[pair.target], prematch, context));
    }
    const std::string name =
        fmt::format("prematch, {} key points, k {}, {} nodes", keypoints, neighbors, nodes);
    PrintRow(name, pairs, scores, stations.size(), clock.Seconds());
    std::vector<double> both = Standardised(scores);
    for (std::size_t i = 0; i < both.size(); ++i) both[i] += signature[i];
    PrintRow("with signature", pairs, both, stations.size(), clock.Seconds());
  }
  return 0;
}

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() == 5 && arguments[0] == "scene") {
    TownScene town;
    town.columns = std::stoi(arguments[1]);
    town.rows = std::stoi(arguments[2]);
    town.seed = std::stoull(arguments[3]);
    town.step_deg = std::stod(arguments[4]);
    fmt::print("{}", SceneYaml(town));
    return 0;
  }
  if (arguments.size() == 3 && arguments[0] == "rank") return Rank(arguments[1], arguments[2]);
  fmt::print(stderr, "scene COLUMNS ROWS SEED STEP_DEG | rank PROJECT.yaml TRUTH.csv\n");
  return 2;
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  try {
    return backsight::Run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
