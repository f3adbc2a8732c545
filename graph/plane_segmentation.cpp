#include "graph/plane_segmentation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// A voxel cluster with its station, moved to the world.
struct Item {
  std::uint64_t root_key = 0;
  int station = 0;
  const PointCluster* local = nullptr;
  PointCluster world;
};

struct Fit {
  Eigen::Vector3d eigenvalues;  // of the covariance, ascending, m^2
  Eigen::Vector3d normal;
};

Fit FitPlane(const PointCluster& cluster) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(cluster.Covariance());
  return {solver.eigenvalues(), solver.eigenvectors().col(0)};
}

/// What one station has in a cell.
struct StationPart {
  int station = 0;
  int clusters = 0;
  PointCluster local = {};
  PointCluster world = {};
};

class Splitter {
 public:
  Splitter(const PlaneSearchOptions& options, std::vector<PlaneAssociation>* planes)
      : options_(options), planes_(planes) {}

  /// `items` lie in the cube with this centre and edge, ascending station.
  void Split(std::span<Item> items, const Eigen::Vector3d& center, double edge, int depth) {
    std::vector<StationPart> parts = GatherParts(items);
    std::erase_if(parts, [&](const StationPart& part) { return !HasEnough(part); });
    if (parts.size() < 2 || Accept(parts) || depth == options_.max_depth) return;

    const auto octant = [&](const Item& item) {
      const Eigen::Vector3d d = item.world.mean - center;
      return (d.x() >= 0.0 ? 4 : 0) + (d.y() >= 0.0 ? 2 : 0) + (d.z() >= 0.0 ? 1 : 0);
    };
    std::stable_sort(items.begin(), items.end(),
                     [&](const Item& a, const Item& b) { return octant(a) < octant(b); });
    for (std::size_t begin = 0; begin < items.size();) {
      const int o = octant(items[begin]);
      std::size_t end = begin + 1;
      while (end < items.size() && octant(items[end]) == o) ++end;
      const Eigen::Vector3d sign((o & 4) != 0 ? 1 : -1, (o & 2) != 0 ? 1 : -1,
                                 (o & 1) != 0 ? 1 : -1);
      Split(items.subspan(begin, end - begin), center + 0.25 * edge * sign, 0.5 * edge, depth + 1);
      begin = end;
    }
  }

 private:
  bool HasEnough(const StationPart& part) const {
    return part.world.count >= options_.min_points || part.clusters >= options_.min_clusters;
  }

  static std::vector<StationPart> GatherParts(std::span<const Item> items) {
    std::vector<StationPart> parts;
    for (const Item& item : items) {
      if (parts.empty() || parts.back().station != item.station) {
        parts.push_back({.station = item.station});
      }
      ++parts.back().clusters;
      parts.back().local += *item.local;
      parts.back().world += item.world;
    }
    return parts;
  }

  bool IsPlanar(const Fit& fit) const {
    const Eigen::Vector3d& e = fit.eigenvalues;
    return e[0] < options_.max_thinness * e[1] && e[1] > options_.min_width * e[2] &&
           std::sqrt(std::max(e[0], 0.0)) < options_.max_thickness_m;
  }

  /// How far a station is from the joint plane, in units of what is allowed; below 1 it agrees.
  double Disagreement(const StationPart& part, const PointCluster& joint, const Fit& fit) const {
    const double cosine = std::abs(FitPlane(part.world).normal.dot(fit.normal));
    const Eigen::Vector3d offset = part.world.mean - joint.mean;
    const double across = offset.dot(fit.normal);
    const double along = (offset - across * fit.normal).norm();
    return std::max({std::acos(std::min(cosine, 1.0)) / options_.max_angle_rad,
                     std::abs(across) / options_.max_offset_m,
                     along / (2.0 * std::sqrt(fit.eigenvalues[2]))});
  }

  /// Records the plane if at least two stations see one plane here and agree on it.
  bool Accept(std::vector<StationPart> parts) {
    std::erase_if(parts, [&](const StationPart& part) { return !IsPlanar(FitPlane(part.world)); });
    while (parts.size() >= 2) {
      PointCluster joint;
      for (const StationPart& part : parts) joint += part.world;
      const Fit fit = FitPlane(joint);
      std::vector<double> disagreement;
      disagreement.reserve(parts.size());
      for (const StationPart& part : parts) {
        disagreement.push_back(Disagreement(part, joint, fit));
      }
      // Only the worst goes: it may have pulled the joint plane away from the others.
      const auto worst = std::max_element(disagreement.begin(), disagreement.end());
      if (!(*worst < 1.0)) {
        parts.erase(parts.begin() + (worst - disagreement.begin()));
        continue;
      }
      PlaneAssociation plane;
      for (const StationPart& part : parts)
        plane.observations.push_back({part.station, part.local});
      planes_->push_back(std::move(plane));
      return true;
    }
    return false;
  }

  const PlaneSearchOptions& options_;
  std::vector<PlaneAssociation>* planes_;
};

}  // namespace

std::vector<PlaneAssociation> FindPlanes(std::span<const std::vector<PointCluster>* const> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options) {
  const VoxelLattice lattice{.edge_m = options.root_edge_m};
  std::vector<Item> items;
  for (std::size_t s = 0; s < clusters.size(); ++s) {
    for (const PointCluster& cluster : *clusters[s]) {
      Item item;
      item.station = static_cast<int>(s);
      item.local = &cluster;
      item.world = Transformed(poses[s].rotation, poses[s].translation, cluster);
      item.root_key = lattice.Key(item.world.mean);
      items.push_back(item);
    }
  }
  std::stable_sort(items.begin(), items.end(),
                   [](const Item& a, const Item& b) { return a.root_key < b.root_key; });

  std::vector<PlaneAssociation> planes;
  Splitter splitter(options, &planes);
  for (std::size_t begin = 0; begin < items.size();) {
    std::size_t end = begin + 1;
    while (end < items.size() && items[end].root_key == items[begin].root_key) ++end;
    const std::span<Item> cell(items.data() + begin, end - begin);
    if (cell.front().station != cell.back().station) {
      const Eigen::Vector3d corner = lattice.Corner(VoxelLattice::Unpack(cell.front().root_key));
      const Eigen::Vector3d center = corner.array() + 0.5 * options.root_edge_m;
      splitter.Split(cell, center, options.root_edge_m, 0);
    }
    begin = end;
  }
  return planes;
}

}  // namespace backsight
