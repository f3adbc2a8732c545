#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>

namespace backsight {

/// A smooth map of space, metres to metres, for very many points: exact at the corners of cubic
/// cells, trilinear within them. A cell in which that errs by more than the tolerance, or whose
/// corners cannot be mapped, is mapped exactly point by point. What a point becomes depends on
/// nothing but the point. Safe for several threads; the exact map is called by one at a time.
class TabulatedMap {
 public:
  using Exact = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

  /// The error within a cell is that of its centre and of the centres of its faces at most, as of
  /// any map whose second derivatives hardly change over `cell_m`.
  TabulatedMap(Exact exact, double cell_m, double tolerance_m);

  /// Replaces every point by its image. Throws what the exact map throws.
  void Apply(std::span<Eigen::Vector3d> points);

 private:
  /// Trilinear in the place within the cell, 0 to 1 along each axis.
  struct Cell {
    Eigen::Matrix<double, 3, 8> corners;  // by bits: 1 for x, 2 for y, 4 for z
    bool credible = false;
  };
  using Index = Eigen::Vector3d;  // whole numbers

  std::shared_ptr<const Cell> Find(const Index& index);
  Cell Tabulate(const Index& index) const;
  static Eigen::Vector3d Interpolate(const Cell& cell, const Eigen::Vector3d& place);

  Exact exact_;
  double cell_m_;
  double tolerance_m_;
  std::mutex mutex_;  // of all that follows, and of the exact map
  std::unordered_map<std::uint64_t, std::shared_ptr<const Cell>> cells_;
};

}  // namespace backsight
