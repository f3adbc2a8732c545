#include "pipeline/run_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string_view>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/report_html.h"
#include "io/run_json.h"
#include "io/run_tables.h"
#include "pipeline/version.h"
#include "stages/merging.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

/// Stations in the frame of the control where there is one, otherwise in the survey frame.
std::vector<MergeStation> StationsOf(int component, const IngestOptions& ingest,
                                     const std::vector<Station>& stations, const Network& network,
                                     const GeoreferencedNetwork& ground) {
  std::vector<MergeStation> members;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (!stations[s].usable() || network.component[s] != component) continue;
    const Station& station = stations[s];
    MergeStation member;
    member.number = static_cast<int>(s) + 1;
    member.frame_from_station = ground.enu_from_station[s].value_or(network.survey_from_station[s]);
    member.scale = ground.ScaleOf(component);
    member.range_origin = station.spec.scanner_origin_m.value_or(Eigen::Vector3d::Zero());
    member.min = station.model.min;
    member.max = station.model.max;
    member.min_range_m = ingest.min_range_m;
    member.max_range_m = ingest.max_range_m;
    member.open = [path = station.spec.scan, index = station.spec.scan_index] {
      return OpenScan(path, index);
    };
    members.push_back(std::move(member));
  }
  return members;
}

/// A field is in the merged cloud only where every station has it.
template <class Has>
bool AllHave(const std::vector<Station>& stations, const Network& network, int component, Has has) {
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (stations[s].usable() && network.component[s] == component && !has(stations[s].info)) {
      return false;
    }
  }
  return true;
}

std::string ComponentPath(const std::string& path, int component) {
  if (component == 0) return path;
  const fs::path p(path);
  return (p.parent_path() /
          fmt::format("{}_component{}{}", p.stem().string(), component + 1, p.extension().string()))
      .string();
}

std::unique_ptr<CloudWriter> CreateWriter(CloudFormat format, const CloudWriterSpec& spec) {
  switch (format) {
    case CloudFormat::kLas:
      return CreateLasWriter(spec);
    case CloudFormat::kPly:
      return CreatePlyWriter(spec);
    case CloudFormat::kPcd:
      return CreatePcdWriter(spec);
    case CloudFormat::kE57:
      break;
  }
  throw InternalError("a merged cloud in a format that cannot be written");
}

std::string_view NameOf(CloudFormat format) {
  if (format == CloudFormat::kLas) return "LAS 1.4";
  return format == CloudFormat::kPly ? "PLY" : "PCD";
}

/// One record per file.
std::vector<OutputRecord> WriteMergedCloud(const CloudOutput& output, int component,
                                           const IngestOptions& ingest,
                                           const std::vector<Station>& stations,
                                           const Network& network,
                                           const GeoreferencedNetwork& ground,
                                           const ExecutionContext& context) {
  std::vector<MergeStation> members = StationsOf(component, ingest, stations, network, ground);
  const bool in_crs = ground.frame && ground.parts[static_cast<std::size_t>(component)].placed();
  OutputMap map;
  if (in_crs) map = [&](const Eigen::Vector3d& enu) { return ground.OutputFromEnu(enu); };
  const CloudBounds bounds = MergedBounds(members, map);
  CloudWriterSpec spec;
  if (in_crs) spec.wkt = ground.frame->wkt();
  spec.path = ComponentPath(output.path, component);
  spec.generator = fmt::format("backsight {}", kVersion);
  spec.min = bounds.min;
  spec.max = bounds.max;
  spec.has_intensity = AllHave(stations, network, component,
                               [](const ScanInfo& info) { return info.has_intensity; });
  spec.has_rgb =
      AllHave(stations, network, component, [](const ScanInfo& info) { return info.has_rgb; });
  for (MergeStation& member : members) {
    member.has_intensity = spec.has_intensity;
    member.has_rgb = spec.has_rgb;
  }
  MakeDirectories(fs::path(spec.path).parent_path().string());
  spec.max_points_per_file = static_cast<std::uint64_t>(output.max_points);
  const auto writer = CreateWriter(output.format, spec);
  MergeClouds(members, map, output.thin_m, *writer, context);
  std::vector<OutputRecord> records;
  for (const WrittenFile& file : WrittenFiles(spec, writer->Finish())) {
    records.push_back({file.path, std::string(NameOf(output.format)), file.points});
  }
  return records;
}

}  // namespace

void MakeDirectories(const std::string& path) {
  std::error_code error;
  if (!path.empty()) fs::create_directories(path, error);
  if (error) {
    throw InputError({path, "cannot be made: " + error.message(), "a directory to write into", ""});
  }
}

std::vector<OutputRecord> WriteMergedClouds(
    const SurveyProject& project, const IngestOptions& ingest, const std::vector<Station>& stations,
    const Network& network, const GeoreferencedNetwork& ground, const std::string& out_directory,
    const ExecutionContext& context) {
  const std::vector<CloudOutput> wanted = project.outputs.merged.value_or(std::vector<CloudOutput>{
      {CloudFormat::kLas, (fs::path(out_directory) / "merged.las").string(), 0.0, 0}});
  const int components =
      1 + (network.component.empty()
               ? -1
               : *std::max_element(network.component.begin(), network.component.end()));
  std::vector<OutputRecord> written;
  for (const CloudOutput& output : wanted) {
    for (int component = 0; component < components; ++component) {
      const auto records =
          WriteMergedCloud(output, component, ingest, stations, network, ground, context);
      written.insert(written.end(), records.begin(), records.end());
    }
  }
  return written;
}

void WriteReports(const RunRecord& run, const std::vector<ReportPicture>& pictures,
                  const std::string& out_directory) {
  const fs::path out(out_directory);
  WriteTextFile((out / "poses.csv").string(), PosesCsv(run.poses));
  WriteTextFile((out / "poses.json").string(), PosesJson(run.poses));
  WriteTextFile((out / "links.csv").string(), LinksCsv(run.links));
  WriteTextFile((out / "report.json").string(), ReportJson(run));
  WriteTextFile((out / "report.html").string(), ReportHtml(run, pictures));
}

}  // namespace backsight
