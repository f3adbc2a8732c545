#include "stages/tabulated_map.h"

#include <cmath>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

constexpr double kFarthest = 1 << 20;  // index of a cell; beyond, points are mapped exactly

Eigen::Vector3d CornerOf(int corner) {
  return Eigen::Vector3i(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1).cast<double>();
}

/// Of an index within kFarthest.
std::uint64_t KeyOf(const Eigen::Vector3d& index) {
  std::uint64_t key = 0;
  for (const double i : index) key = key << 21U | static_cast<std::uint64_t>(i + kFarthest);
  return key;
}

}  // namespace

TabulatedMap::TabulatedMap(Exact exact, double cell_m, double tolerance_m)
    : exact_(std::move(exact)), cell_m_(cell_m), tolerance_m_(tolerance_m) {}

void TabulatedMap::Apply(std::span<Eigen::Vector3d> points) {
  std::shared_ptr<const Cell> cell;
  Index last = Index::Constant(NAN);
  for (Eigen::Vector3d& point : points) {
    const Eigen::Vector3d scaled = point / cell_m_;
    const Index index = scaled.array().floor();
    if (index != last) {
      cell = Find(index);
      last = index;
    }
    if (cell->credible) {
      point = Interpolate(*cell, scaled - index);
    } else {
      const std::scoped_lock lock(mutex_);
      point = exact_(point);
    }
  }
}

std::shared_ptr<const TabulatedMap::Cell> TabulatedMap::Find(const Index& index) {
  constexpr std::size_t kMostCells = std::size_t{1} << 15U;  // of 0.27 kB
  if (!(index.array().abs() < kFarthest).all()) return std::make_shared<const Cell>();
  const std::scoped_lock lock(mutex_);
  if (cells_.size() >= kMostCells) cells_.clear();
  std::shared_ptr<const Cell>& cell = cells_[KeyOf(index)];
  if (!cell) cell = std::make_shared<const Cell>(Tabulate(index));
  return cell;
}

TabulatedMap::Cell TabulatedMap::Tabulate(const Index& index) const {
  const auto exact_at = [&](const Eigen::Vector3d& place) {
    return exact_(cell_m_ * (index + place));
  };
  Cell cell;
  try {
    for (int corner = 0; corner < 8; ++corner) {
      cell.corners.col(corner) = exact_at(CornerOf(corner));
    }
    const Eigen::Vector3d centre = Eigen::Vector3d::Constant(0.5);
    double worst_m = (Interpolate(cell, centre) - exact_at(centre)).norm();
    for (int face = 0; face < 6; ++face) {
      Eigen::Vector3d place = centre;
      place[face % 3] = face < 3 ? 0.0 : 1.0;
      worst_m = std::max(worst_m, (Interpolate(cell, place) - exact_at(place)).norm());
    }
    // Where the map has an edge, a cell may err twice as much as these places show.
    cell.credible = worst_m <= 0.5 * tolerance_m_;
  } catch (const InputError&) {
    cell.credible = false;  // a point of the cell may do where a corner does not
  }
  return cell;
}

Eigen::Vector3d TabulatedMap::Interpolate(const Cell& cell, const Eigen::Vector3d& place) {
  const auto& c = cell.corners;
  const Eigen::Matrix<double, 3, 4> by_yz =
      c(Eigen::all, {0, 2, 4, 6}) +
      place.x() * (c(Eigen::all, {1, 3, 5, 7}) - c(Eigen::all, {0, 2, 4, 6}));
  const Eigen::Vector3d low = by_yz.col(0) + place.y() * (by_yz.col(1) - by_yz.col(0));
  const Eigen::Vector3d high = by_yz.col(2) + place.y() * (by_yz.col(3) - by_yz.col(2));
  return low + place.z() * (high - low);
}

}  // namespace backsight
