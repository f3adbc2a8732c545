#include "pipeline/run_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/name_list.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

constexpr const char* kAllStations = "require_all_stations";

/// In the main network.
int CountPlaced(const std::vector<PoseRecord>& poses) {
  return static_cast<int>(std::count_if(poses.begin(), poses.end(), [](const PoseRecord& pose) {
    return pose.status == StationStatus::kRegistered && pose.component == 0;
  }));
}

/// Of its place on the ground where control gives it one.
std::optional<PoseSigma> SigmaOnGround(const PoseRecord& pose) {
  if (!pose.ground) return SigmaOf(pose);
  return SigmaOf(pose.ground->enu_from_station, pose.ground->covariance);
}

/// Of the stations that are placed; none at all, or one of unknown sigma, is a failure. Says whose
/// sigmas are not on the ground although there is control.
GateRecord JudgeSigmas(double limit_mm, const std::vector<PoseRecord>& poses, bool has_control) {
  double worst_mm = 0.0;
  int placed = 0, known = 0, relative = 0;
  for (const PoseRecord& pose : poses) {
    if (pose.status != StationStatus::kRegistered) continue;
    ++placed;
    if (has_control && !pose.ground) ++relative;
    const auto sigma = SigmaOnGround(pose);
    if (!sigma) continue;
    ++known;
    worst_mm = std::max(worst_mm, 1000.0 * sigma->worst_position_m);
  }
  std::string value = placed == 0 ? "no station placed" : fmt::format("{:.2f} mm", worst_mm);
  if (known < placed) value += fmt::format(", unknown of {} stations", placed - known);
  if (relative > 0) {
    value += fmt::format(", relative for {} stations that control does not tie", relative);
  }
  return {"max_station_sigma_mm", fmt::format("{:g} mm", limit_mm), value,
          placed > 0 && known == placed && worst_mm <= limit_mm};
}

/// The component with the largest error; no check points at all are a failure, too.
GateRecord JudgeCheckPoints(double limit_mm, const std::vector<GeoreferenceRecord>& georeference) {
  CheckRecord worst;
  for (const GeoreferenceRecord& record : georeference) {
    if (record.check.points == 0) continue;
    if (worst.points == 0 || record.check.rmse_3d_m > worst.rmse_3d_m) worst = record.check;
  }
  const double rmse_mm = 1000.0 * worst.rmse_3d_m;
  return {"max_check_rmse_mm", fmt::format("{:g} mm, 3D", limit_mm),
          worst.points == 0 ? "no check points"
                            : fmt::format("{:.2f} mm, n = {}", rmse_mm, worst.points),
          worst.points > 0 && rmse_mm <= limit_mm};
}

/// "5 of 6 placed together, without S4 (its scan cannot be used)": how many are in the main
/// network, and who is not.
std::string PlacedText(const std::vector<PoseRecord>& poses) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> missing;
  for (const PoseRecord& pose : poses) {
    if (pose.status == StationStatus::kRegistered && pose.component == 0) continue;
    missing.push_back(pose.station + (pose.status == StationStatus::kUnreadable
                                          ? " (its scan cannot be used)"
                                          : ""));
  }
  const std::string placed =
      fmt::format("{} of {} placed together", CountPlaced(poses), poses.size());
  return missing.empty() ? placed : placed + ", without " + FirstNames(missing, kNamed);
}

/// False if there is control and it does not place the main network.
bool IsOnGround(const RunRecord& run) {
  return run.georeference.empty() || run.georeference.front().placed();
}

/// With the number of stations that are placed, which the gate for all of them tells itself.
std::string DescribeFailedGates(const std::vector<GateRecord>& gates, int placed, int all) {
  std::string text;
  bool told = false;
  for (const GateRecord& gate : gates) {
    if (gate.passed) continue;
    text += fmt::format("{} {} failed: {} (limit {})", text.empty() ? "Gate" : "; gate", gate.name,
                        gate.value, gate.limit);
    told |= gate.name == kAllStations;
  }
  return text + (told ? "." : fmt::format(". {} of {} stations placed.", placed, all));
}

}  // namespace

std::vector<GateRecord> JudgeGates(const GateSpec& gates, const std::vector<PoseRecord>& poses,
                                   const std::vector<GeoreferenceRecord>& georeference) {
  std::vector<GateRecord> judged;
  for (const GeoreferenceRecord& record : georeference) {
    if (record.status != "contradictory") continue;
    judged.push_back({"control_agrees", "residuals that the sigmas explain",
                      fmt::format("residuals of control {:.1f} times as large as its sigmas allow",
                                  std::sqrt(record.variance_factor)),
                      false});
  }
  if (gates.max_check_rmse_mm) {
    judged.push_back(JudgeCheckPoints(*gates.max_check_rmse_mm, georeference));
  }
  if (gates.max_station_sigma_mm) {
    judged.push_back(JudgeSigmas(*gates.max_station_sigma_mm, poses, !georeference.empty()));
  }
  if (gates.require_all_stations) {
    const int placed = CountPlaced(poses);
    judged.push_back(
        {kAllStations, "all", PlacedText(poses), placed == static_cast<int>(poses.size())});
  }
  return judged;
}

void Judge(const Completion& completion, RunRecord* run) {
  const int all = static_cast<int>(run->poses.size());
  const int placed = CountPlaced(run->poses);
  const int usable = static_cast<int>(std::count_if(
      run->poses.begin(), run->poses.end(),
      [](const PoseRecord& pose) { return pose.status != StationStatus::kUnreadable; }));
  const bool failed = std::any_of(run->gates.begin(), run->gates.end(),
                                  [](const GateRecord& gate) { return !gate.passed; });
  if (usable < 2) {
    run->exit_code = kNoUsableInput;
    run->verdict = fmt::format("No usable input: {} of {} scans could be read.", usable, all);
  } else if (failed) {
    run->exit_code = kGateFailed;
    run->verdict = DescribeFailedGates(run->gates, placed, all);
  } else if (!IsOnGround(*run)) {
    run->exit_code = kPartial;
    run->verdict = fmt::format(
        "Partial: {} of {} stations placed in one network, which control does not tie to the "
        "ground.",
        placed, all);
  } else if (placed < all) {
    run->exit_code = kPartial;
    run->verdict = fmt::format("Partial: {} of {} stations placed in one network.", placed, all);
  } else if (!completion.converged) {
    run->exit_code = kPartial;
    run->verdict = fmt::format(
        "Partial: all {} stations placed in one network, whose adjustment did not converge: poses "
        "are provisional.",
        all);
  } else if (completion.failed_pairs > 0) {
    run->exit_code = kPartial;
    run->verdict = fmt::format(
        "Partial: all {} stations placed in one network, but {} pair(s) of them failed.", all,
        completion.failed_pairs);
  } else {
    run->exit_code = kComplete;
    run->verdict = fmt::format("Complete: all {} stations placed in one network.", all);
  }
}

}  // namespace backsight
