#include "stages/fpfh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "stages/pair_bins.h"

namespace backsight {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBins = PairBins::kBins;

/// A neighbour of a key point.
struct WeightedPlace {
  std::uint32_t place = 0;
  float weight = 0.0F;  // 1 / squared distance
};

/// Normals by place, as columns; `has` tells which are defined.
struct NormalColumns {
  std::vector<float> x, y, z;
  std::vector<std::uint8_t> has;
};

NormalColumns MakeColumns(const LeafGrid& grid, std::span<const Eigen::Vector3f> normals) {
  NormalColumns columns;
  for (std::size_t place = 0; place < grid.size(); ++place) {
    const Eigen::Vector3f& normal = normals[grid.LeafAt(place)];
    columns.x.push_back(normal.x());
    columns.y.push_back(normal.y());
    columns.z.push_back(normal.z());
    columns.has.push_back(normal.allFinite() ? 1 : 0);
  }
  return columns;
}

/// Neighbours with a normal of every key point, by `slot_at` (key point at a place, kNone if none).
std::vector<std::vector<WeightedPlace>> NeighborsOfKeypoints(
    const LeafGrid& grid, const NormalColumns& normals, const std::vector<std::uint32_t>& slot_at,
    std::size_t keypoints, double radius_m, const ExecutionContext& context) {
  std::vector<std::uint32_t> places(grid.size());
  std::iota(places.begin(), places.end(), 0U);
  std::vector<std::vector<WeightedPlace>> neighbors(keypoints);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, radius_m);
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      const LeafGrid::Range range = grid.Cell(cell);
      bool entered = false;
      for (std::uint32_t place = range.begin; place < range.end; ++place) {
        if (slot_at[place] == kNone) continue;
        if (!entered) {
          search.EnterCell(cell);
          search.Gather(places, &candidates);
          entered = true;
        }
        const auto squared = search.SquaredDistances(place);
        for (const std::uint32_t j : search.Around(place)) {
          if (squared[j] == 0.0F || normals.has[candidates[j]] == 0) continue;
          neighbors[slot_at[place]].push_back({candidates[j], 1.0F / squared[j]});
        }
      }
    }
  });
  return neighbors;
}

/// Counts pair features. Neighbouring pairs often fall into one bin; two sets of counters keep an
/// increment from waiting for the one before.
class PairHistogram {
 public:
  void Add(const PairBins& bins, std::size_t count) {
    std::size_t k = 0;
    for (; k + 1 < count; k += 2) {
      Count(bins, k, &counts_[0]);
      Count(bins, k + 1, &counts_[1]);
    }
    if (k < count) Count(bins, k, &counts_[0]);
  }

  /// The counts times `unit`.
  FpfhDescriptor Scaled(float unit) const {
    FpfhDescriptor scaled;
    for (std::size_t b = 0; b < scaled.size(); ++b) {
      const std::size_t slot = b / kBins * kStride + b % kBins;
      scaled[b] = unit * static_cast<float>(counts_[0][slot] + counts_[1][slot]);
    }
    return scaled;
  }

 private:
  static constexpr std::size_t kStride = 16;  // room for kNoBin
  using Counts = std::array<std::uint32_t, 3 * kStride>;

  static void Count(const PairBins& bins, std::size_t k, Counts* counts) {
    ++(*counts)[static_cast<std::size_t>(bins.f1[k])];
    ++(*counts)[kStride + static_cast<std::size_t>(bins.f2[k])];
    ++(*counts)[2 * kStride + static_cast<std::size_t>(bins.f3[k])];
  }

  std::array<Counts, 2> counts_{};
};

/// Simple point feature histograms of one cell's points after another.
class SpfhComputer {
 public:
  SpfhComputer(const LeafGrid& grid, const NormalColumns& normals, double radius_m)
      : grid_(grid), normals_(normals), search_(grid, radius_m) {}

  void EnterCell(std::size_t cell) {
    search_.EnterCell(cell);
    search_.Gather(normals_.x, &nx_);
    search_.Gather(normals_.y, &ny_);
    search_.Gather(normals_.z, &nz_);
    search_.Gather(normals_.has, &has_);
  }

