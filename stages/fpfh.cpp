#include "stages/fpfh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "stages/pair_histogram.h"

namespace backsight {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBins = PairHistogram::kBins;

/// A neighbour of a key point.
struct WeightedPlace {
  std::uint32_t place = 0;
  float weight = 0.0F;  // 1 / squared distance
};

/// Points with their normals by place, padded. Those without a normal lie far away.
using PointColumns = std::array<std::vector<float>, 6>;

PointColumns MakeColumns(const LeafGrid& grid, std::span<const Eigen::Vector3f> normals) {
  PointColumns columns{grid.Axis(0), grid.Axis(1), grid.Axis(2)};
  for (std::size_t axis = 3; axis < 6; ++axis) columns[axis].resize(columns[0].size(), 0.0F);
  for (std::size_t place = 0; place < grid.size(); ++place) {
    const Eigen::Vector3f& normal = normals[grid.LeafAt(place)];
    if (!normal.allFinite()) {
      columns[0][place] = LeafGrid::kFarAway;
      continue;
    }
    columns[3][place] = normal.x();
    columns[4][place] = normal.y();
    columns[5][place] = normal.z();
  }
  return columns;
}

/// Neighbours with a normal of every key point, by `slot_at` (key point at a place, kNone if none).
std::vector<std::vector<WeightedPlace>> NeighborsOfKeypoints(
    const LeafGrid& grid, const PointColumns& columns, const std::vector<std::uint32_t>& slot_at,
    std::size_t keypoints, double radius_m, const ExecutionContext& context) {
  std::vector<std::uint32_t> places(grid.size() + LeafGrid::kPadding);
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
          search.Gather(places, kNone, &candidates);
          entered = true;
        }
        const auto around = search.Around(place);
        const auto squared = search.SquaredDistances(place);
        auto& found = neighbors[slot_at[place]];
        found.reserve(around.size());
        for (const std::uint32_t j : around) {
          if (squared[j] == 0.0F || columns[0][candidates[j]] == LeafGrid::kFarAway) continue;
          found.push_back({candidates[j], 1.0F / squared[j]});
        }
      }
    }
  });
  return neighbors;
}

/// SPFH of a point as it was counted: 72 bytes, its bins would take 132. Beyond 65535 neighbours
/// counts lose their last digits.
struct SimpleHistogram {
  std::array<std::uint16_t, PairHistogram::kBlocks * kBins> counts{};
  float unit = 0.0F;  // of a count; each block sums to 100 if all pairs have angles

  SimpleHistogram() = default;
  explicit SimpleHistogram(const PairHistogram& histogram) {
    // The point itself is among its neighbours and pairs with none.
    if (histogram.neighbors < 2) return;
    const int digits = std::max(static_cast<int>(std::bit_width(histogram.neighbors)) - 16, 0);
    unit = std::ldexp(100.0F / static_cast<float>(histogram.neighbors - 1), digits);
    for (std::size_t b = 0; b < counts.size(); ++b) {
      counts[b] = static_cast<std::uint16_t>(histogram.counts[b] >> digits);
    }
  }
};

/// SPFH of the points of one cell after another.
class SpfhComputer {
 public:
  SpfhComputer(const LeafGrid& grid, const PointColumns& columns, double radius_m)
      : columns_(columns), search_(grid, radius_m) {}

  void EnterCell(std::size_t cell) {
    search_.EnterCell(cell);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      search_.Gather(columns_[c], LeafGrid::kFarAway, &candidates_[c]);
    }
  }

  /// The point must have a normal.
  SimpleHistogram Compute(std::size_t place) const {
    const auto& [x, y, z, nx, ny, nz] = columns_;
    return SimpleHistogram(CountPairs(
        {x[place], y[place], z[place], nx[place], ny[place], nz[place]},
        {candidates_[0].data(), candidates_[1].data(), candidates_[2].data(), candidates_[3].data(),
         candidates_[4].data(), candidates_[5].data(), search_.padded_count()},
        search_.squared_radius()));
  }

 private:
  const PointColumns& columns_;
  BallSearch search_;
  PointColumns candidates_;
};

struct SimpleHistograms {
  std::vector<std::uint32_t> row_at;  // by place; kNone where not needed
  std::vector<SimpleHistogram> rows;
};

SimpleHistograms ComputeNeeded(const LeafGrid& grid, const PointColumns& columns,
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
    SpfhComputer computer(grid, columns, radius_m);
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
    const SimpleHistogram& row = spfh.rows[spfh.row_at[neighbor.place]];
    for (std::size_t b = 0; b < sum.size(); ++b) {
      sum[b] += neighbor.weight * (row.unit * static_cast<float>(row.counts[b]));
    }
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
  const PointColumns columns = MakeColumns(grid, normals);
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
