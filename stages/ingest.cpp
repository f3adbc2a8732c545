#include "stages/ingest.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>

#include "core/angular_step.h"
#include "core/error.h"

namespace backsight {
namespace {

constexpr double kFarFromScanner = 1000.0;  // m; float coordinates would lose digits
constexpr double kWidestPixelDegrees = 5.0;

/// Collects everything that can be known while the points stream by.
class Pass {
 public:
  Pass(const VoxelLattice& lattice, const Eigen::Vector3d& scanner)
      : lattice_(lattice), clusterer_(lattice), step_(scanner) {}

  void Add(const Eigen::Vector3d& point) {
    if (!lattice_.Contains(point)) {
      ++outside_;
      return;
    }
    clusterer_.Add(point);
    step_.Add(point);
    min_ = min_.cwiseMin(point);
    max_ = max_.cwiseMax(point);
    ++points_;
  }

  StationModel Finish() const {
    StationModel model;
    model.leaves = clusterer_.Finish();
    model.lattice = lattice_;
    model.min = min_;
    model.max = max_;
    model.points = points_;
    return model;
  }
  std::uint64_t outside() const { return outside_; }
  double step_rad() const { return step_.Radians(); }

 private:
  VoxelLattice lattice_;
  VoxelClusterer clusterer_;
  AngularStep step_;
  Eigen::Vector3d min_ = Eigen::Vector3d::Constant(HUGE_VAL);
  Eigen::Vector3d max_ = Eigen::Vector3d::Constant(-HUGE_VAL);
  std::uint64_t points_ = 0;
  std::uint64_t outside_ = 0;
};

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
  model->lattice.origin -= model->scanner_origin;
  for (VoxelLeaf& leaf : model->leaves) leaf.cluster.mean -= model->scanner_origin;
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
  std::optional<Pass> pass;
  PointChunk chunk;
  OutOfRange out;
  const Eigen::Vector3d origin = scanner_origin.value_or(Eigen::Vector3d::Zero());
  while (reader.Next(chunk)) {
    context.CheckStop();
    if (!pass && !chunk.empty()) {
      pass.emplace(LatticeAround(chunk, options.resolution_m), origin);
    }
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d point(chunk.x[i], chunk.y[i], chunk.z[i]);
      const double range = (point - origin).norm();
      if (range < options.min_range_m) {
        ++out.nearer;
      } else if (range > options.max_range_m) {
        out.AddFarther(range);
      } else {
        pass->Add(point);
      }
    }
  }
  result.tally = reader.tally();
  result.out_of_range = out.nearer + out.farther;
  if (pass) result.model = pass->Finish();
  result.model.id = station_id;
  if (pass && pass->outside() > 0) {
    result.notes.push_back(fmt::format("{} points farther than {:.0f} m from the rest were dropped",
                                       pass->outside(),
                                       options.resolution_m * VoxelLattice::kHalfRange));
  }
  constexpr std::size_t kFewestLeaves = 100;
  if (result.model.leaves.size() < kFewestLeaves) {
    throw TooFewLeaves(result, out, kFewestLeaves, reader.info().path, scanner_origin.has_value(),
                       options);
  }

  result.model.scanner_origin = scanner_origin.value_or(Eigen::Vector3d::Zero());
  result.model.scanner_known = scanner_origin.has_value();
  const Eigen::Vector3d center = 0.5 * (result.model.min + result.model.max);
  if (!scanner_origin && center.norm() > kFarFromScanner) {
    result.model.scanner_origin = center.array().round();
    result.notes.push_back(
        fmt::format("the cloud's centre is {:.0f} m from (0, 0, 0), so the scan is not in its "
                    "scanner's frame; give scanner_origin_m if you know it",
                    center.norm()));
  }
  MoveToInstrument(PixelDegrees(pass->step_rad(), options), &result.model);
  return result;
}

}  // namespace backsight