  /// Each block sums to 100 if all pairs have angles. The point must have a normal.
  FpfhDescriptor Compute(std::size_t place) {
    const OrientedPoint point{grid_.Axis(0)[place], grid_.Axis(1)[place], grid_.Axis(2)[place],
                              normals_.x[place],    normals_.y[place],    normals_.z[place]};
    PairHistogram histogram;
    std::size_t neighbors = 0;
    std::size_t filled = 0;
    const auto flush = [&] {
      ComputePairBins(point, block_, filled, &bins_);
      histogram.Add(bins_, filled);
      neighbors += filled;
      filled = 0;
    };
    for (const std::uint32_t j : search_.Around(place)) {
      block_.x[filled] = search_.Axis(0)[j];
      block_.y[filled] = search_.Axis(1)[j];
      block_.z[filled] = search_.Axis(2)[j];
      block_.nx[filled] = nx_[j];
      block_.ny[filled] = ny_[j];
      block_.nz[filled] = nz_[j];
      filled += has_[j];  // overwritten by the next unless it has a normal
      if (filled == OrientedBlock::kSize) flush();
    }
    flush();
    // The point itself is among its neighbours and pairs with none.
    return histogram.Scaled(neighbors > 1 ? 100.0F / static_cast<float>(neighbors - 1) : 0.0F);
  }

 private:
  const LeafGrid& grid_;
  const NormalColumns& normals_;
  BallSearch search_;
  std::vector<float> nx_, ny_, nz_;
  std::vector<std::uint8_t> has_;
  OrientedBlock block_;
  PairBins bins_;
};

struct SimpleHistograms {
  std::vector<std::uint32_t> row_at;  // by place; kNone where not needed
  std::vector<FpfhDescriptor> rows;
};

SimpleHistograms ComputeNeeded(const LeafGrid& grid, const NormalColumns& normals,
                               const std::vector<std::vector<WeightedPlace>>& needed,
                               double radius_m, const ExecutionContext& context) {
  SimpleHistograms spfh;
  spfh.row_at.assign(grid.size(), kNone);
  for (const auto& neighbors : needed) {
    for (const WeightedPlace& neighbor : neighbors) spfh.row_at[neighbor.place] = 0;
  }
  std::uint32_t rows = 0;
  for (std::uint32_t& row : spfh.row_at) {
    if (row != kNone) row = rows++;
  }
  spfh.rows.resize(rows);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    SpfhComputer computer(grid, normals, radius_m);
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      const LeafGrid::Range range = grid.Cell(cell);
      bool entered = false;
      for (std::uint32_t place = range.begin; place < range.end; ++place) {
        if (spfh.row_at[place] == kNone) continue;
        if (!entered) computer.EnterCell(cell);
        entered = true;
        spfh.rows[spfh.row_at[place]] = computer.Compute(place);
      }
    }
  });
  return spfh;
}

FpfhDescriptor Combine(const SimpleHistograms& spfh, const std::vector<WeightedPlace>& neighbors) {
  FpfhDescriptor sum{};
  for (const WeightedPlace& neighbor : neighbors) {
    const FpfhDescriptor& row = spfh.rows[spfh.row_at[neighbor.place]];
    for (std::size_t b = 0; b < sum.size(); ++b) sum[b] += neighbor.weight * row[b];
  }
  for (auto block = sum.begin(); block != sum.end(); block += kBins) {
    const float total = std::accumulate(block, block + kBins, 0.0F);
    // Nothing counted: 0 / 0, the NaN that says so.
    for (auto bin = block; bin != block + kBins; ++bin) *bin *= 100.0F / total;
  }
  return sum;
}

}  // namespace

std::vector<FpfhDescriptor> ComputeFpfh(const LeafGrid& grid,
                                        std::span<const Eigen::Vector3f> normals,
                                        std::span<const std::uint32_t> keypoints, double radius_m,
                                        const ExecutionContext& context) {
  std::vector<std::uint32_t> slot_of_leaf(grid.size(), kNone);
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    slot_of_leaf[keypoints[k]] = static_cast<std::uint32_t>(k);
  }
  std::vector<std::uint32_t> slot_at(grid.size());
  for (std::size_t place = 0; place < grid.size(); ++place) {
    slot_at[place] = slot_of_leaf[grid.LeafAt(place)];
  }
  const NormalColumns columns = MakeColumns(grid, normals);
  const auto neighbors =
      NeighborsOfKeypoints(grid, columns, slot_at, keypoints.size(), radius_m, context);
  context.CheckStop();
  const SimpleHistograms spfh = ComputeNeeded(grid, columns, neighbors, radius_m, context);
  context.CheckStop();
  std::vector<FpfhDescriptor> descriptors(keypoints.size());
  context.ParallelFor(
      keypoints.size(), [&](std::size_t k) { descriptors[k] = Combine(spfh, neighbors[k]); }, 64);
  return descriptors;
}

}  // namespace backsight
