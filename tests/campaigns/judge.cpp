#include "tests/campaigns/judge.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "io/csv_table.h"
#include "io/pose_files.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

constexpr double kWrongDeg = 1.0;
constexpr double kWrongM = 0.2;
/// What a heading of 0.03 deg moves: of stations half a kilometre apart that is no blunder.
constexpr double kWrongPerMetre = 0.0005;

struct Errors {
  double re_deg = 0.0;
  double te_m = 0.0;
  double distance_m = 0.0;  ///< between the two origins
  bool wrong() const { return re_deg > kWrongDeg || te_m > kWrongM + kWrongPerMetre * distance_m; }
};

Errors Compare(const RigidTransform& estimate, const RigidTransform& truth) {
  return {RotationErrorDeg(estimate, truth), (estimate.translation - truth.translation).norm(),
          truth.translation.norm()};
}

using Poses = std::map<std::string, RigidTransform>;

RigidTransform Relative(const Poses& poses, const std::string& target, const std::string& source) {
  return poses.at(target).Inverse() * poses.at(source);
}

std::map<std::string, Matrix6d> ReadCovariances(const std::string& poses_json) {
  const nlohmann::json document = nlohmann::json::parse(ReadBytes(poses_json));
  std::map<std::string, Matrix6d> covariances;
  for (const auto& pose : document.at("poses")) {
    const auto& rows = pose.at("covariance");
    if (rows.is_null()) continue;
    Matrix6d& matrix = covariances[pose.at("station").get<std::string>()];
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        matrix(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j));
      }
    }
  }
  return covariances;
}

/// links.csv, with the truth beside it.
class LinkJudge {
 public:
  LinkJudge(const std::string& path, const Poses& truth, const OverlapTable& overlaps)
      : table_(CsvTable::Load(path)), truth_(truth), overlaps_(overlaps) {}

  void Count(Judgement& judgement) const {
    for (const CsvTable::Row& row : table_.rows()) {
      const std::string correspondences = table_.Text(row, "correspondences");
      if (!correspondences.empty() && correspondences != "0") ++judgement.pairs_in_full;
      const bool accepted = table_.Text(row, "status") == "accepted";
      if (!accepted && table_.Text(row, "reason") != "contradicts_network") continue;
      const bool wrong = ErrorsOf(row)->wrong();
      if (accepted && table_.Real(row, "network_weight") > 0.0) {
        ++judgement.accepted_links;
        if (!wrong) continue;
        ++judgement.wrong_links;
        judgement.faults.push_back("wrong link " + Describe(row));
      } else {
        ++judgement.outvoted_links;
        if (wrong) ++judgement.outvoted_wrong;
      }
    }
  }

  /// What became of the station's pairs that truly overlap enough.
  std::vector<std::string> PairsOf(const std::string& station) const {
    std::vector<std::string> lines;
    for (const CsvTable::Row& row : table_.rows()) {
      const std::string source = table_.Text(row, "source");
      const std::string target = table_.Text(row, "target");
      if (source != station && target != station) continue;
      const auto overlap = overlaps_.find({source, target});
      if (overlap == overlaps_.end() || overlap->second < kPlaceableOverlap) continue;
      lines.push_back("  " + Describe(row));
    }
    return lines;
  }

 private:
  std::optional<Errors> ErrorsOf(const CsvTable::Row& row) const {
    if (table_.Text(row, "tx_m").empty()) return std::nullopt;
    const auto real = [&](const char* column) { return table_.Real(row, column); };
    const RigidTransform link = RigidTransform::FromQuaternion(
        Eigen::Quaterniond(real("qw"), real("qx"), real("qy"), real("qz")),
        {real("tx_m"), real("ty_m"), real("tz_m")});
    return Compare(link, Relative(truth_, table_.Text(row, "target"), table_.Text(row, "source")));
  }

  std::string Describe(const CsvTable::Row& row) const {
    const auto text = [&](const char* column) { return table_.Text(row, column); };
    const auto overlap = overlaps_.find({text("source"), text("target")});
    std::string line = fmt::format("{}-{} {} {} true overlap {:.2f}", text("source"),
                                   text("target"), text("status"), text("reason"),
                                   overlap == overlaps_.end() ? 0.0 : overlap->second);
    if (const auto errors = ErrorsOf(row)) {
      line += fmt::format(" RE {:.3f} deg TE {:.3f} m", errors->re_deg, errors->te_m);
    }
    for (const char* column :
         {"overlap", "conflict", "agreement", "candidates", "consensus", "consensus_null", "planes",
          "rms_m", "fine_status", "network_weight", "loop_controlled"}) {
      line += fmt::format(" {} {}", column, text(column).substr(0, 8));
    }
    return line;
  }

  CsvTable table_;
  const Poses& truth_;
  const OverlapTable& overlaps_;
};

void JudgeComponent(const Poses& members, const Poses& truth, const std::string& first,
                    const std::map<std::string, Matrix6d>& covariances, Judgement& judgement,
                    std::vector<double>& errors_m) {
  const RigidTransform frame_from_truth = members.at(first) * truth.at(first).Inverse();
  for (auto a = members.begin(); a != members.end(); ++a) {
    for (auto b = std::next(a); b != members.end(); ++b) {
      if (Compare(Relative(members, a->first, b->first), Relative(truth, a->first, b->first))
              .wrong()) {
        ++judgement.wrong_pairs;
      }
    }
    const auto& [id, estimate] = *a;
    if (id == first) continue;
    const RigidTransform expected = frame_from_truth * truth.at(id);
    const Errors errors = Compare(estimate, expected);
    errors_m.push_back(errors.te_m);
    judgement.max_te_m = std::max(judgement.max_te_m, errors.te_m);
    judgement.max_re_deg = std::max(judgement.max_re_deg, errors.re_deg);
    const auto covariance = covariances.find(id);
    if (covariance == covariances.end()) continue;
    PoseRecord record;
    record.survey_from_station = estimate;
    record.covariance = covariance->second;
    judgement.error_to_sigma.push_back(errors.te_m / SigmaOf(record)->position_m.norm());
    const Vector6d xi = LocalDifference(estimate, expected);
    judgement.nees_per_dof.push_back(xi.dot(covariance->second.ldlt().solve(xi)) / 6.0);
  }
}

