#include "stages/merging.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

bool IsMoving(const MergeStation& station, const Eigen::Vector3d& point) {
  return station.is_moving && station.is_moving(point);
}

using PointAction = std::function<void(const PointChunk& chunk, std::size_t i,
                                       const Eigen::Vector3d& frame_point, double range_m)>;

Eigen::Vector3d Placed(const MergeStation& station, const Eigen::Vector3d& point) {
  return station.frame_from_station * (station.scale * point);
}

Eigen::Vector3d Mapped(const MergeOptions& options, const Eigen::Vector3d& placed) {
  return options.map ? options.map(placed) : placed;
}

bool IsWithin(const CropBox& box, const Eigen::Vector3d& point) {
  return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
}

/// Calls `action` for each usable and wanted point of the station within the crop box, and `flush`
/// after each chunk.
void ForEachPoint(const MergeStation& station, const MergeOptions& options,
                  const ExecutionContext& context, const PointAction& action,
                  const std::function<void()>& flush) {
  const std::unique_ptr<ScanReader> reader = station.open();
  PointChunk chunk;
  while (reader->Next(chunk)) {
    context.CheckStop();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d point(chunk.x[i], chunk.y[i], chunk.z[i]);
      const double range = (point - station.range_origin).norm();
      if (range < station.min_range_m || range > station.max_range_m) continue;
      if ((point.array() < station.min.array()).any() ||
          (point.array() > station.max.array()).any()) {
        continue;  // dropped by the ingest as too far from the rest
      }
      if (options.without_moving && IsMoving(station, point)) continue;
      const Eigen::Vector3d placed = Placed(station, point);
      if (options.crop && !IsWithin(*options.crop, Mapped(options, placed))) continue;
      action(chunk, i, placed, range);
    }
    flush();
  }
  if (station.require_unchanged) station.require_unchanged();
}

/// The point in its station's frame; as it was read where the scale is 1.
Eigen::Vector3d Scanned(const MergeStation& station, const PointChunk& chunk, std::size_t i) {
  return station.scale * Eigen::Vector3d(chunk.x[i], chunk.y[i], chunk.z[i]);
}

std::uint8_t ClassOf(const PointChunk& from, std::size_t i, const MergeStation& station) {
  if (IsMoving(station, {from.x[i], from.y[i], from.z[i]})) return kMovingClass;
  return from.classification.empty() ? std::uint8_t{0} : from.classification[i];
}

void Append(const PointChunk& from, std::size_t i, const Eigen::Vector3d& point,
            const MergeStation& station, PointChunk* to) {
  to->x.push_back(point.x());
  to->y.push_back(point.y());
  to->z.push_back(point.z());
  if (station.has_intensity && !from.intensity.empty()) to->intensity.push_back(from.intensity[i]);
  if (station.has_rgb && !from.rgb.empty()) to->rgb.push_back(from.rgb[i]);
  if (station.is_moving || !from.classification.empty()) {
    to->classification.push_back(ClassOf(from, i, station));
  }
  if (!from.gps_time.empty()) to->gps_time.push_back(from.gps_time[i]);
  if (!from.row.empty()) to->row.push_back(from.row[i]);
  if (!from.column.empty()) to->column.push_back(from.column[i]);
}

VoxelLattice LatticeOf(const std::vector<MergeStation>& stations, double thin_m) {
  const CloudBounds bounds = MergedBounds(stations, {});
  const double extent = (bounds.max - bounds.min).maxCoeff();
  if (extent > thin_m * VoxelLattice::kHalfRange) {
    throw InputError({"outputs.merged",
                      fmt::format("thin_m: {} for a cloud of {:.0f} m", thin_m, extent),
                      "a coarser thin_m", ""});
  }
  return {.edge_m = thin_m, .origin = (0.5 * (bounds.min + bounds.max)).array().round()};
}

