#include "stages/leaf_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

constexpr std::size_t kCellsPerRun = 128;
constexpr std::uint32_t kCellsPerSlabRun = 64;  // a slab has few cells, and all threads wait for it

/// Packs the indices of a cell so that packed cells sort by z, then y, then x.
struct CellPacking {
  std::array<unsigned, 3> bits{};  // that hold the indices of all points

  std::uint64_t Pack(int x, int y, int z) const {
    return (static_cast<std::uint64_t>(z) << bits[1] | static_cast<std::uint64_t>(y)) << bits[0] |
           static_cast<std::uint64_t>(x);
  }
  int X(std::uint64_t packed) const { return Part(packed, bits[0]); }
  int Y(std::uint64_t packed) const { return Part(packed >> bits[0], bits[1]); }
  int Z(std::uint64_t packed) const { return Part(packed >> bits[0] >> bits[1], bits[2]); }
  static int Part(std::uint64_t packed, unsigned bits) {
    return static_cast<int>(packed & ((std::uint64_t{1} << bits) - 1U));
  }
};

struct CellOfPoint {
  std::uint64_t cell = 0;  // packed
  std::uint32_t leaf = 0;
};

/// Sorts by cell; points of one cell stay in their order.
void SortByCell(unsigned bits, std::vector<CellOfPoint>* order) {
  constexpr unsigned kDigit = 11;
  std::vector<CellOfPoint> sorted(order->size());
  for (unsigned shift = 0; shift < bits; shift += kDigit) {
    const auto digit = [shift](const CellOfPoint& entry) {
      return entry.cell >> shift & ((1U << kDigit) - 1U);
    };
    std::array<std::uint32_t, 1U << kDigit> next{};
    for (const CellOfPoint& entry : *order) ++next[digit(entry)];
    std::uint32_t before = 0;
    for (std::uint32_t& slot : next) before += std::exchange(slot, before);
    for (const CellOfPoint& entry : *order) sorted[next[digit(entry)]++] = entry;
    order->swap(sorted);
  }
}

}  // namespace

LeafGrid::LeafGrid(std::span<const Eigen::Vector3f> points, double edge_m)
    : edge_m_(edge_m), cells_per_m_(1.0 / edge_m) {
  Eigen::Array3f min = Eigen::Array3f::Zero();
  Eigen::Array3f max = Eigen::Array3f::Zero();
  if (!points.empty()) min = max = points.front().array();
  for (const Eigen::Vector3f& point : points) {
    min = min.min(point.array());
    max = max.max(point.array());
  }
  origin_ = {min.x(), min.y(), min.z()};
  constexpr double kMostCells = 1U << 21U;
  BACKSIGHT_CHECK(((max - min).cast<double>() < kMostCells * edge_m).all(),
                  "the points span too many cells");
  CellPacking packing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int last = CellIndex(max[static_cast<Eigen::Index>(axis)], axis);
    packing.bits[axis] = static_cast<unsigned>(std::bit_width(static_cast<unsigned>(last)));
  }
  std::vector<CellOfPoint> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& p = points[i];
    order[i] = {packing.Pack(CellIndex(p.x(), 0), CellIndex(p.y(), 1), CellIndex(p.z(), 2)),
                static_cast<std::uint32_t>(i)};
  }
  SortByCell(packing.bits[0] + packing.bits[1] + packing.bits[2], &order);
  leaves_.resize(order.size());
  for (auto& axis : axes_) axis.resize(order.size() + kPadding, kFarAway);
  for (std::size_t place = 0; place < order.size(); ++place) {
    leaves_[place] = order[place].leaf;
    const Eigen::Vector3f& point = points[order[place].leaf];
    axes_[0][place] = point.x();
    axes_[1][place] = point.y();
    axes_[2][place] = point.z();
  }
  for (std::uint32_t place = 0; place < order.size(); ++place) {
    const std::uint64_t cell = order[place].cell;
    if (place == 0 || cell != order[place - 1].cell) {
      OpenCell(packing.X(cell), packing.Y(cell), packing.Z(cell), place);
    }
  }
  cell_begins_.push_back(static_cast<std::uint32_t>(order.size()));
  FindBounds();
}

