#include "pipeline/simulate_campaign.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/ptx_writer.h"
#include "io/scene_file.h"
#include "pipeline/campaign_files.h"
#include "stages/simulation/campaign.h"

namespace backsight {
namespace {

/// Writing text takes longer than scanning and is serial, so stations go side by side.
constexpr std::size_t kMaxStationsInMemory = 4;

Eigen::Vector3d PointAt(const PointChunk& grid, std::size_t i) {
  return {grid.x[i], grid.y[i], grid.z[i]};
}

/// The header states the identity: a pose in it would give the truth away.
void WritePtx(const StationScan& scan, const std::string& path) {
  PtxWriter writer(path);
  PtxWriter::Scan header;
  header.columns = scan.columns;
  header.rows = scan.rows;
  header.has_rgb = true;
  writer.BeginScan(header);
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d point = PointAt(scan.grid, i);
    if (point.isZero(0.0)) {
      writer.AddNoReturn();
      continue;
    }
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
      rgb[c] = static_cast<std::uint8_t>(scan.grid.rgb[i][c] / 257U);
    }
    writer.AddPoint(point, static_cast<double>(scan.grid.intensity[i]), rgb);
  }
  writer.Finish();
}

void WriteCloud(const StationScan& scan, CampaignFormat format, const std::string& path,
                int station_number) {
  CloudWriterSpec spec;
  spec.path = path;
  spec.has_intensity = true;
  spec.has_rgb = true;
  PointChunk returns;
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d point = PointAt(scan.grid, i);
    if (point.isZero(0.0)) continue;
    spec.min = spec.min.cwiseMin(point);
    spec.max = spec.max.cwiseMax(point);
    returns.x.push_back(point.x());
    returns.y.push_back(point.y());
    returns.z.push_back(point.z());
    returns.intensity.push_back(scan.grid.intensity[i]);
    returns.rgb.push_back(scan.grid.rgb[i]);
  }
  const auto writer =
      format == CampaignFormat::kLas ? CreateLasWriter(spec) : CreatePlyWriter(spec);
  writer->Write(returns, station_number);
  writer->Finish();
}

void MakeDirectory(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    throw InputError({path.string(), "cannot be made: " + error.message(),
                      "a directory that may be written", ""});
  }
}

void SimulateAndWrite(const Campaign& campaign, std::size_t station,
                      const std::filesystem::path& directory, const ExecutionContext& execution) {
  const std::string name = ScanFileName(campaign.scene, campaign.stations[station].id);
  const StationScan scan = SimulateStation(campaign, station, execution);
  if (campaign.scene.format == CampaignFormat::kPtx) {
    WritePtx(scan, (directory / name).string());
  } else {
    WriteCloud(scan, campaign.scene.format, (directory / name).string(),
               static_cast<int>(station) + 1);
  }
}

}  // namespace

void SimulateCampaign(const std::string& scene_path, const std::string& directory,
                      const ExecutionContext& execution) {
  const Campaign campaign = PrepareCampaign(ReadScene(scene_path));
  const std::filesystem::path root(directory);
  MakeDirectory(root / "scans");
  const std::size_t count = campaign.stations.size();
  const std::size_t batch =
      std::min(kMaxStationsInMemory, static_cast<std::size_t>(execution.threads()));
  for (std::size_t first = 0; first < count; first += batch) {
    execution.Progress("simulate", first, count);
    execution.ParallelFor(std::min(batch, count - first), [&](std::size_t i) {
      SimulateAndWrite(campaign, first + i, root, execution);
    });
  }
  execution.Progress("simulate", count, count);
  const auto targets = MeasureTargets(campaign);
  WriteTextFile((root / "truth.csv").string(), TruthCsv(campaign));
  WriteTextFile((root / "control.csv").string(), ControlCsv(campaign, targets));
  WriteTextFile((root / (campaign.scene.name + ".yaml")).string(), ProjectYaml(campaign, targets));
}

}  // namespace backsight
