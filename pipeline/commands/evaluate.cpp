#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <set>

#include "core/error.h"
#include "io/pose_files.h"
#include "pipeline/commands/commands.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

using RelativePoses = std::map<std::pair<std::string, std::string>, RigidTransform>;

struct PairError {
  std::string source, target;
  double re_deg = 0.0;
  double te_m = 0.0;
};

/// True target_from_source of every pair the truth speaks of, the earlier name as source. The
/// direction matters: a rotation error moves the translation by its lever arm.
RelativePoses ReadTruth(const std::string& path) {
  RelativePoses relative;
  const auto add = [&](const std::string& source, const std::string& target,
                       const RigidTransform& target_from_source) {
    if (source < target) {
      relative[{source, target}] = target_from_source;
    } else {
      relative[{target, source}] = target_from_source.Inverse();
    }
  };
  if (path.ends_with(".log")) {
    for (const auto& [pair, motion] : ReadRelativeLog(path)) add(pair.first, pair.second, motion);
    return relative;
  }
  const auto poses = ReadPoses(path);
  for (auto source = poses.begin(); source != poses.end(); ++source) {
    for (auto target = std::next(source); target != poses.end(); ++target) {
      add(source->first, target->first, target->second.Inverse() * source->second);
    }
  }
  return relative;
}

/// The poses.csv itself, or that of a run's output folder.
std::string PosesFile(const std::string& given) {
  std::error_code none;
  if (!std::filesystem::is_directory(given, none)) return given;
  return (std::filesystem::path(given) / "poses.csv").string();
}

std::vector<PairError> CompareWithTruth(const std::vector<PoseRecord>& poses,
                                        const RelativePoses& truth) {
  std::map<std::string, const PoseRecord*> placed;
  for (const PoseRecord& pose : poses) {
    if (pose.status == StationStatus::kRegistered) placed[pose.station] = &pose;
  }
  std::vector<PairError> errors;
  for (const auto& [pair, true_transform] : truth) {
    const auto source = placed.find(pair.first);
    const auto target = placed.find(pair.second);
    if (source == placed.end() || target == placed.end()) continue;
    if (source->second->component != target->second->component) continue;
    const RigidTransform estimate =
        target->second->survey_from_station.Inverse() * source->second->survey_from_station;
    errors.push_back(
        {pair.first, pair.second,
         RotationAngle(estimate.rotation, true_transform.rotation) * 180.0 / std::numbers::pi,
         (estimate.translation - true_transform.translation).norm()});
  }
  return errors;
}

void RequireCommonStation(const EvaluateArguments& arguments, const std::vector<PoseRecord>& poses,
                          const RelativePoses& truth) {
  std::set<std::string> known;
  for (const auto& [pair, motion] : truth) {
    known.insert(pair.first);
    known.insert(pair.second);
  }
  if (std::any_of(poses.begin(), poses.end(),
                  [&](const PoseRecord& pose) { return known.contains(pose.station); })) {
    return;
  }
  throw InputError(
      {arguments.poses,
       poses.empty()
           ? "no station"
           : fmt::format("no station of the truth, but {} and so on", poses.front().station),
       fmt::format("stations called as in {}: {} and so on", arguments.truth, *known.begin()),
       "compare a run with the truth of its own campaign"});
}

}  // namespace

int EvaluateCommand(EvaluateArguments arguments) {
  arguments.poses = PosesFile(arguments.poses);
  const RelativePoses truth = ReadTruth(arguments.truth);
  if (truth.empty()) {
    throw InputError(
        {arguments.truth, "no pair of poses", "the truth of at least two stations", ""});
  }
  const std::vector<PoseRecord> poses = ReadPoseRecords(arguments.poses);
  RequireCommonStation(arguments, poses, truth);
  const std::vector<PairError> errors = CompareWithTruth(poses, truth);
  std::size_t successes = 0;
  double re_sum = 0.0, te_sum = 0.0, te_max = 0.0;
  fmt::print("{:<24} {:>10} {:>10}\n", "pair", "RE_deg", "TE_mm");
  for (const PairError& error : errors) {
    const bool success = error.re_deg <= arguments.max_re_deg && error.te_m <= arguments.max_te_m;
    fmt::print("{:<24} {:>10.5f} {:>10.3f}{}\n", error.source + " - " + error.target, error.re_deg,
               1000.0 * error.te_m, success ? "" : "  wrong");
    if (!success) continue;
    ++successes;
    re_sum += error.re_deg;
    te_sum += error.te_m;
    te_max = std::max(te_max, error.te_m);
  }
  fmt::print("{} of {} pairs within {:g} deg and {:g} m; {} compared, {} wrong\n", successes,
             truth.size(), arguments.max_re_deg, arguments.max_te_m, errors.size(),
             errors.size() - successes);
  if (errors.size() < truth.size()) {
    fmt::print("{} not compared: the poses do not have both stations placed, in one component\n",
               truth.size() - errors.size());
  }
  if (successes > 0) {
    const auto n = static_cast<double>(successes);
    fmt::print("mean RE {:.5f} deg, mean TE {:.3f} mm, max TE {:.3f} mm (over successes)\n",
               re_sum / n, 1000.0 * te_sum / n, 1000.0 * te_max);
  }
  return successes == truth.size() ? kComplete : kPartial;
}

}  // namespace backsight