/// A group counts as placed where most of it came out together.
void CountPlaced(const std::vector<std::vector<std::string>>& groups,
                 const std::map<std::string, int>& component_of, const LinkJudge& links,
                 Judgement& judgement) {
  for (const std::vector<std::string>& group : groups) {
    std::map<int, int> sizes;
    for (const std::string& id : group) {
      const auto found = component_of.find(id);
      if (found != component_of.end()) ++sizes[found->second];
    }
    const auto largest =
        std::max_element(sizes.begin(), sizes.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    judgement.placeable += static_cast<int>(group.size());
    for (const std::string& id : group) {
      const auto found = component_of.find(id);
      if (found != component_of.end() && found->second == largest->first) {
        ++judgement.placed;
        continue;
      }
      judgement.faults.push_back("not placed " + id);
      for (std::string& line : links.PairsOf(id)) judgement.faults.push_back(std::move(line));
    }
  }
}

}  // namespace

Judgement Judge(const std::string& folder, const ScanPaths& scans) {
  const Poses truth = ReadPoses(folder + "/truth.csv");
  const OverlapTable overlaps = TrueOverlaps(scans, truth);
  const LinkJudge links(folder + "/out/links.csv", truth, overlaps);
  Judgement judgement;
  judgement.stations = static_cast<int>(truth.size());
  links.Count(judgement);

  std::map<int, Poses> components;
  std::map<int, std::string> first_of;
  std::map<std::string, int> component_of;
  for (const PoseRecord& pose : ReadPoseRecords(folder + "/out/poses.csv")) {
    if (pose.status != StationStatus::kRegistered) continue;
    components[pose.component][pose.station] = pose.survey_from_station;
    first_of.emplace(pose.component, pose.station);
    component_of[pose.station] = pose.component;
  }
  judgement.components = static_cast<int>(components.size());
  const auto covariances = ReadCovariances(folder + "/out/poses.json");
  std::vector<double> errors_m;
  for (const auto& [component, members] : components) {
    JudgeComponent(members, truth, first_of.at(component), covariances, judgement, errors_m);
  }
  judgement.mean_te_m = Mean(errors_m);
  CountPlaced(PlaceableGroups(overlaps, truth), component_of, links, judgement);
  return judgement;
}

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string JudgementHeader() {
  return fmt::format(
      "{:<13} {:>5} {:>4} {:>3} {:>9} {:>4} {:>5} {:>5} {:>9} {:>6} {:>9} {:>9} "
      "{:>9} {:>6} {:>6} {:>5} {:>6}\n",
      "campaign", "seed", "exit", "n", "placed", "comp", "links", "wrong", "outvoted", "wrongp",
      "mean TE", "max TE mm", "max RE d", "e/s 68", "NEES/6", "pairs", "s");
}

std::string JudgementLine(const Judgement& j) {
  return fmt::format(
      "{:<13} {:>5} {:>4} {:>3} {:>9} {:>4} {:>5} {:>5} {:>9} {:>6} {:>9.2f} {:>9.2f} {:>9.4f} "
      "{:>6.2f} {:>6.2f} {:>5} {:>6.0f}\n",
      j.name, j.seed, j.exit_code, j.stations, fmt::format("{}/{}", j.placed, j.placeable),
      j.components, j.accepted_links, j.wrong_links,
      fmt::format("{}({})", j.outvoted_links, j.outvoted_wrong), j.wrong_pairs,
      1000.0 * j.mean_te_m, 1000.0 * j.max_te_m, j.max_re_deg, Percentile(j.error_to_sigma, 0.68),
      Mean(j.nees_per_dof), j.pairs_in_full, j.seconds);
}

Judgement Total(const std::vector<Judgement>& judgements) {
  Judgement total;
  total.name = "all";
  total.exit_code = 0;
  double error_sum = 0.0;
  for (const Judgement& j : judgements) {
    total.stations += j.stations;
    total.placeable += j.placeable;
    total.placed += j.placed;
    total.components += j.components;
    total.pairs_in_full += j.pairs_in_full;
    total.accepted_links += j.accepted_links;
    total.wrong_links += j.wrong_links;
    total.outvoted_links += j.outvoted_links;
    total.outvoted_wrong += j.outvoted_wrong;
    total.wrong_pairs += j.wrong_pairs;
    total.max_te_m = std::max(total.max_te_m, j.max_te_m);
    total.max_re_deg = std::max(total.max_re_deg, j.max_re_deg);
    if (std::isfinite(j.mean_te_m)) error_sum += j.stations * j.mean_te_m;
    total.error_to_sigma.insert(total.error_to_sigma.end(), j.error_to_sigma.begin(),
                                j.error_to_sigma.end());
    total.nees_per_dof.insert(total.nees_per_dof.end(), j.nees_per_dof.begin(),
                              j.nees_per_dof.end());
    total.seconds += j.seconds;
  }
  if (total.stations > 0) total.mean_te_m = error_sum / total.stations;
  return total;
}

}  // namespace backsight
