#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "core/execution.h"
#include "stages/neighborhood_moments.h"

namespace backsight {

/// Points sorted into cubic cells, x fastest, so that the cells of a row lie one after another. A
/// point's position in that order is its place; coordinates are kept as columns by place. Metres,
/// any frame whose coordinates fit float. Building takes O(n).
class LeafGrid {
 public:
  struct Range {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
  };

  /// A row of cells near the one that is searched around.
  struct NearRow {
    int y = 0;
    int z = 0;
    Range cells;
    Range taken;  ///< cells from which the last search took points
  };
  /// What a search around a cell leaves to the next: neighbours in a row have the same rows near.
  struct SearchState {
    std::uint32_t row = ~std::uint32_t{0};
    std::vector<NearRow> rows;
  };

  /// Columns by place have room for as many entries more, so that several can be read at a time;
  /// candidates come in multiples of it.
  static constexpr std::size_t kPadding = 16;
  /// A coordinate that is farther from all points than any radius, and whose square is finite.
  static constexpr float kFarAway = 1e18F;

  /// `points` must be finite; `edge_m` > 0 is the cells' edge, the points' extent at most 2^21 of
  /// it along any axis. A radius of one to three edges is searched best.
  LeafGrid(std::span<const Eigen::Vector3f> points, double edge_m);

  std::size_t size() const { return leaves_.size(); }
  std::size_t cell_count() const { return cells_.size(); }
  /// Places of the points in occupied cell `cell` < cell_count().
  Range Cell(std::size_t cell) const { return {cell_begins_[cell], cell_begins_[cell + 1]}; }
  /// Index, in the order given, of the point at `place`.
  std::uint32_t LeafAt(std::size_t place) const { return leaves_[place]; }
  /// Coordinates along axis 0 to 2, by place, padded.
  const std::vector<float>& Axis(std::size_t axis) const { return axes_[axis]; }

  Coordinates At(std::size_t place) const {
    return {axes_[0][place], axes_[1][place], axes_[2][place]};
  }

  /// Replaces `ranges` by places that hold every point closer than `radius_m` to any point of the
  /// cell, and more. `state` must have seen this grid and radius only.
  void RangesAround(std::size_t cell, double radius_m, SearchState* state,
                    std::vector<Range>* ranges) const;

  /// Runs body(cells) over all occupied cells in runs of neighbours, so that scratch is made once a
  /// run. Results must go to a place of their own.
  void ForCells(const ExecutionContext& context, const std::function<void(Range)>& body) const;

  /// Occupied cells between two planes across the y axis, in runs of neighbours.
  using Slab = std::vector<Range>;
  /// Cuts the grid into slabs, ascending by y, of at least `least_points` points each, but the last
  /// one. What BallSearch finds within `radius_m`, at most 1000 cells, of a point of a slab lies in
  /// it or in those beside it.
  std::vector<Slab> CutIntoSlabs(double radius_m, std::size_t least_points) const;
  /// ForCells within a slab.
  static void ForCells(const Slab& slab, const ExecutionContext& context,
                       const std::function<void(Range)>& body);

 private:
  struct OccupiedCell {
    std::uint32_t row = 0;
    std::array<float, 3> min{};  // bounds of the cell's points
    std::array<float, 3> max{};
  };
  struct Row {
    int y = 0;
    int z = 0;
    Range cells;
  };
  std::vector<int> FirstRowsOfSlabs(double radius_m, std::size_t least_points) const;
  int CellIndex(double coordinate, std::size_t axis) const;
  double RowGap(int index, std::size_t axis, const OccupiedCell& cell) const;
  void OpenCell(int x, int y, int z, std::uint32_t place);
  void FindBounds();
  void FindRowsNear(const Row& row, double reach_m, std::vector<NearRow>* near) const;
  void AppendCells(const OccupiedCell& cell, double reach_m, NearRow* row,
                   std::vector<Range>* ranges) const;

  double edge_m_ = 1.0;
  double cells_per_m_ = 1.0;
  std::array<double, 3> origin_{};
  std::vector<std::uint32_t> leaves_;
  std::array<std::vector<float>, 3> axes_;
  // By cell. A search walks along the first two.
  std::vector<int> cell_x_;
  std::vector<std::uint32_t> cell_begins_;  // and the number of points behind
  std::vector<OccupiedCell> cells_;
  std::vector<Row> rows_;  // by z, then y
};

/// Exact neighbourhoods of fixed radius for all points of one cell after another: the candidates
/// around the cell are gathered once. Not thread-safe; make one per thread or task.
class BallSearch {
 public:
  BallSearch(const LeafGrid& grid, double radius_m);

  /// Gathers the candidates for the points of `cell`.
  void EnterCell(std::size_t cell);

  std::size_t candidate_count() const { return count_; }
  /// candidate_count() and the far away points behind, a multiple of LeafGrid::kPadding.
  std::size_t padded_count() const {
    return (count_ + LeafGrid::kPadding - 1) / LeafGrid::kPadding * LeafGrid::kPadding;
  }
  float squared_radius() const { return squared_radius_; }
  /// The candidates' coordinates along axis 0 to 2, padded by kFarAway.
  const float* Axis(std::size_t axis) const { return axes_[axis].data(); }
  /// The same with the padding.
  CandidateColumns Candidates() const { return {Axis(0), Axis(1), Axis(2), padded_count()}; }
  /// The candidates' values of a padded column by place, padded by `padding`. `values` may come out
  /// longer.
  template <class T>
  void Gather(const std::vector<T>& column, T padding, std::vector<T>* values) const {
    if (values->size() < count_ + 2 * LeafGrid::kPadding) {
      values->resize(2 * count_ + 2 * LeafGrid::kPadding);
    }
    T* to = values->data();
    for (const LeafGrid::Range& range : ranges_) {
      // A fixed length takes no call; the next range overwrites what is too much.
      const T* from = column.data() + range.begin;
      const std::size_t length = range.end - range.begin;
      for (std::size_t i = 0; i < length; i += LeafGrid::kPadding) {
        std::memcpy(to + i, from + i, LeafGrid::kPadding * sizeof(T));
      }
      to += length;
    }
    for (std::size_t i = 0; i < LeafGrid::kPadding; ++i) to[i] = padding;
  }

  /// The candidates' places.
  void GatherPlaces(std::vector<std::uint32_t>* places) const {
    places->clear();
    places->reserve(count_);
    for (const LeafGrid::Range& range : ranges_) {
      for (std::uint32_t place = range.begin; place < range.end; ++place) places->push_back(place);
    }
  }

  /// Squared distances of all candidates from the point at `place` of the cell, in float.
  std::span<const float> SquaredDistances(std::size_t place);
  /// The candidates closer than the radius to the point at `place`, itself among them, as indices
  /// into the candidates. Their squared distances are those of SquaredDistances(place), which this
  /// calls.
  std::span<const std::uint32_t> Around(std::size_t place);

 private:
  const LeafGrid& grid_;
  double radius_m_;
  float squared_radius_;
  std::size_t count_ = 0;
  LeafGrid::SearchState state_;
  std::vector<LeafGrid::Range> ranges_;
  std::array<std::vector<float>, 3> axes_;
  std::vector<float> squared_;
  std::vector<std::uint32_t> found_;
};

}  // namespace backsight
