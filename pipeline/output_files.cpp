#include "pipeline/output_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>

#include "core/error.h"
#include "io/output_names.h"
#include "io/temporary_file.h"
#include "pipeline/map_output.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

std::set<std::string> KeysOfScans(const SurveyProject& project) {
  std::set<std::string> keys;
  for (const StationSpec& station : project.stations) {
    std::error_code error;
    keys.insert(FileKey(station.scan));
    keys.insert(fs::weakly_canonical(station.scan, error).string());
  }
  return keys;
}

std::set<std::string> KeysOf(const std::vector<OutputRecord>& written) {
  std::set<std::string> keys;
  for (const OutputRecord& file : written) keys.insert(FileKey(file.path));
  return keys;
}

/// Every file beside the output that some run could have written for it, in order.
std::vector<std::string> PossibleFiles(CloudOutput output) {
  output.max_points = output.format == CloudFormat::kLas ? 1 : 0;
  std::vector<std::string> files;
  std::error_code error;
  fs::path folder = fs::path(output.path).parent_path();
  if (folder.empty()) folder = ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!MayWrite(output, std::numeric_limits<int>::max(), entry.path().string())) continue;
    files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool IsOf(const std::vector<WrittenCloud>& earlier, const std::string& file) {
  std::error_code error;
  if (fs::symlink_status(file, error).type() != fs::file_type::regular) return false;
  const std::optional<WrittenCloud> now = DescribeFile(file);
  if (!now) return false;
  return std::any_of(earlier.begin(), earlier.end(), [&](const WrittenCloud& cloud) {
    return cloud.bytes == now->bytes && cloud.modified == now->modified &&
           FileKey(cloud.path) == FileKey(file);
  });
}

/// Removes the half written files of a folder whose targets `ours` knows.
void RemoveTemporariesIn(const fs::path& folder,
                         const std::function<bool(const std::string& target)>& ours) {
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string target = TargetOfTemporary(entry->path().filename().string());
    if (target.empty() || !ours((folder / target).string())) continue;
    std::error_code ignored;
    fs::remove(entry->path(), ignored);
  }
}

class StaleClouds {
 public:
  StaleClouds(const SurveyProject& project, const std::vector<WrittenCloud>& earlier,
              const std::vector<OutputRecord>& written)
      : earlier_(earlier), written_(KeysOf(written)), scans_(KeysOfScans(project)) {}

  void LookBeside(const CloudOutput& merged) {
    const std::vector<std::string> files = PossibleFiles(merged);
    const bool written_anew = std::any_of(files.begin(), files.end(), [&](const auto& file) {
      return written_.contains(FileKey(file));
    });
    for (const std::string& file : files) Judge(file, written_anew);
  }

  void LookAt(const std::string& station_cloud) {
    std::error_code error;
    if (fs::exists(station_cloud, error)) Judge(station_cloud, false);
  }

  /// What the manifest lists and no output of the project may be called now.
  void LookAtEarlier() {
    for (const WrittenCloud& cloud : earlier_) {
      if (!judged_.contains(FileKey(cloud.path)) && IsOf(earlier_, cloud.path)) {
        Judge(cloud.path, false);
      }
    }
  }

  const std::string& removed() const { return removed_; }
  const std::string& left() const { return left_; }

 private:
  void Judge(const std::string& file, bool may_go) {
    const std::string key = FileKey(file);
    judged_.insert(key);
    if (written_.contains(key) || scans_.contains(key)) return;
    std::error_code error;
    const bool gone = may_go && IsOf(earlier_, file) && fs::remove(file, error);
    std::string& list = gone ? removed_ : left_;
    list += (list.empty() ? "" : ", ") + file;
  }

  const std::vector<WrittenCloud>& earlier_;
  std::set<std::string> written_;
  std::set<std::string> scans_;
  std::set<std::string> judged_;
  std::string removed_;
  std::string left_;
};

}  // namespace

std::optional<WrittenCloud> DescribeFile(const std::string& path) {
  std::error_code no_size;
  std::error_code no_time;
  std::error_code no_path;
  const std::uintmax_t bytes = fs::file_size(path, no_size);
  const fs::file_time_type modified = fs::last_write_time(path, no_time);
  const fs::path absolute = fs::absolute(path, no_path);
  if (no_size || no_time || no_path) return std::nullopt;
  const auto unix_time = std::chrono::file_clock::to_sys(modified).time_since_epoch();
  return WrittenCloud{absolute.string(), bytes,
                      std::chrono::duration_cast<std::chrono::nanoseconds>(unix_time).count()};
}

std::string StaleWarning(const std::string& files) {
  return "not written by this run, and nothing of its result: " + files;
}

std::string UsualOutDirectory(const std::string& project_path) {
  return (fs::path(project_path).parent_path() / "out").string();
}

