#include "stages/surface_incidence.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace backsight {
namespace {

constexpr double kMostThickness = 1.0 / 8;  // rms, in voxel edges; 0.29 in a voxel full of points

std::optional<Eigen::Vector3d> CredibleNormal(const Surface& surface, std::size_t leaf) {
  const Eigen::Vector3d normal = surface.normals[leaf].cast<double>();
  if (!normal.allFinite()) return std::nullopt;
  const double variance = normal.dot(surface.model.leaves.Cluster(leaf).Covariance() * normal);
  const double most = kMostThickness * surface.model.resolution_m();
  if (variance > most * most) return std::nullopt;
  return normal;
}

}  // namespace

void SurfaceIncidence::FindLeaf(std::uint64_t key) {
  const auto& leaves = surface_.model.leaves;
  BACKSIGHT_CHECK(leaves.size() == surface_.normals.size(), "a normal per voxel");
  key_ = key;
  normal_.reset();
  const auto is_at = [&](std::size_t i) { return i < leaves.size() && leaves.Key(i) == key; };
  // Voxels one above the other have successive keys, and most scans are made of columns.
  if (is_at(leaf_ + 1)) {
    ++leaf_;
  } else if (leaf_ > 0 && is_at(leaf_ - 1)) {
    --leaf_;
  } else if (!is_at(leaf_)) {
    const auto keys = leaves.keys();
    leaf_ =
        static_cast<std::size_t>(std::lower_bound(keys.begin(), keys.end(), key) - keys.begin());
  }
  if (is_at(leaf_)) normal_ = CredibleNormal(surface_, leaf_);
}

std::optional<double> SurfaceIncidence::CosAt(const Eigen::Vector3d& station_point) {
  if (!surface_.scanner_credible) return std::nullopt;
  const Eigen::Vector3d beam = station_point - surface_.model.scanner_origin;
  const std::uint64_t key = surface_.model.lattice().Key(beam);
  if (key_ != key) FindLeaf(key);
  const double range = beam.norm();
  if (!normal_ || !(range > 0.0)) return std::nullopt;
  return std::min(1.0, std::abs(normal_->dot(beam)) / range);
}

}  // namespace backsight
