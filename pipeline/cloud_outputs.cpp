#include "pipeline/cloud_outputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string_view>

#include "core/error.h"
#include "io/cloud_writer.h"
#include "io/e57/e57_cloud_writer.h"
#include "io/output_names.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/output_units.h"
#include "pipeline/e57_scans.h"
#include "pipeline/output_files.h"
#include "pipeline/run_outputs.h"
#include "pipeline/version.h"
#include "stages/merging.h"
#include "stages/surface_incidence.h"
#include "stages/tabulated_map.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

bool IsPlaced(const OutputSource& source, std::size_t s) {
  return source.stations[s].usable() && source.network.component[s] >= 0;
}

/// The stations in the frame of the control where there is one, otherwise in the survey frame.
/// `context` must outlive them.
std::vector<MergeStation> MergeStationsOf(const std::vector<int>& stations,
                                          const OutputSource& source,
                                          const ExecutionContext& context) {
  std::vector<MergeStation> members;
  for (const int index : stations) {
    const auto s = static_cast<std::size_t>(index);
    const Station& station = source.stations[s];
    MergeStation member;
    member.number = index + 1;
    member.frame_from_station =
        source.ground.enu_from_station[s].value_or(source.network.survey_from_station[s]);
    member.scale = source.ground.ScaleOf(source.network.component[s]);
    member.range_origin = station.spec.scanner_origin_m.value_or(Eigen::Vector3d::Zero());
    member.min = station.model.min;
    member.max = station.model.max;
    member.min_range_m = source.ingest.min_range_m;
    member.max_range_m = source.ingest.max_range_m;
    member.has_intensity = station.info.has_intensity;
    member.has_rgb = station.info.has_rgb;
    member.open = [spec = station.spec, &context] {
      return OpenScan(spec.scan, spec.scan_index, spec.columns,
                      [&context] { context.CheckStop(); });
    };
    if (!station.scan.stamp.empty()) {
      member.require_unchanged = [path = station.spec.scan, scan = station.scan, &context] {
        RequireUnchanged(path, scan, context);
      };
    }
    member.cos_incidence =
        [incidence = SurfaceIncidence(station.surface())](const Eigen::Vector3d& point) mutable {
          return incidence.CosAt(point);
        };
    member.is_moving = IsMovingFunction(station, source.moving.Of(s));
    members.push_back(std::move(member));
  }
  return members;
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
  throw InternalError("an E57 file is no flat cloud");
}

std::string_view NameOf(CloudFormat format) {
  switch (format) {
    case CloudFormat::kLas:
      return "LAS 1.4";
    case CloudFormat::kPly:
      return "PLY";
    case CloudFormat::kPcd:
      return "PCD";
    case CloudFormat::kE57:
      break;
  }
  return "E57";
}

/// What a part of a cloud holds, for people; empty where it is all that there is.
std::string SelectionText(const MergeOptions& merge, std::size_t part, std::size_t parts) {
  std::vector<std::string> said;
  if (merge.thin_m > 0.0)
    said.push_back(fmt::format("the best per cell of {:g} mm", 1e3 * merge.thin_m));
  if (merge.crop) said.emplace_back("within the crop box");
  if (merge.without_moving) said.emplace_back("without what moved");
  if (parts > 1) said.push_back(fmt::format("part {} of {}", part, parts));
  return fmt::format("{}", fmt::join(said, ", "));
}

/// Points in output coordinates. A field is in the cloud only where every station has it.
std::vector<WrittenFile> WriteFlat(const CloudOutput& output, const std::string& wkt,
                                   std::vector<MergeStation> members, const MergeOptions& merge,
                                   const ExecutionContext& context) {
  const CloudBounds bounds = MergedBounds(members, merge);
  CloudWriterSpec spec;
  spec.wkt = wkt;
  spec.path = output.path;
  spec.generator = fmt::format("backsight {}", kVersion);
  spec.min = bounds.min;
  spec.max = bounds.max;
  spec.has_intensity = std::all_of(members.begin(), members.end(),
                                   [](const MergeStation& m) { return m.has_intensity; });
  spec.has_rgb =
      std::all_of(members.begin(), members.end(), [](const MergeStation& m) { return m.has_rgb; });
  spec.has_classification = !merge.without_moving;  // whatever was found: one layout for all parts
  for (MergeStation& member : members) {
    member.has_intensity = spec.has_intensity;
    member.has_rgb = spec.has_rgb;
  }
  spec.max_points_per_file = static_cast<std::uint64_t>(output.max_points);
  spec.between = [&context] { context.CheckStop(); };
  const auto writer = CreateWriter(output.format, spec);
  MergeClouds(members, merge, *writer, context);
  return WrittenFiles(spec, writer->Finish());
}

/// Points in their stations' frames, with the stations' poses.
std::vector<WrittenFile> WriteE57(const CloudOutput& output, const std::vector<int>& stations,
                                  const OutputSource& source, const GeodeticFrame* frame,
                                  MergeOptions merge, const ExecutionContext& context) {
  merge.in_station_frames = true;
  const std::map<int, E57ScanSpec> scans = E57ScansOf(stations, source, output);
  E57FileSpec file = E57FileOf(output, scans, frame);
  file.between = [&context] { context.CheckStop(); };
  const auto writer = CreateE57CloudWriter(std::move(file), scans);
  MergeClouds(MergeStationsOf(stations, source, context), merge, *writer, context);
  return {{output.path, writer->Finish()}};
}

