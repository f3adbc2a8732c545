#include "stages/merging.h"

#include <fmt/format.h>

#include <numeric>

#include "core/error.h"
#include "core/voxel_grid.h"
#include "io/scan_stream.h"

namespace backsight {
namespace {

bool IsMoving(const MergeStation& station, const Eigen::Vector3d& point) {
  return station.is_moving && station.is_moving(point);
}

/// A chunk on its way from the scan to the cloud.
struct Passage {
  const PointChunk* scanned = nullptr;
  std::vector<std::uint32_t> wanted;    ///< places in *scanned
  std::vector<Eigen::Vector3d> placed;  ///< of these, in the shared frame
  PointChunk out;
};

Eigen::Vector3d PointAt(const PointChunk& chunk, std::size_t i) {
  return {chunk.x[i], chunk.y[i], chunk.z[i]};
}

Eigen::Vector3d Placed(const MergeStation& station, const Eigen::Vector3d& point) {
  return station.frame_from_station * (station.scale * point);
}

std::vector<Eigen::Vector3d> Mapped(const MergeOptions& options,
                                    std::vector<Eigen::Vector3d> placed) {
  if (options.map) options.map(placed);
  return placed;
}

bool IsWithin(const CropBox& box, const Eigen::Vector3d& point) {
  return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
}

bool IsUsable(const MergeStation& station, const MergeOptions& options,
              const Eigen::Vector3d& point) {
  const double range = (point - station.range_origin).norm();
  if (range < station.min_range_m || range > station.max_range_m) return false;
  if ((point.array() < station.min.array()).any() || (point.array() > station.max.array()).any()) {
    return false;  // dropped by the ingest as too far from the rest
  }
  return !options.without_moving || !IsMoving(station, point);
}

/// Leaves the wanted points that lie within the crop box.
void Crop(const MergeOptions& options, Passage* passage) {
  const std::vector<Eigen::Vector3d> mapped = Mapped(options, passage->placed);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < mapped.size(); ++k) {
    if (!IsWithin(*options.crop, mapped[k])) continue;
    passage->wanted[kept] = passage->wanted[k];
    passage->placed[kept] = passage->placed[k];
    ++kept;
  }
  passage->wanted.resize(kept);
  passage->placed.resize(kept);
}

/// Finds the points of the chunk that are usable and wanted.
void Select(const MergeStation& station, const MergeOptions& options, Passage* passage) {
  passage->wanted.clear();
  passage->placed.clear();
  for (std::uint32_t i = 0; i < passage->scanned->size(); ++i) {
    const Eigen::Vector3d point = PointAt(*passage->scanned, i);
    if (!IsUsable(station, options, point)) continue;
    passage->wanted.push_back(i);
    passage->placed.push_back(Placed(station, point));
  }
  if (options.crop) Crop(options, passage);
}

/// Passes all chunks of the station's scan through Select and `work`, on all threads, and hands
/// them to `take` in their order.
void ForEachChunk(const MergeStation& station, const MergeOptions& options,
                  const ExecutionContext& context, const std::function<void(Passage*)>& work,
                  const std::function<void(Passage*)>& take) {
  const std::unique_ptr<ScanReader> reader = station.open();
  std::vector<Passage> passages(context.StreamSlots());
  StreamScan(
      *reader, passages.size(), context,
      [&](std::size_t slot, const PointChunk& points) {
        passages[slot].scanned = &points;
        Select(station, options, &passages[slot]);
        work(&passages[slot]);
      },
      [&](std::size_t slot, const PointChunk&) { take(&passages[slot]); });
  if (station.require_unchanged) station.require_unchanged();
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

/// Makes the points of the cloud from those wanted points, by their places in `wanted`, that are to
/// be in it.
void Fill(const MergeStation& station, const MergeOptions& options,
          const std::vector<std::uint32_t>& chosen, Passage* passage) {
  const PointChunk& from = *passage->scanned;
  std::vector<Eigen::Vector3d> points;
  points.reserve(chosen.size());
  for (const std::uint32_t k : chosen) {
    // In its station's frame a point is as it was read, but for the scale.
    points.push_back(options.in_station_frames ? station.scale * PointAt(from, passage->wanted[k])
                                               : passage->placed[k]);
  }
  if (!options.in_station_frames) points = Mapped(options, std::move(points));
  passage->out.Clear();
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Append(from, passage->wanted[chosen[k]], points[k], station, &passage->out);
  }
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

double UncertaintyOf(const MergeStation& station, const Eigen::Vector3d& scanned) {
  constexpr double kLastChoice = 1e9;
  const double range_m = (scanned - station.range_origin).norm();
  std::optional<double> cos;
  if (station.cos_incidence) cos = station.cos_incidence(scanned);
  return (IsMoving(station, scanned) ? kLastChoice : 1.0) * PointUncertainty(range_m, cos);
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
    ForEachChunk(
        station, options, context, [](Passage*) {},
        [&](const Passage* passage) {
          for (std::size_t k = 0; k < passage->wanted.size(); ++k) {
            const Eigen::Vector3d scanned = PointAt(*passage->scanned, passage->wanted[k]);
            cloud.thinning.Offer({s, cloud.points[s]++}, passage->placed[k],
                                 UncertaintyOf(station, scanned));
          }
        });
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

/// Returns the number of points written.
std::uint64_t WriteAll(const MergeStation& station, const MergeOptions& options,
                       CloudWriter& writer, const ExecutionContext& context) {
  std::uint64_t written = 0;
  ForEachChunk(
      station, options, context,
      [&](Passage* passage) {
        std::vector<std::uint32_t> all(passage->wanted.size());
        std::iota(all.begin(), all.end(), 0U);
        Fill(station, options, all, passage);
      },
      [&](const Passage* passage) {
        written += passage->out.size();
        writer.Write(passage->out, station.number);
      });
  return written;
}

/// The same of the points of station `s` that stand for their cells.
std::uint64_t WriteChosen(const MergeStation& station, std::size_t s, const MergeOptions& options,
                          ThinnedCloud* cloud, CloudWriter& writer,
                          const ExecutionContext& context) {
  std::uint64_t written = 0;
  std::uint64_t index = 0;
  ForEachChunk(
      station, options, context, [](Passage*) {},
      [&](Passage* passage) {
        std::vector<std::uint32_t> chosen;
        for (std::uint32_t k = 0; k < passage->wanted.size(); ++k) {
          if (cloud->thinning.Takes({s, index++})) chosen.push_back(k);
        }
        Fill(station, options, chosen, passage);
        written += passage->out.size();
        writer.Write(passage->out, station.number);
      });
  RequireSamePoints(station, cloud->points[s], index);
  return written;
}

}  // namespace

CloudBounds MergedBounds(const std::vector<MergeStation>& stations, const MergeOptions& options) {
  CloudBounds bounds{Eigen::Vector3d::Constant(HUGE_VAL), Eigen::Vector3d::Constant(-HUGE_VAL)};
  for (const MergeStation& station : stations) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p((corner & 1) != 0 ? station.max.x() : station.min.x(),
                              (corner & 2) != 0 ? station.max.y() : station.min.y(),
                              (corner & 4) != 0 ? station.max.z() : station.min.z());
      const Eigen::Vector3d output = Mapped(options, {Placed(station, p)}).front();
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
  for (std::size_t s = 0; s < stations.size(); ++s) {
    context.Progress("merge", s, stations.size());
    written += thinned ? WriteChosen(stations[s], s, options, &*thinned, writer, context)
                       : WriteAll(stations[s], options, writer, context);
  }
  context.Progress("merge", stations.size(), stations.size());
  return written;
}

}  // namespace backsight
