#include "stages/merging.h"

#include <fmt/format.h>

#include <unordered_map>

#include "core/error.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// The point that stands for each cell: the one measured from the shortest range.
class Thinning {
 public:
  explicit Thinning(const VoxelLattice& lattice) : lattice_(lattice) {}

  void Offer(const Eigen::Vector3d& point, double range_m) {
    const auto range = static_cast<float>(range_m);
    const auto [entry, is_new] = nearest_.try_emplace(lattice_.Key(point), range);
    if (!is_new && range < entry->second) entry->second = range;
  }

  /// True once per cell, for its first point of the shortest range.
  bool Take(const Eigen::Vector3d& point, double range_m) {
    float& nearest = nearest_.at(lattice_.Key(point));
    if (static_cast<float>(range_m) != nearest) return false;
    nearest = -1.0F;
    return true;
  }

 private:
  VoxelLattice lattice_;
  std::unordered_map<std::uint64_t, float> nearest_;
};

using PointAction = std::function<void(const PointChunk& chunk, std::size_t i,
                                       const Eigen::Vector3d& frame_point, double range_m)>;

Eigen::Vector3d Placed(const MergeStation& station, const Eigen::Vector3d& point) {
  return station.frame_from_station * (station.scale * point);
}

/// Calls `action` for each usable point of the station, and `flush` after each chunk.
void ForEachPoint(const MergeStation& station, const ExecutionContext& context,
                  const PointAction& action, const std::function<void()>& flush) {
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
      action(chunk, i, Placed(station, point), range);
    }
    flush();
  }
}

void Append(const PointChunk& from, std::size_t i, const Eigen::Vector3d& point,
            const MergeStation& station, PointChunk* to) {
  to->x.push_back(point.x());
  to->y.push_back(point.y());
  to->z.push_back(point.z());
  if (station.has_intensity && !from.intensity.empty()) to->intensity.push_back(from.intensity[i]);
  if (station.has_rgb && !from.rgb.empty()) to->rgb.push_back(from.rgb[i]);
  if (!from.classification.empty()) to->classification.push_back(from.classification[i]);
  if (!from.gps_time.empty()) to->gps_time.push_back(from.gps_time[i]);
}

}  // namespace

CloudBounds MergedBounds(const std::vector<MergeStation>& stations, const OutputMap& map) {
  CloudBounds bounds{Eigen::Vector3d::Constant(HUGE_VAL), Eigen::Vector3d::Constant(-HUGE_VAL)};
  for (const MergeStation& station : stations) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p((corner & 1) != 0 ? station.max.x() : station.min.x(),
                              (corner & 2) != 0 ? station.max.y() : station.min.y(),
                              (corner & 4) != 0 ? station.max.z() : station.min.z());
      const Eigen::Vector3d placed = Placed(station, p);
      const Eigen::Vector3d output = map ? map(placed) : placed;
      bounds.min = bounds.min.cwiseMin(output);
      bounds.max = bounds.max.cwiseMax(output);
    }
  }
  if (map) {
    bounds.min.array() -= 1.0;
    bounds.max.array() += 1.0;
  }
  return bounds;
}

std::uint64_t MergeClouds(const std::vector<MergeStation>& stations, const OutputMap& map,
                          double thin_m, CloudWriter& writer, const ExecutionContext& context) {
  const bool thin = thin_m > 0.0;
  const CloudBounds bounds = MergedBounds(stations, {});
  if (thin && (bounds.max - bounds.min).maxCoeff() > thin_m * VoxelLattice::kHalfRange) {
    throw InputError({"outputs.merged",
                      fmt::format("thin_m: {} for a cloud of {:.0f} m", thin_m,
                                  (bounds.max - bounds.min).maxCoeff()),
                      "a coarser thin_m", ""});
  }
  Thinning thinning(
      {.edge_m = thin ? thin_m : 1.0, .origin = (0.5 * (bounds.min + bounds.max)).array().round()});
  if (thin) {
    for (const MergeStation& station : stations) {
      ForEachPoint(
          station, context,
          [&](const PointChunk&, std::size_t, const Eigen::Vector3d& point, double range) {
            thinning.Offer(point, range);
          },
          [] {});
    }
  }
  std::uint64_t written = 0;
  PointChunk out;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    context.Progress("merge", s, stations.size());
    const MergeStation& station = stations[s];
    ForEachPoint(
        station, context,
        [&](const PointChunk& chunk, std::size_t i, const Eigen::Vector3d& point, double range) {
          if (thin && !thinning.Take(point, range)) return;
          Append(chunk, i, map ? map(point) : point, station, &out);
        },
        [&] {
          written += out.size();
          writer.Write(out, station.number);
          out.Clear();
        });
  }
  context.Progress("merge", stations.size(), stations.size());
  return written;
}

}  // namespace backsight