/// The exact way of a point takes longer than to read and to write it.
OutputMap OutputMapOf(const GeoreferencedNetwork& ground) {
  constexpr double kCell_m = 4.0;        // the Earth bends by 1e-6 m within it
  constexpr double kTolerance_m = 2e-6;  // a fiftieth of what LAS can tell
  const auto map = std::make_shared<TabulatedMap>(
      [&ground](const Eigen::Vector3d& enu) { return ground.OutputFromEnu(enu); }, kCell_m,
      kTolerance_m);
  return [map](std::span<Eigen::Vector3d> points) { map->Apply(points); };
}

/// Writes the stations, all of one component, as one cloud to output.path.
OutputFiles WriteCloud(const CloudOutput& output, const std::vector<int>& stations,
                       const OutputSource& source, const ExecutionContext& context) {
  OutputFiles written;
  const GeoreferencedNetwork& ground = source.ground;
  const auto component = static_cast<std::size_t>(
      source.network.component[static_cast<std::size_t>(stations.front())]);
  const bool in_crs = ground.frame && ground.parts[component].placed();
  MergeOptions merge;
  if (in_crs) merge.map = OutputMapOf(ground);
  merge.thin_m = output.thin_m;
  merge.without_moving = output.without_moving;
  merge.thinning.path = output.path + ".thin";
  const bool in_survey_frame = !ground.parts.empty() && !ground.parts[component].placed();
  if (!in_survey_frame) {
    merge.crop = output.crop;
  } else if (output.crop) {
    written.warnings.push_back(
        fmt::format("{}: not cropped, because control does not place its stations", output.path));
  }
  MakeDirectories(fs::path(output.path).parent_path().string());
  const std::vector<WrittenFile> files =
      output.format == CloudFormat::kE57
          ? WriteE57(output, stations, source, in_crs ? ground.frame.get() : nullptr, merge,
                     context)
          : WriteFlat(output, in_crs ? ground.frame->wkt() : "",
                      MergeStationsOf(stations, source, context), merge, context);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const WrittenFile& file = files[i];
    written.files.push_back({file.path, std::string(NameOf(output.format)),
                             SelectionText(merge, i + 1, files.size()), file.points});
    if (file.points == 0) {
      written.warnings.push_back(
          fmt::format("{}: no point is left of what was asked for", file.path));
    }
  }
  return written;
}

/// WriteCloud, unless the cloud lies there already.
void AddCloud(const CloudOutput& output, const std::vector<int>& stations,
              const OutputSource& source, const ExecutionContext& context, OutputFiles* written) {
  written->Add(WriteOnce(source.store, output.path, CloudKey(output, stations, source.key), context,
                         [&] { return WriteCloud(output, stations, source, context); }));
}

void WriteMergedClouds(const std::vector<CloudOutput>& wanted, const OutputSource& source,
                       const ExecutionContext& context, OutputFiles* written) {
  std::map<int, std::vector<int>> components;
  for (std::size_t s = 0; s < source.stations.size(); ++s) {
    if (IsPlaced(source, s)) components[source.network.component[s]].push_back(static_cast<int>(s));
  }
  for (const CloudOutput& output : wanted) {
    for (const auto& [component, stations] : components) {
      CloudOutput part = output;
      part.path = ComponentPath(output.path, component);
      AddCloud(part, stations, source, context, written);
    }
  }
}

void WriteStationClouds(const CloudOutput& wanted, const OutputSource& source,
                        const ExecutionContext& context, OutputFiles* written) {
  std::string left_out;
  for (std::size_t s = 0; s < source.stations.size(); ++s) {
    const std::string& id = source.stations[s].spec.id;
    if (!IsPlaced(source, s)) {
      left_out += (left_out.empty() ? "" : ", ") + id;
      continue;
    }
    CloudOutput output = wanted;
    output.path = StationCloudPath(wanted, id);
    AddCloud(output, {static_cast<int>(s)}, source, context, written);
  }
  if (left_out.empty()) return;
  written->warnings.push_back(
      fmt::format("no registered cloud of {}: not placed in the network", left_out));
}

}  // namespace

ArtifactKey CloudKey(const CloudOutput& output, const std::vector<int>& stations, ArtifactKey key) {
  key.Add("format", NameOf(output.format));
  key.Add("thin_m", output.thin_m);
  key.Add("max_points", std::to_string(output.max_points));
  key.Add("without_moving", output.without_moving ? "yes" : "no");
  key.Add("crop", output.crop ? DigestOf(*output.crop) : "none");
  for (const int station : stations) key.Add("member", std::to_string(station));
  return key;
}

OutputFiles WriteClouds(const SurveyProject& project, const OutputSource& source,
                        const std::string& out_directory, const ExecutionContext& context) {
  OutputFiles written;
  WriteMergedClouds(MergedOutputs(project, out_directory), source, context, &written);
  if (project.outputs.stations) {
    WriteStationClouds(*project.outputs.stations, source, context, &written);
  }
  for (const std::string& warning : written.warnings) context.Warning(warning);
  return written;
}

}  // namespace backsight
