#include "stages/leaf_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace backsight {
namespace {

constexpr std::size_t kCellsPerRun = 32;

struct CellOfPoint {
  int z = 0;
  int y = 0;
  int x = 0;
  std::uint32_t leaf = 0;
  auto operator<=>(const CellOfPoint&) const = default;
};

}  // namespace

LeafGrid::LeafGrid(std::span<const Eigen::Vector3f> points, double edge_m)
    : edge_m_(edge_m), cells_per_m_(1.0 / edge_m) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  if (!points.empty()) {
    Eigen::Vector3f min = points.front();
    for (const Eigen::Vector3f& point : points) min = min.cwiseMin(point);
    origin_ = {min.x(), min.y(), min.z()};
  }
  std::vector<CellOfPoint> order;
  order.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    order.push_back({CellIndex(point.z(), 2), CellIndex(point.y(), 1), CellIndex(point.x(), 0),
                     static_cast<std::uint32_t>(order.size())});
  }
  std::sort(order.begin(), order.end());
  leaves_.reserve(order.size());
  for (const CellOfPoint& entry : order) {
    const auto place = static_cast<std::uint32_t>(leaves_.size());
    const bool new_row = rows_.empty() || rows_.back().y != entry.y || rows_.back().z != entry.z;
    if (new_row || cells_.back().x != entry.x) {
      const auto cell = static_cast<std::uint32_t>(cells_.size());
      if (new_row) rows_.push_back({entry.y, entry.z, {cell, cell}});
      ++rows_.back().cells.end;
      cells_.push_back({{place, place},
                        entry.x,
                        {kInfinity, kInfinity, kInfinity},
                        {-kInfinity, -kInfinity, -kInfinity}});
    }
    OccupiedCell& cell = cells_.back();
    ++cell.places.end;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float value = points[entry.leaf][static_cast<Eigen::Index>(axis)];
      axes_[axis].push_back(value);
      cell.min[axis] = std::min(cell.min[axis], value);
      cell.max[axis] = std::max(cell.max[axis], value);
    }
    leaves_.push_back(entry.leaf);
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

void LeafGrid::AppendRow(const Row& row, const OccupiedCell& cell, double reach_m,
                         std::vector<Range>* ranges) const {
  const double gap_y = RowGap(row.y, 1, cell);
  const double gap_z = RowGap(row.z, 2, cell);
  const double left = reach_m * reach_m - gap_y * gap_y - gap_z * gap_z;
  if (left < 0.0) return;
  const int first_x = CellIndex(cell.min[0] - std::sqrt(left), 0);
  const int last_x = CellIndex(cell.max[0] + std::sqrt(left), 0);
  const auto first =
      std::partition_point(cells_.begin() + row.cells.begin, cells_.begin() + row.cells.end,
                           [&](const OccupiedCell& other) { return other.x < first_x; });
  auto last = first;
  while (last != cells_.begin() + row.cells.end && last->x <= last_x) ++last;
  if (first != last) ranges->push_back({first->places.begin, (last - 1)->places.end});
}

void LeafGrid::RangesAround(std::size_t cell, double radius_m, std::vector<Range>* ranges) const {
  ranges->clear();
  const OccupiedCell& center = cells_[cell];
  // Squared distances are rounded to float; what they may let in must be among the candidates.
  const double reach_m = radius_m * (1.0 + 1e-6) + 1e-6 * edge_m_;
  const int first_y = CellIndex(center.min[1] - reach_m, 1);
  const int last_y = CellIndex(center.max[1] + reach_m, 1);
  const int last_z = CellIndex(center.max[2] + reach_m, 2);
  for (int z = CellIndex(center.min[2] - reach_m, 2); z <= last_z; ++z) {
    auto row = std::partition_point(rows_.begin(), rows_.end(), [&](const Row& other) {
      return other.z != z ? other.z < z : other.y < first_y;
    });
    for (; row != rows_.end() && row->z == z && row->y <= last_y; ++row) {
      AppendRow(*row, center, reach_m, ranges);
    }
  }
}

void LeafGrid::ForCells(const ExecutionContext& context,
                        const std::function<void(Range)>& body) const {
  const std::size_t runs = (cell_count() + kCellsPerRun - 1) / kCellsPerRun;
  context.ParallelFor(runs, [&](std::size_t run) {
    const std::size_t end = std::min((run + 1) * kCellsPerRun, cell_count());
    body({static_cast<std::uint32_t>(run * kCellsPerRun), static_cast<std::uint32_t>(end)});
  });
}

BallSearch::BallSearch(const LeafGrid& grid, double radius_m)
    : grid_(grid), radius_m_(radius_m), squared_radius_(static_cast<float>(radius_m * radius_m)) {}

void BallSearch::EnterCell(std::size_t cell) {
  grid_.RangesAround(cell, radius_m_, &ranges_);
  for (std::size_t axis = 0; axis < 3; ++axis) Gather(grid_.Axis(axis), &axes_[axis]);
  squared_.resize(candidate_count());
  found_.resize(candidate_count());
}

std::span<const float> BallSearch::SquaredDistances(std::size_t place) {
  const float* x = Axis(0);
  const float* y = Axis(1);
  const float* z = Axis(2);
  const float x0 = grid_.Axis(0)[place];
  const float y0 = grid_.Axis(1)[place];
  const float z0 = grid_.Axis(2)[place];
  float* squared = squared_.data();
  const std::size_t n = candidate_count();
  for (std::size_t j = 0; j < n; ++j) {
    const float dx = x[j] - x0;
    const float dy = y[j] - y0;
    const float dz = z[j] - z0;
    squared[j] = dx * dx + dy * dy + dz * dz;
  }
  return squared_;
}

std::span<const std::uint32_t> BallSearch::Around(std::size_t place) {
  const std::span<const float> squared = SquaredDistances(place);
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
