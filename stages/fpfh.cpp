#include "stages/fpfh.h"

#include <algorithm>
#include <array>
#include <atomic>
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
class OrientedPlaces {
 public:
  OrientedPlaces(const LeafGrid& grid, std::span<const Eigen::Vector3f> normals)
      : grid_(grid), x_(grid.Axis(0)) {
    for (std::vector<float>& column : normals_) column.resize(x_.size(), 0.0F);
    for (std::size_t place = 0; place < grid.size(); ++place) {
      const Eigen::Vector3f& normal = normals[grid.LeafAt(place)];
      if (!normal.allFinite()) {
        x_[place] = LeafGrid::kFarAway;
        continue;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        normals_[axis][place] = normal[static_cast<Eigen::Index>(axis)];
      }
    }
  }

  static constexpr std::size_t kColumns = 6;  // x, y, z and the normal's
  const std::vector<float>& Column(std::size_t c) const {
    if (c == 0) return x_;
    return c < 3 ? grid_.Axis(c) : normals_[c - 3];
  }
  bool HasNormal(std::size_t place) const { return x_[place] != LeafGrid::kFarAway; }

 private:
  const LeafGrid& grid_;
  std::vector<float> x_;
  std::array<std::vector<float>, 3> normals_;
};

/// The key points by place; kNone where there is none.
std::vector<std::uint32_t> KeypointsByPlace(const LeafGrid& grid,
                                            std::span<const std::uint32_t> keypoints) {
  std::vector<std::uint32_t> of_leaf(grid.size(), kNone);
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    of_leaf[keypoints[k]] = static_cast<std::uint32_t>(k);
  }
  std::vector<std::uint32_t> by_place(grid.size());
  for (std::size_t place = 0; place < grid.size(); ++place) {
    by_place[place] = of_leaf[grid.LeafAt(place)];
  }
  return by_place;
}

/// Finds the neighbours of key points that have a normal. Finding them twice takes less than to
/// remember them.
class KeypointNeighbors {
 public:
  /// `at`: the key points by place. All must outlive it.
  KeypointNeighbors(const LeafGrid& grid, const OrientedPlaces& oriented,
                    const std::vector<std::uint32_t>& at, double radius_m)
      : grid_(grid),
        oriented_(oriented),
        at_(at),
        radius_m_(radius_m),
        places_(grid.size() + LeafGrid::kPadding) {
    std::iota(places_.begin(), places_.end(), 0U);
  }

  /// Calls use(keypoint, neighbors) for every key point, from several threads.
  template <class Use>
  void ForAll(const ExecutionContext& context, Use use) const {
    grid_.ForCells(context, [&](LeafGrid::Range cells) {
      BallSearch search(grid_, radius_m_);
      std::vector<std::uint32_t> candidates;
      std::vector<WeightedPlace> neighbors;
      for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
        const LeafGrid::Range range = grid_.Cell(cell);
        bool entered = false;
        for (std::uint32_t place = range.begin; place < range.end; ++place) {
          if (at_[place] == kNone) continue;
          if (!entered) {
            search.EnterCell(cell);
            search.Gather(places_, kNone, &candidates);
            entered = true;
          }
          Find(place, candidates, &search, &neighbors);
          use(at_[place], std::span<const WeightedPlace>(neighbors));
        }
      }
    });
  }

 private:
  void Find(std::uint32_t place, const std::vector<std::uint32_t>& candidates, BallSearch* search,
            std::vector<WeightedPlace>* neighbors) const {
    const auto around = search->Around(place);
    const auto squared = search->SquaredDistances(place);
    neighbors->clear();
    for (const std::uint32_t j : around) {
      if (squared[j] == 0.0F || !oriented_.HasNormal(candidates[j])) continue;
      neighbors->push_back({candidates[j], 1.0F / squared[j]});
    }
  }

  const LeafGrid& grid_;
  const OrientedPlaces& oriented_;
  const std::vector<std::uint32_t>& at_;
  double radius_m_;
  std::vector<std::uint32_t> places_;
};

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
  SpfhComputer(const LeafGrid& grid, const OrientedPlaces& oriented, double radius_m)
      : oriented_(oriented), search_(grid, radius_m) {}

  void EnterCell(std::size_t cell) {
    search_.EnterCell(cell);
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      search_.Gather(oriented_.Column(c), LeafGrid::kFarAway, &candidates_[c]);
    }
  }

  /// The point must have a normal.
  SimpleHistogram Compute(std::size_t place) const {
    const auto at = [&](std::size_t c) { return oriented_.Column(c)[place]; };
    return SimpleHistogram(CountPairs(
        {at(0), at(1), at(2), at(3), at(4), at(5)},
        {candidates_[0].data(), candidates_[1].data(), candidates_[2].data(), candidates_[3].data(),
         candidates_[4].data(), candidates_[5].data(), search_.padded_count()},
        search_.squared_radius()));
  }

 private:
  const OrientedPlaces& oriented_;
  BallSearch search_;
  std::array<std::vector<float>, OrientedPlaces::kColumns> candidates_;
};

struct SimpleHistograms {
  std::vector<std::uint32_t> row_at;  // by place; kNone where not needed
  std::vector<SimpleHistogram> rows;
};

SimpleHistograms ComputeNeeded(const LeafGrid& grid, const OrientedPlaces& oriented,
                               const KeypointNeighbors& neighbors, double radius_m,
                               const ExecutionContext& context) {
  SimpleHistograms spfh;
  spfh.row_at.assign(grid.size(), kNone);
  neighbors.ForAll(context, [&](std::uint32_t /*keypoint*/, std::span<const WeightedPlace> around) {
    for (const WeightedPlace& neighbor : around) {  // key points may share it
      std::atomic_ref(spfh.row_at[neighbor.place]).store(0, std::memory_order_relaxed);
    }
  });
  context.CheckStop();
  std::uint32_t rows = 0;
  for (std::uint32_t& row : spfh.row_at) {
    if (row != kNone) row = rows++;
  }
  spfh.rows.resize(rows);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    SpfhComputer computer(grid, oriented, radius_m);
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

FpfhDescriptor Combine(const SimpleHistograms& spfh, std::span<const WeightedPlace> neighbors) {
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
  const std::vector<std::uint32_t> keypoint_at = KeypointsByPlace(grid, keypoints);
  const OrientedPlaces oriented(grid, normals);
  const KeypointNeighbors neighbors(grid, oriented, keypoint_at, radius_m);
  const SimpleHistograms spfh = ComputeNeeded(grid, oriented, neighbors, radius_m, context);
  context.CheckStop();
  std::vector<FpfhDescriptor> descriptors(keypoints.size());
  neighbors.ForAll(context, [&](std::uint32_t k, std::span<const WeightedPlace> around) {
    descriptors[k] = Combine(spfh, around);
  });
  return descriptors;
}

}  // namespace backsight
