#include "stages/normals.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <limits>

namespace backsight {
namespace {

/// Scatter about the mean. Sums are formed relative to `origin` (one of the points), so nothing
/// cancels far from the instrument.
Eigen::Matrix3d Scatter(const BallSearch& search, std::span<const std::uint32_t> neighbors,
                        const Eigen::Vector3f& origin) {
  double sx = 0.0, sy = 0.0, sz = 0.0;
  double sxx = 0.0, sxy = 0.0, sxz = 0.0, syy = 0.0, syz = 0.0, szz = 0.0;
  for (const std::uint32_t j : neighbors) {
    const double x = search.Axis(0)[j] - origin.x();
    const double y = search.Axis(1)[j] - origin.y();
    const double z = search.Axis(2)[j] - origin.z();
    sx += x;
    sy += y;
    sz += z;
    sxx += x * x;
    sxy += x * y;
    sxz += x * z;
    syy += y * y;
    syz += y * z;
    szz += z * z;
  }
  Eigen::Matrix3d second;
  second << sxx, sxy, sxz, sxy, syy, syz, sxz, syz, szz;
  const Eigen::Vector3d first(sx, sy, sz);
  return second - first * first.transpose() / static_cast<double>(neighbors.size());
}

/// Unit vector of the smallest eigenvalue. It is orthogonal to the rows of A - lambda I; the
/// longest cross product of two rows is the safest. Where the two smallest eigenvalues are nearly
/// one, all of them vanish and the iterative solver decides.
Eigen::Vector3d LeastDirection(const Eigen::Matrix3d& scatter) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter, Eigen::EigenvaluesOnly);
  Eigen::Matrix3d shifted = scatter;
  shifted.diagonal().array() -= solver.eigenvalues()[0];
  Eigen::Vector3d best = shifted.col(0).cross(shifted.col(1));
  for (const Eigen::Vector3d& other : {Eigen::Vector3d(shifted.col(0).cross(shifted.col(2))),
                                       Eigen::Vector3d(shifted.col(1).cross(shifted.col(2)))}) {
    if (other.squaredNorm() > best.squaredNorm()) best = other;
  }
  const double scale = scatter.trace() * scatter.trace();
  constexpr double kSafe = 1e-7;  // far above the rounding of the cross product, 1e-16 of the scale
  if (best.norm() > kSafe * scale) return best.normalized();
  solver.compute(scatter);
  return solver.eigenvectors().col(0);
}

}  // namespace

std::vector<Eigen::Vector3f> EstimateNormals(const LeafGrid& grid, double radius_m,
                                             const ExecutionContext& context) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::vector<Eigen::Vector3f> normals(grid.size(), Eigen::Vector3f::Constant(kNaN));
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, radius_m);
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search.EnterCell(cell);
      const LeafGrid::Range places = grid.Cell(cell);
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        const auto neighbors = search.Around(place);
        if (neighbors.size() < 3) continue;
        const Eigen::Vector3f origin(grid.Axis(0)[place], grid.Axis(1)[place], grid.Axis(2)[place]);
        normals[grid.LeafAt(place)] =
            LeastDirection(Scatter(search, neighbors, origin)).cast<float>();
      }
    }
  });
  return normals;
}

}  // namespace backsight