void LeafGrid::OpenCell(int x, int y, int z, std::uint32_t place) {
  const auto cell = static_cast<std::uint32_t>(cells_.size());
  if (rows_.empty() || rows_.back().y != y || rows_.back().z != z) {
    rows_.push_back({y, z, {cell, cell}});
  }
  ++rows_.back().cells.end;
  cell_x_.push_back(x);
  cell_begins_.push_back(place);
  cells_.push_back({static_cast<std::uint32_t>(rows_.size() - 1), {}, {}});
}

void LeafGrid::FindBounds() {
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const Range places = Cell(cell);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* values = axes_[axis].data();
      float min = values[places.begin];
      float max = min;
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        min = std::min(min, values[place]);
        max = std::max(max, values[place]);
      }
      cells_[cell].min[axis] = min;
      cells_[cell].max[axis] = max;
    }
  }
}

int LeafGrid::CellIndex(double coordinate, std::size_t axis) const {
  const double cells = (coordinate - origin_[axis]) * cells_per_m_;
  const int truncated = static_cast<int>(cells);  // std::floor is a call on baseline x86-64
  return cells < truncated ? truncated - 1 : truncated;
}

/// Distance along `axis` from the points of `cell` to the layer of cells with this index.
double LeafGrid::RowGap(int index, std::size_t axis, const OccupiedCell& cell) const {
  const double low = origin_[axis] + edge_m_ * index;
  return std::max({0.0, low - cell.max[axis], cell.min[axis] - (low + edge_m_)});
}

/// Rows that reach within `reach_m` of any point of `row`, and more.
void LeafGrid::FindRowsNear(const Row& row, double reach_m, std::vector<NearRow>* near) const {
  near->clear();
  const int layers = static_cast<int>(std::ceil(reach_m * cells_per_m_)) + 1;
  for (int z = row.z - layers; z <= row.z + layers; ++z) {
    auto other = std::partition_point(rows_.begin(), rows_.end(), [&](const Row& r) {
      return r.z != z ? r.z < z : r.y < row.y - layers;
    });
    for (; other != rows_.end() && other->z == z && other->y <= row.y + layers; ++other) {
      near->push_back({other->y, other->z, other->cells, {other->cells.begin, other->cells.begin}});
    }
  }
}

void LeafGrid::AppendCells(const OccupiedCell& cell, double reach_m, NearRow* row,
                           std::vector<Range>* ranges) const {
  const double gap_y = RowGap(row->y, 1, cell);
  const double gap_z = RowGap(row->z, 2, cell);
  const double left = reach_m * reach_m - gap_y * gap_y - gap_z * gap_z;
  if (left < 0.0) return;
  const double reach_x = std::sqrt(left);
  const int first_x = CellIndex(cell.min[0] - reach_x, 0);
  const int last_x = CellIndex(cell.max[0] + reach_x, 0);
  // Neighbours in a row take much the same cells, so both ends need few steps.
  const int* x = cell_x_.data();
  auto& [first, last] = row->taken;
  while (first > row->cells.begin && x[first - 1] >= first_x) --first;
  while (first < row->cells.end && x[first] < first_x) ++first;
  last = std::max(last, first);
  while (last > first && x[last - 1] > last_x) --last;
  while (last < row->cells.end && x[last] <= last_x) ++last;
  if (first != last) ranges->push_back({cell_begins_[first], cell_begins_[last]});
}

void LeafGrid::RangesAround(std::size_t cell, double radius_m, SearchState* state,
                            std::vector<Range>* ranges) const {
  ranges->clear();
  const OccupiedCell& center = cells_[cell];
  // Squared distances are rounded to float; what they may let in must be among the candidates.
  const double reach_m = radius_m * (1.0 + 1e-6) + 1e-6 * edge_m_;
  if (state->row != center.row) {
    state->row = center.row;
    FindRowsNear(rows_[center.row], reach_m, &state->rows);
  }
  for (NearRow& row : state->rows) AppendCells(center, reach_m, &row, ranges);
}

void LeafGrid::ForCells(const ExecutionContext& context,
                        const std::function<void(Range)>& body) const {
  const std::size_t runs = (cell_count() + kCellsPerRun - 1) / kCellsPerRun;
  context.ParallelFor(runs, [&](std::size_t run) {
    const std::size_t end = std::min((run + 1) * kCellsPerRun, cell_count());
    body({static_cast<std::uint32_t>(run * kCellsPerRun), static_cast<std::uint32_t>(end)});
  });
}

