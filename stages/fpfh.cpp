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
      : grid_(grid), oriented_(oriented), at_(at), radius_m_(radius_m) {}

  /// Calls use(keypoint, neighbors) for every key point of the slab, from several threads.
  template <class Use>
  void ForAll(const LeafGrid::Slab& slab, const ExecutionContext& context, Use use) const {
    LeafGrid::ForCells(slab, context, [&](LeafGrid::Range cells) {
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
            search.GatherPlaces(&candidates);
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

using Slabs = std::vector<LeafGrid::Slab>;

/// SPFH of the points that key points need, those of the last three slabs computed.
class SimpleHistograms {
 public:
  /// All must outlive it; the slabs are the grid's, no thinner than the neighbours are away.
  SimpleHistograms(const LeafGrid& grid, const OrientedPlaces& oriented, const Slabs& slabs,
                   const KeypointNeighbors& neighbors, double radius_m,
                   const ExecutionContext& context)
      : grid_(grid),
        oriented_(oriented),
        slabs_(slabs),
        radius_m_(radius_m),
        row_at_(grid.size(), kNone) {
    for (const LeafGrid::Slab& slab : slabs_) Mark(slab, neighbors, context);
    std::array<std::uint32_t, kKept> most{};
    for (std::size_t slab = 0; slab < slabs_.size(); ++slab) {
      std::uint32_t& rows = most[slab % kKept];
      rows = std::max(rows, NumberRows(slab));
    }
    for (std::size_t turn = 0; turn < kKept; ++turn) rows_[turn].resize(most[turn]);
  }

  /// Those of a slab, one after the other: the three computed last are there.
  void Compute(std::size_t slab, const ExecutionContext& context) {
    LeafGrid::ForCells(slabs_[slab], context, [&](LeafGrid::Range cells) {
      SpfhComputer computer(grid_, oriented_, radius_m_);
      for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
        const LeafGrid::Range range = grid_.Cell(cell);
        bool entered = false;
        for (std::uint32_t place = range.begin; place < range.end; ++place) {
          if (row_at_[place] == kNone) continue;
          if (!entered) computer.EnterCell(cell);
          entered = true;
          const std::uint32_t row = row_at_[place];
          rows_[row % kKept][row / kKept] = computer.Compute(place);
        }
      }
    });
  }

  const SimpleHistogram& At(std::uint32_t place) const {
    const std::uint32_t row = row_at_[place];
    return rows_[row % kKept][row / kKept];
  }

 private:
  static constexpr std::uint32_t kKept = 3;  // slabs

  /// Whatever the key points of a slab need gets a row, no matter yet which.
  void Mark(const LeafGrid::Slab& slab, const KeypointNeighbors& neighbors,
            const ExecutionContext& context) {
    neighbors.ForAll(slab, context, [&](std::uint32_t /*keypoint*/, const auto& around) {
      for (const WeightedPlace& neighbor : around) {  // key points may share it
        std::atomic_ref(row_at_[neighbor.place]).store(0, std::memory_order_relaxed);
      }
    });
  }

  /// Slabs take turns at the rows of three lists. Returns how many this one needs.
  std::uint32_t NumberRows(std::size_t slab) {
    std::uint32_t rows = 0;
    for (const LeafGrid::Range& cells : slabs_[slab]) {
      for (std::uint32_t place = grid_.Cell(cells.begin).begin;
           place < grid_.Cell(cells.end - 1).end; ++place) {
        if (row_at_[place] == kNone) continue;
        row_at_[place] = kKept * rows++ + static_cast<std::uint32_t>(slab % kKept);
      }
    }
    return rows;
  }

  const LeafGrid& grid_;
  const OrientedPlaces& oriented_;
  const Slabs& slabs_;
  double radius_m_;
  std::vector<std::uint32_t> row_at_;  // by place: kKept * row + list; kNone: none
  std::array<std::vector<SimpleHistogram>, kKept> rows_;
};

FpfhDescriptor Combine(const SimpleHistograms& spfh, std::span<const WeightedPlace> neighbors) {
  FpfhDescriptor sum{};
  for (const WeightedPlace& neighbor : neighbors) {
    const SimpleHistogram& row = spfh.At(neighbor.place);
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
                                        const ExecutionContext& context, std::size_t slab_points) {
  const std::vector<std::uint32_t> keypoint_at = KeypointsByPlace(grid, keypoints);
  const OrientedPlaces oriented(grid, normals);
  const KeypointNeighbors neighbors(grid, oriented, keypoint_at, radius_m);
  const Slabs slabs = grid.CutIntoSlabs(radius_m, slab_points);
  SimpleHistograms spfh(grid, oriented, slabs, neighbors, radius_m, context);
  std::vector<FpfhDescriptor> descriptors(keypoints.size());
  const auto describe = [&](const LeafGrid::Slab& slab) {
    neighbors.ForAll(slab, context, [&](std::uint32_t k, std::span<const WeightedPlace> around) {
      descriptors[k] = Combine(spfh, around);
    });
  };
  for (std::size_t slab = 0; slab < slabs.size(); ++slab) {
    spfh.Compute(slab, context);
    if (slab > 0) describe(slabs[slab - 1]);  // whose neighbours are all there now
  }
  if (!slabs.empty()) describe(slabs.back());
  return descriptors;
}

}  // namespace backsight