std::string UsualWorkDirectory(const std::string& project_path) {
  return (fs::path(project_path).parent_path() / "work").string();
}

void RemoveHalfWrittenArtifacts(const std::string& work_directory) {
  const auto any = [](const std::string&) { return true; };
  for (const char* name : {"scans", "stations", "pairs", "network", "outputs", "slurm"}) {
    const fs::path folder = fs::path(work_directory) / name;
    RemoveTemporariesIn(folder, any);
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {  // they lie two folders deep at most
      if (entry->is_directory(error)) RemoveTemporariesIn(entry->path(), any);
    }
  }
}

void RemoveTemporaries(const SurveyProject& project, const std::string& out_directory) {
  const std::set<std::string> reports = {"poses.csv",   "poses.json",  "links.csv",
                                         "report.json", "report.html", "manifest.json"};
  RemoveTemporariesIn(out_directory, [&](const std::string& target) {
    return reports.contains(fs::path(target).filename().string());
  });
  const int components = MostComponents(project.stations.size());
  std::vector<CloudOutput> outputs = AllClouds(project, out_directory);
  CloudOutput map;
  map.path = WantedMap(project, out_directory).path;
  if (!map.path.empty()) outputs.push_back(map);
  for (const CloudOutput& output : outputs) {
    RemoveTemporariesIn(fs::path(output.path).parent_path(), [&](const std::string& target) {
      return MayWrite(output, components, target);
    });
  }
}

std::vector<CloudOutput> MergedOutputs(const SurveyProject& project,
                                       const std::string& out_directory) {
  CloudOutput usual;
  usual.path = (fs::path(out_directory) / "merged.las").string();
  return project.outputs.merged.value_or(std::vector{usual});
}

std::vector<CloudOutput> StationOutputs(const SurveyProject& project) {
  std::vector<CloudOutput> outputs;
  for (const StationSpec& station : project.stations) {
    if (!project.outputs.stations) break;
    outputs.push_back(*project.outputs.stations);
    outputs.back().path = StationCloudPath(*project.outputs.stations, station.id);
  }
  return outputs;
}

std::vector<CloudOutput> AllClouds(const SurveyProject& project, const std::string& out_directory) {
  std::vector<CloudOutput> clouds = MergedOutputs(project, out_directory);
  const std::vector<CloudOutput> stations = StationOutputs(project);
  clouds.insert(clouds.end(), stations.begin(), stations.end());
  return clouds;
}

std::vector<CloudOutput> CloudsOfNetwork(const SurveyProject& project,
                                         const std::string& out_directory,
                                         const std::vector<int>& component) {
  std::set<int> components(component.begin(), component.end());
  components.erase(components.begin(), components.lower_bound(0));
  std::vector<CloudOutput> clouds;
  for (const CloudOutput& output : MergedOutputs(project, out_directory)) {
    for (const int number : components) {
      clouds.push_back(output);
      clouds.back().path = ComponentPath(output.path, number);
    }
  }
  const std::vector<CloudOutput> stations = StationOutputs(project);
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (component[s] >= 0) clouds.push_back(stations[s]);
  }
  return clouds;
}

void RequireFreeNames(const SurveyProject& project, const std::string& out_directory) {
  if (project.outputs.merged) return;
  const CloudOutput usual = MergedOutputs(project, out_directory).front();
  const int components = MostComponents(project.stations.size());
  const auto require = [&](const std::string& file, const std::string& what) {
    if (!MayWrite(usual, components, file)) return;
    throw InputError({project.path,
                      fmt::format("{}, {}, has a name that the merged cloud may get", file, what),
                      "a merged cloud under a name that no scan and no other output has",
                      "give outputs.merged with another path, or another --out"});
  };
  for (const std::string& key : KeysOfScans(project)) require(key, "a scan");
  for (const StationSpec& station : project.stations) {
    if (!project.outputs.stations) break;
    require(StationCloudPath(*project.outputs.stations, station.id),
            "the cloud of station " + station.id);
  }
}

std::vector<std::string> ClearStaleClouds(const SurveyProject& project,
                                          const std::string& out_directory,
                                          const std::vector<WrittenCloud>& earlier,
                                          const std::vector<OutputRecord>& written,
                                          const ExecutionContext& context) {
  StaleClouds stale(project, earlier, written);
  for (const CloudOutput& output : MergedOutputs(project, out_directory)) {
    stale.LookBeside(output);
  }
  for (const CloudOutput& station : StationOutputs(project)) stale.LookAt(station.path);
  stale.LookAtEarlier();
  if (!stale.removed().empty()) {
    context.Warning("removed what an earlier run had written and this one did not: " +
                    stale.removed());
  }
  if (stale.left().empty()) return {};
  const std::string warning = StaleWarning(stale.left());
  context.Warning(warning);
  return {warning};
}

}  // namespace backsight
