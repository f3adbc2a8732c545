#include "stages/ingest.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <numbers>
#include <string>

#include "core/angular_step.h"
#include "core/error.h"
#include "core/voxel_shards.h"
#include "io/scan_stream.h"

namespace backsight {
namespace {

constexpr double kFarFromScanner = 1000.0;  // m; float coordinates would lose digits
constexpr double kWidestPixelDegrees = 5.0;

/// The lattice is centred on the first point, so that scans in large coordinates fit it too, and
/// turned by nothing: the choice does not matter to what is computed from the clusters.
VoxelLattice LatticeAround(const PointChunk& chunk, double edge_m) {
  VoxelLattice lattice{.edge_m = edge_m};
  if (chunk.empty()) return lattice;
  const Eigen::Vector3d first(chunk.x[0], chunk.y[0], chunk.z[0]);
  if (first.norm() > 1e4) lattice.origin = first.array().round();
  return lattice;
}

/// Pixels no smaller than the beams were apart: in smaller ones surfaces that a beam passes at a
/// grazing angle would seem to be missing, and those beyond them to be seen through them.
double PixelDegrees(double step_rad, const IngestOptions& options) {
  const double step_deg = step_rad * 180.0 / std::numbers::pi;
  return std::clamp(step_deg, options.range_image_deg, kWidestPixelDegrees);
}

/// Points beyond the range limits.
struct OutOfRange {
  std::uint64_t nearer = 0;
  std::uint64_t farther = 0;
  double nearest_m = std::numeric_limits<double>::infinity();  // of those that are farther
  double farthest_m = 0.0;

  void AddFarther(double range_m) {
    ++farther;
    nearest_m = std::min(nearest_m, range_m);
    farthest_m = std::max(farthest_m, range_m);
  }
  void Add(const OutOfRange& other) {
    nearer += other.nearer;
    farther += other.farther;
    nearest_m = std::min(nearest_m, other.nearest_m);
    farthest_m = std::max(farthest_m, other.farthest_m);
  }
  std::string Describe(const IngestOptions& options) const {
    std::string text;
    if (nearer > 0) {
      text += fmt::format("; {} are nearer than min_range_m, {:g} m", nearer, options.min_range_m);
    }
    if (farther > 0) {
      text += fmt::format("; {} are farther than max_range_m, {:g} m, at {:.0f} to {:.0f} m",
                          farther, options.max_range_m, nearest_m, farthest_m);
    }
    return text;
  }
};

/// What is known of all points, in whatever order they come.
struct Extremes {
  explicit Extremes(const Eigen::Vector3d& scanner) : step(scanner) {}

  AngularStep step;
  Eigen::Vector3d min = Eigen::Vector3d::Constant(HUGE_VAL);
  Eigen::Vector3d max = Eigen::Vector3d::Constant(-HUGE_VAL);
  std::uint64_t points = 0;
  std::uint64_t outside = 0;  ///< of the lattice
  OutOfRange out;

  void Add(const Extremes& other) {
    step.Add(other.step);
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
    points += other.points;
    outside += other.outside;
    out.Add(other.out);
  }
};

/// A place for chunks on their way into voxels.
struct Slot {
  explicit Slot(const Eigen::Vector3d& scanner) : extremes(scanner) {}

  VoxelShards::Batch batch;
  bool is_placed = false;  ///< the chunk's points are in the batch
  Extremes extremes;       ///< of all chunks that came through here
};

/// One pass over a scan. Points are placed in their voxels by all threads, chunk by chunk, and
/// added voxel by voxel in their order, so that nothing depends on the number of threads.
class Pass {
 public:
  Pass(const Eigen::Vector3d& scanner, const IngestOptions& options,
       const ExecutionContext& context)
      : scanner_(scanner),
        options_(options),
        context_(context),
        slots_(context.StreamSlots(), Slot(scanner)) {}

  void Run(ScanReader& reader) {
    StreamScan(
        reader, slots_.size(), context_,
        [this](std::size_t slot, const PointChunk& points) {
          slots_[slot].is_placed = has_lattice_;  // the first points settle it
          if (slots_[slot].is_placed) Place(points, &slots_[slot]);
        },
        [this](std::size_t slot, const PointChunk& points) {
          if (!has_lattice_ && !points.empty()) Begin(points);
          if (!slots_[slot].is_placed) Place(points, &slots_[slot]);
          if (shards_) shards_->Add(slots_[slot].batch, context_);
        });
  }

  Extremes FindExtremes() const {
    Extremes all(scanner_);
    for (const Slot& slot : slots_) all.Add(slot.extremes);
    return all;
  }
  VoxelLeaves TakeLeaves() { return shards_ ? shards_->Finish() : VoxelLeaves(lattice_); }