/// Which points stand for their cells, and how many each station has, once all have been read.
struct ThinnedCloud {
  CloudThinning thinning;
  std::vector<std::uint64_t> points;
};

ThinnedCloud Thin(const std::vector<MergeStation>& stations, const MergeOptions& options,
                  const ExecutionContext& context) {
  ThinnedCloud cloud{{LatticeOf(stations, options.thin_m), options.thinning},
                     std::vector<std::uint64_t>(stations.size())};
  for (std::size_t s = 0; s < stations.size(); ++s) {
    context.Progress("thin", s, stations.size());
    const MergeStation& station = stations[s];
    ForEachPoint(
        station, options, context,
        [&](const PointChunk& chunk, std::size_t i, const Eigen::Vector3d& point, double range) {
          const Eigen::Vector3d scanned(chunk.x[i], chunk.y[i], chunk.z[i]);
          std::optional<double> cos;
          if (station.cos_incidence) cos = station.cos_incidence(scanned);
          constexpr double kLastChoice = 1e9;
          const double factor = IsMoving(station, scanned) ? kLastChoice : 1.0;
          cloud.thinning.Offer({s, cloud.points[s]++}, point,
                               factor * PointUncertainty(range, cos));
        },
        [] {});
  }
  cloud.thinning.Choose(context);
  context.Progress("thin", stations.size(), stations.size());
  return cloud;
}

void RequireSamePoints(const MergeStation& station, std::uint64_t before, std::uint64_t now) {
  if (before == now) return;
  throw InputError(
      {station.open()->info().path, fmt::format("{} usable points when it was read again", now),
       fmt::format("{} as a moment ago", before), "run again when nothing writes the scan"});
}

}  // namespace

CloudBounds MergedBounds(const std::vector<MergeStation>& stations, const MergeOptions& options) {
  CloudBounds bounds{Eigen::Vector3d::Constant(HUGE_VAL), Eigen::Vector3d::Constant(-HUGE_VAL)};
  for (const MergeStation& station : stations) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p((corner & 1) != 0 ? station.max.x() : station.min.x(),
                              (corner & 2) != 0 ? station.max.y() : station.min.y(),
                              (corner & 4) != 0 ? station.max.z() : station.min.z());
      const Eigen::Vector3d output = Mapped(options, Placed(station, p));
      bounds.min = bounds.min.cwiseMin(output);
      bounds.max = bounds.max.cwiseMax(output);
    }
  }
  if (options.map) {
    bounds.min.array() -= 1.0;
    bounds.max.array() += 1.0;
  }
  if (options.crop) {
    for (Eigen::Vector3d* corner : {&bounds.min, &bounds.max}) {
      *corner = corner->cwiseMax(options.crop->min).cwiseMin(options.crop->max);
    }
  }
  return bounds;
}

std::uint64_t MergeClouds(const std::vector<MergeStation>& stations, const MergeOptions& options,
                          CloudWriter& writer, const ExecutionContext& context) {
  std::optional<ThinnedCloud> thinned;
  if (options.thin_m > 0.0) thinned.emplace(Thin(stations, options, context));
  std::uint64_t written = 0;
  PointChunk out;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    context.Progress("merge", s, stations.size());
    const MergeStation& station = stations[s];
    std::uint64_t index = 0;
    ForEachPoint(
        station, options, context,
        [&](const PointChunk& chunk, std::size_t i, const Eigen::Vector3d& point, double) {
          if (thinned && !thinned->thinning.Takes({s, index++})) return;
          Append(chunk, i,
                 options.in_station_frames ? Scanned(station, chunk, i) : Mapped(options, point),
                 station, &out);
        },
        [&] {
          written += out.size();
          writer.Write(out, station.number);
          out.Clear();
        });
    if (thinned) RequireSamePoints(station, thinned->points[s], index);
  }
  context.Progress("merge", stations.size(), stations.size());
  return written;
}

}  // namespace backsight