/// The lowest y of each slab's rows.
std::vector<int> LeafGrid::FirstRowsOfSlabs(double radius_m, std::size_t least_points) const {
  std::map<int, std::size_t> points_at;  // by y
  for (const Row& row : rows_) {
    points_at[row.y] += cell_begins_[row.cells.end] - cell_begins_[row.cells.begin];
  }
  // A little more than the radius, as rounded distances may reach.
  const int least_rows = static_cast<int>(radius_m * cells_per_m_ + 1e-3) + 1;
  std::vector<int> first_rows;
  std::size_t points = 0;
  for (const auto& [y, points_there] : points_at) {
    if (first_rows.empty() || (points >= least_points && y >= first_rows.back() + least_rows)) {
      first_rows.push_back(y);
      points = 0;
    }
    points += points_there;
  }
  return first_rows;
}

std::vector<LeafGrid::Slab> LeafGrid::CutIntoSlabs(double radius_m,
                                                   std::size_t least_points) const {
  const std::vector<int> first_rows = FirstRowsOfSlabs(radius_m, least_points);
  std::vector<Slab> slabs(first_rows.size());
  for (const Row& row : rows_) {
    const auto beyond = std::upper_bound(first_rows.begin(), first_rows.end(), row.y);
    Slab& slab = slabs[static_cast<std::size_t>(beyond - first_rows.begin()) - 1];
    for (std::uint32_t begin = row.cells.begin; begin < row.cells.end;) {
      const bool joins = !slab.empty() && slab.back().end == begin &&
                         slab.back().end - slab.back().begin < kCellsPerSlabRun;
      if (!joins) slab.push_back({begin, begin});
      Range& run = slab.back();
      run.end = begin = std::min(row.cells.end, run.begin + kCellsPerSlabRun);
    }
  }
  return slabs;
}

void LeafGrid::ForCells(const Slab& slab, const ExecutionContext& context,
                        const std::function<void(Range)>& body) {
  context.ParallelFor(slab.size(), [&](std::size_t run) { body(slab[run]); });
}

BallSearch::BallSearch(const LeafGrid& grid, double radius_m)
    : grid_(grid), radius_m_(radius_m), squared_radius_(static_cast<float>(radius_m * radius_m)) {}

void BallSearch::EnterCell(std::size_t cell) {
  grid_.RangesAround(cell, radius_m_, &state_, &ranges_);
  count_ = 0;
  for (const LeafGrid::Range& range : ranges_) count_ += range.end - range.begin;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Gather(grid_.Axis(axis), LeafGrid::kFarAway, &axes_[axis]);
  }
}

std::span<const float> BallSearch::SquaredDistances(std::size_t place) {
  const float* x = Axis(0);
  const float* y = Axis(1);
  const float* z = Axis(2);
  const float x0 = grid_.Axis(0)[place];
  const float y0 = grid_.Axis(1)[place];
  const float z0 = grid_.Axis(2)[place];
  if (squared_.size() < count_) squared_.resize(2 * count_);
  float* squared = squared_.data();
  for (std::size_t j = 0; j < count_; ++j) {
    const float dx = x[j] - x0;
    const float dy = y[j] - y0;
    const float dz = z[j] - z0;
    squared[j] = dx * dx + dy * dy + dz * dz;
  }
  return {squared_.data(), count_};
}

std::span<const std::uint32_t> BallSearch::Around(std::size_t place) {
  const std::span<const float> squared = SquaredDistances(place);
  if (found_.size() <= count_) found_.resize(2 * count_ + 1);
  // Numbers that are not negative order like their bits, which compare in fewer steps. An entry is
  // overwritten unless it is in: there is no branch to mispredict.
  const auto limit = std::bit_cast<std::uint32_t>(squared_radius_);
  std::uint32_t* found = found_.data();
  std::size_t count = 0;
  for (std::uint32_t j = 0; j < squared.size(); ++j) {
    found[count] = j;
    count += std::bit_cast<std::uint32_t>(squared[j]) < limit ? 1U : 0U;
  }
  return {found_.data(), count};
}

}  // namespace backsight