 private:
  void Begin(const PointChunk& points) {
    lattice_ = LatticeAround(points, options_.resolution_m);
    shards_.emplace(lattice_);
    has_lattice_ = true;
  }

  void Place(const PointChunk& chunk, Slot* slot) const {
    Extremes& all = slot->extremes;
    slot->batch.Clear();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d point(chunk.x[i], chunk.y[i], chunk.z[i]);
      const double range = (point - scanner_).norm();
      if (range < options_.min_range_m) {
        ++all.out.nearer;
      } else if (range > options_.max_range_m) {
        all.out.AddFarther(range);
      } else if (!lattice_.Contains(point)) {
        ++all.outside;
      } else {
        slot->batch.Add(lattice_, point);
        all.step.Add(point);
        all.min = all.min.cwiseMin(point);
        all.max = all.max.cwiseMax(point);
        ++all.points;
      }
    }
    slot->batch.Sort();
  }

  Eigen::Vector3d scanner_;
  const IngestOptions& options_;
  const ExecutionContext& context_;
  VoxelLattice lattice_;
  std::atomic<bool> has_lattice_ = false;
  std::optional<VoxelShards> shards_;
  std::vector<Slot> slots_;
};

InputError TooFewLeaves(const IngestResult& result, const OutOfRange& out, std::size_t fewest,
                        const std::string& path, bool origin_given, const IngestOptions& options) {
  const bool elsewhere = !origin_given && out.farther > out.nearer;
  return InputError(
      {path,
       fmt::format("only {} of {} records are usable points, in {} voxels of {} m{}",
                   result.model.points, result.tally.records, result.model.leaves.size(),
                   options.resolution_m, out.Describe(options)),
       fmt::format("at least {} occupied voxels", fewest),
       elsewhere ? "give scanner_origin_m if the scan is not in its scanner's frame, as in map "
                   "coordinates, and check that it counts in metres"
                 : "check the file, its units (metres) and the range limits"});
}

/// From station to instrument coordinates; the range image is made of the latter.
void MoveToInstrument(double pixel_deg, StationModel* model) {
  model->leaves.Translate(-model->scanner_origin);
  model->range_image = ImageOf(model->leaves, pixel_deg);
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, IngestOptions& options) {
  visitor.Real("resolution_m", options.resolution_m, "m", 0.005, 1.0,
               "edge of the voxels that stand for the scan; 0.1 outdoors, 0.05 indoors");
  visitor.Real("min_range_m", options.min_range_m, "m", 0.0, 100.0,
               "nearer returns are dropped (instrument, tripod, operator)");
  visitor.Real("max_range_m", options.max_range_m, "m", 1.0, 10000.0,
               "farther returns are dropped");
  visitor.Real("range_image_deg", options.range_image_deg, "deg", 0.05, kWidestPixelDegrees,
               "least pixel of the spherical image of what the scanner saw; wider where its beams "
               "were farther apart");
}

IngestResult IngestScan(const std::string& station_id, ScanReader& reader,
                        const std::optional<Eigen::Vector3d>& scanner_origin,
                        const IngestOptions& options, const ExecutionContext& context) {
  IngestResult result;
  Pass pass(scanner_origin.value_or(Eigen::Vector3d::Zero()), options, context);
  pass.Run(reader);
  const Extremes extremes = pass.FindExtremes();
  const OutOfRange& out = extremes.out;
  result.tally = reader.tally();
  result.out_of_range = out.nearer + out.farther;
  result.model.id = station_id;
  result.model.leaves = pass.TakeLeaves();
  result.model.min = extremes.min;
  result.model.max = extremes.max;
  result.model.points = extremes.points;
  if (extremes.outside > 0) {
    result.notes.push_back(fmt::format("{} points farther than {:.0f} m from the rest were dropped",
                                       extremes.outside,
                                       options.resolution_m * VoxelLattice::kHalfRange));
  }
  constexpr std::size_t kFewestLeaves = 100;
  if (result.model.leaves.size() < kFewestLeaves) {
    throw TooFewLeaves(result, out, kFewestLeaves, reader.info().path, scanner_origin.has_value(),
                       options);
  }

  result.model.scanner_origin = scanner_origin.value_or(Eigen::Vector3d::Zero());
  if (scanner_origin) result.model.scanner_place = ScannerPlace::kGiven;
  const Eigen::Vector3d center = 0.5 * (result.model.min + result.model.max);
  if (!scanner_origin && center.norm() > kFarFromScanner) {
    result.model.scanner_origin = center.array().round();
    result.notes.push_back(
        fmt::format("the cloud's centre is {:.0f} m from (0, 0, 0), so the scan is not in its "
                    "scanner's frame; give scanner_origin_m if you know it",
                    center.norm()));
  }
  MoveToInstrument(PixelDegrees(extremes.step.Radians(), options), &result.model);
  return result;
}

}  // namespace backsight
