#include "stages/surface_distances.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "stages/surface_patch.h"

namespace backsight {
namespace {

constexpr double kSearchEdges = 2.0;     // voxel edges
constexpr double kSameWay = 0.866;       // cos 30 deg
constexpr double kCellM = 1.0;           // of the grid that finds pairs and shared space
constexpr std::size_t kFewestCells = 5;  // shared by a pair that is compared
constexpr std::size_t kMostSamples = 400'000;
constexpr std::size_t kFewestOfPair = 20;
constexpr std::size_t kMostOfPair = 5'000;

/// The cells of the common frame that a cloud's voxels lie in.
struct CloudCells {
  std::vector<std::uint64_t> of_leaf;
  std::vector<std::uint64_t> occupied;  // sorted
};

CloudCells FindCells(const PlacedCloud& cloud) {
  const VoxelLattice grid{kCellM, Eigen::Vector3d::Zero()};
  CloudCells cells;
  for (const Eigen::Vector3d& mean : cloud.surface.model.leaves.means()) {
    cells.of_leaf.push_back(grid.Key(cloud.frame_from_instrument * mean));
  }
  cells.occupied = cells.of_leaf;
  std::sort(cells.occupied.begin(), cells.occupied.end());
  cells.occupied.erase(std::unique(cells.occupied.begin(), cells.occupied.end()),
                       cells.occupied.end());
  return cells;
}

std::vector<std::uint64_t> SharedCells(const CloudCells& a, const CloudCells& b) {
  std::vector<std::uint64_t> shared;
  std::set_intersection(a.occupied.begin(), a.occupied.end(), b.occupied.begin(), b.occupied.end(),
                        std::back_inserter(shared));
  return shared;
}

struct Side {
  const PlacedCloud& cloud;
  const CloudCells& cells;
};

std::optional<DistanceSample> Measure(const PlacedCloud& from, const PlacedCloud& to,
                                      std::size_t leaf, double search_m) {
  const RigidTransform to_from_from =
      to.frame_from_instrument.Inverse() * from.frame_from_instrument;
  const Eigen::Vector3d voxel = to_from_from * from.surface.model.leaves.Mean(leaf);
  const auto nearest = to.index.voxels.Nearest(to.surface.model.leaves.means(), voxel, search_m);
  if (!nearest) return std::nullopt;
  const auto patch = FindPatch(from.surface.model, from.index, leaf);
  if (!patch) return std::nullopt;
  const auto other = FindPatch(to.surface.model, to.index, nearest->voxel);
  if (!other) return std::nullopt;
  const double alike = other->normal.dot(to_from_from.rotation * patch->normal);
  const bool sides_known = from.surface.scanner_credible && to.surface.scanner_credible;
  if ((sides_known ? alike : std::abs(alike)) < kSameWay) return std::nullopt;
  return DistanceSample{from.frame_from_instrument * patch->mean,
                        from.frame_from_instrument.rotation * patch->normal,
                        std::abs(other->normal.dot(to_from_from * patch->mean - other->mean))};
}

/// Adds what at most `most` voxels of one cloud say, evenly chosen among those in shared cells.
void MeasureSide(const Side& from, const Side& to, const std::vector<std::uint64_t>& shared,
                 std::size_t most, double search_m, std::vector<DistanceSample>* samples) {
  std::vector<std::size_t> leaves;
  for (std::size_t i = 0; i < from.cells.of_leaf.size(); ++i) {
    if (std::binary_search(shared.begin(), shared.end(), from.cells.of_leaf[i])) {
      leaves.push_back(i);
    }
  }
  const std::size_t stride = std::max<std::size_t>(1, (leaves.size() + most - 1) / most);
  for (std::size_t i = 0; i < leaves.size(); i += stride) {
    const auto sample = Measure(from.cloud, to.cloud, leaves[i], search_m);
    if (sample) samples->push_back(*sample);
  }
}

/// Pairs in one component that share enough cells; still without samples.
std::vector<PairDistances> OverlappingPairs(std::span<const PlacedCloud> clouds,
                                            const std::vector<CloudCells>& cells,
                                            const ExecutionContext& context) {
  std::vector<PairDistances> pairs;
  for (std::size_t a = 0; a < clouds.size(); ++a) {
    for (std::size_t b = a + 1; b < clouds.size(); ++b) {
      if (clouds[a].component != clouds[b].component) continue;
      pairs.push_back({static_cast<int>(a), static_cast<int>(b), {}});
    }
  }
  std::vector<char> overlaps(pairs.size());
  context.ParallelFor(pairs.size(), [&](std::size_t p) {
    context.CheckStop();
    const auto a = static_cast<std::size_t>(pairs[p].a), b = static_cast<std::size_t>(pairs[p].b);
    overlaps[p] = SharedCells(cells[a], cells[b]).size() >= kFewestCells ? 1 : 0;
  });
  std::vector<PairDistances> overlapping;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (overlaps[p] != 0) overlapping.push_back(std::move(pairs[p]));
  }
  return overlapping;
}

}  // namespace

SurfaceDistances MeasureSurfaceDistances(std::span<const PlacedCloud> clouds,
                                         const ExecutionContext& context) {
  SurfaceDistances result;
  for (const PlacedCloud& cloud : clouds) {
    result.search_m = std::max(result.search_m, kSearchEdges * cloud.surface.model.resolution_m());
  }
  std::vector<CloudCells> cells(clouds.size());
  context.ParallelFor(clouds.size(), [&](std::size_t i) {
    context.CheckStop();
    cells[i] = FindCells(clouds[i]);
  });
  std::vector<PairDistances> pairs = OverlappingPairs(clouds, cells, context);
  const std::size_t most = std::clamp(kMostSamples / std::max<std::size_t>(1, 2 * pairs.size()),
                                      kFewestOfPair, kMostOfPair);
  context.ParallelFor(pairs.size(), [&](std::size_t p) {
    context.CheckStop();
    const auto a = static_cast<std::size_t>(pairs[p].a), b = static_cast<std::size_t>(pairs[p].b);
    const Side side_a{clouds[a], cells[a]}, side_b{clouds[b], cells[b]};
    const std::vector<std::uint64_t> shared = SharedCells(cells[a], cells[b]);
    MeasureSide(side_a, side_b, shared, most, result.search_m, &pairs[p].samples);
    MeasureSide(side_b, side_a, shared, most, result.search_m, &pairs[p].samples);
  });
  std::copy_if(std::make_move_iterator(pairs.begin()), std::make_move_iterator(pairs.end()),
               std::back_inserter(result.pairs),
               [](const PairDistances& pair) { return !pair.samples.empty(); });
  return result;
}

}  // namespace backsight
