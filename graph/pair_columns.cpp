#include "graph/pair_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace backsight {
namespace {

void FillColumns(const std::vector<Eigen::Vector3d>& points, CacheLineVector<float>* x,
                 CacheLineVector<float>* y, CacheLineVector<float>* z,
                 CacheLineVector<float>* squared, float* extent_m) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const auto& p : points) center += p / static_cast<double>(points.size());
  const std::size_t padded = points.size() + PairColumns::kPadding;
  for (CacheLineVector<float>* column : {x, y, z, squared}) {
    column->assign(padded, std::numeric_limits<float>::quiet_NaN());
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    (*x)[i] = static_cast<float>(points[i].x() - center.x());
    (*y)[i] = static_cast<float>(points[i].y() - center.y());
    (*z)[i] = static_cast<float>(points[i].z() - center.z());
    (*squared)[i] = Eigen::Vector3f((*x)[i], (*y)[i], (*z)[i]).squaredNorm();
    *extent_m = std::max({*extent_m, std::abs((*x)[i]), std::abs((*y)[i]), std::abs((*z)[i])});
  }
}

}  // namespace

PairColumns::PairColumns(const Correspondences& c) : rows(c.size()) {
  FillColumns(c.source, &qx, &qy, &qz, &q_squared, &extent_m);
  FillColumns(c.target, &px, &py, &pz, &p_squared, &extent_m);
}

}  // namespace backsight
