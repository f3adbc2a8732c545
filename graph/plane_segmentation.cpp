#include "graph/plane_segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/voxel_grid.h"
#include "graph/common_cells.h"
#include "graph/for_each.h"
#include "graph/plane_fit.h"

namespace backsight {
namespace {

/// A voxel cluster with its station and where its mean lies in the world.
struct Item {
  std::uint32_t station = 0;
  const PointCluster* local = nullptr;
  Eigen::Vector3d mean;
};

/// The finaliser of SplitMix64 (Steele et al. 2014, doi 10.1145/2660193.2660195).
std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

/// What one station has in a cell.
struct StationPart {
  std::uint32_t station = 0;
  int clusters = 0;
  PointCluster local;
};

/// What the stations with enough in a cell have in it; kept from cell to cell.
struct Parts {
  std::vector<StationPart> stations;
  std::vector<PointCluster> world;
  std::vector<PlaneFit> fits;

  std::size_t size() const { return stations.size(); }
  void Clear() {
    stations.clear();
    world.clear();
    fits.clear();
  }
  void Erase(std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    stations.erase(stations.begin() + at);
    world.erase(world.begin() + at);
    fits.erase(fits.begin() + at);
  }
};

class Splitter {
 public:
  Splitter(const PlaneSearchOptions& options, std::span<const RigidTransform> poses,
           std::vector<PlaneAssociation>* planes)
      : options_(options), poses_(poses), planes_(planes) {}

  /// `items` lie in the cube with this centre and edge, ascending station.
  void Split(std::span<Item> items, const Eigen::Vector3d& center, double edge, int depth) {
    GatherParts(items);
    if (parts_.size() < 2 || Accept(PlaneCell(center, options_.root_edge_m, depth)) ||
        depth == options_.max_depth) {
      return;
    }
    const std::array<std::size_t, 9> begins = SortByOctant(items, center);
    for (std::size_t o = 0; o < 8; ++o) {
      if (begins[o] == begins[o + 1]) continue;
      const Eigen::Vector3d sign((o & 4U) != 0 ? 1 : -1, (o & 2U) != 0 ? 1 : -1,
                                 (o & 1U) != 0 ? 1 : -1);
      Split(items.subspan(begins[o], begins[o + 1] - begins[o]), center + 0.25 * edge * sign,
            0.5 * edge, depth + 1);
    }
  }

 private:
  /// Where each octant begins, and the end. Within an octant the order stays.
  std::array<std::size_t, 9> SortByOctant(std::span<Item> items, const Eigen::Vector3d& center) {
    const auto octant = [&](const Item& item) {
      const Eigen::Vector3d d = item.mean - center;
      return (d.x() >= 0.0 ? 4U : 0U) + (d.y() >= 0.0 ? 2U : 0U) + (d.z() >= 0.0 ? 1U : 0U);
    };
    std::array<std::size_t, 9> begins{};
    for (const Item& item : items) ++begins[octant(item) + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::array<std::size_t, 9> next = begins;
    scratch_.assign(items.begin(), items.end());
    for (const Item& item : scratch_) items[next[octant(item)]++] = item;
    return begins;
  }

  bool HasEnough(const StationPart& part) const {
    return part.local.count >= options_.min_points || part.clusters >= options_.min_clusters;
  }

  /// The stations that have enough in the cell.
  void GatherParts(std::span<const Item> items) {
    parts_.Clear();
    for (std::size_t i = 0; i < items.size();) {
      StationPart part{.station = items[i].station, .clusters = 0, .local = {}};
      ClusterSum sum;
      for (; i < items.size() && items[i].station == part.station; ++i, ++part.clusters) {
        sum.Add(*items[i].local);
      }
      part.local = sum.Sum();
      if (HasEnough(part)) parts_.stations.push_back(part);
    }
  }

  bool IsPlanar(const PlaneFit& fit) const {
    const Eigen::Vector3d& e = fit.eigenvalues;
    return e[0] < options_.max_thinness * e[1] && e[1] > options_.min_width * e[2] &&
           std::sqrt(std::max(e[0], 0.0)) < options_.max_thickness_m;
  }

  /// Leaves the stations that see one plane in the cell, moved to the world and with their normals.
  void KeepPlanar() {
    for (const StationPart& part : parts_.stations) parts_.world.push_back(part.local);
    parts_.fits.resize(parts_.size());
    FitPlanes(parts_.world, /*normals=*/false, parts_.fits);
    for (std::size_t i = parts_.size(); i-- > 0;) {
      if (!IsPlanar(parts_.fits[i])) parts_.Erase(i);
    }
    if (parts_.size() < 2) return;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const RigidTransform& pose = poses_[parts_.stations[i].station];
      parts_.world[i] = Transformed(pose.rotation, pose.translation, parts_.stations[i].local);
    }
    FitPlanes(parts_.world, /*normals=*/true, parts_.fits);
  }

  /// How far station i is from the joint plane, in units of what is allowed; below 1 it agrees.
  double Disagreement(std::size_t i, const PointCluster& joint, const PlaneFit& fit) const {
    const double cosine = std::abs(parts_.fits[i].normal.dot(fit.normal));
    const Eigen::Vector3d offset = parts_.world[i].mean - joint.mean;
    const double across = offset.dot(fit.normal);
    const double along = (offset - across * fit.normal).norm();
    return std::max({std::acos(std::min(cosine, 1.0)) / options_.max_angle_rad,
                     std::abs(across) / options_.max_offset_m,
                     along / (2.0 * std::sqrt(fit.eigenvalues[2]))});
  }

  /// Records the plane if at least two stations see one plane here and agree on it.
  bool Accept(std::uint64_t cell) {
    KeepPlanar();
    while (parts_.size() >= 2) {
      PointCluster joint;
      for (const PointCluster& part : parts_.world) joint += part;
      PlaneFit fit;
      FitPlanes(std::span(&joint, 1), /*normals=*/true, std::span(&fit, 1));
      // Only the worst goes: it may have pulled the joint plane away from the others.
      std::size_t worst = 0;
      double most = -1.0;
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        const double disagreement = Disagreement(i, joint, fit);
        if (disagreement <= most) continue;
        worst = i;
        most = disagreement;
      }
      if (!(most < 1.0)) {
        parts_.Erase(worst);
        continue;
      }
      PlaneAssociation plane;
      plane.cell = cell;
      plane.observations.reserve(parts_.size());
      for (const StationPart& part : parts_.stations) {
        plane.observations.push_back({static_cast<int>(part.station), part.local});
      }
      planes_->push_back(std::move(plane));
      return true;
    }
    return false;
  }

  const PlaneSearchOptions& options_;
  std::span<const RigidTransform> poses_;
  std::vector<PlaneAssociation>* planes_;
  Parts parts_;
  std::vector<Item> scratch_;
};

/// Searches a run of the common cells.
class CellSearch {
 public:
  CellSearch(std::span<const ClusterList> clusters, std::span<const RigidTransform> poses,
             const PlaneSearchOptions& options, const VoxelLattice& lattice,
             std::vector<PlaneAssociation>* planes)
      : clusters_(clusters), poses_(poses), lattice_(lattice), splitter_(options, poses, planes) {}

  void Search(std::uint64_t key, std::span<const CellEntry> cell) {
    items_.clear();
    for (const CellEntry& entry : cell) {
      const ClusterList& clusters = clusters_[entry.station];
      items_.push_back({entry.station, &clusters[entry.cluster],
                        poses_[entry.station] * clusters.Mean(entry.cluster)});
    }
    const Eigen::Vector3d corner = lattice_.Corner(VoxelLattice::Unpack(key));
    const Eigen::Vector3d center = corner.array() + 0.5 * lattice_.edge_m;
    splitter_.Split(items_, center, lattice_.edge_m, 0);
  }

 private:
  std::span<const ClusterList> clusters_;
  std::span<const RigidTransform> poses_;
  VoxelLattice lattice_;
  Splitter splitter_;
  std::vector<Item> items_;
};

}  // namespace

std::uint64_t PlaneCell(const Eigen::Vector3d& world_point, double root_edge_m, int depth) {
  const VoxelLattice lattice{.edge_m = std::ldexp(root_edge_m, -depth)};
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  return Mix(lattice.Key(world_point) + kGolden * static_cast<std::uint64_t>(depth + 1));
}

std::vector<PlaneAssociation> FindPlanes(std::span<const ClusterList> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options,
                                         const ExecutionContext* context) {
  const VoxelLattice lattice{.edge_m = options.root_edge_m};
  const CommonCells cells = FindCommonCells(clusters, poses, lattice, context);
  constexpr std::size_t kChunk = 256;  // cells; fixed, so that the order is
  std::vector<std::vector<PlaneAssociation>> found((cells.keys.size() + kChunk - 1) / kChunk);
  ForEach(context, found.size(), [&](std::size_t chunk) {
    CellSearch search(clusters, poses, options, lattice, &found[chunk]);
    const std::size_t end = std::min((chunk + 1) * kChunk, cells.keys.size());
    for (std::size_t c = chunk * kChunk; c < end; ++c) search.Search(cells.keys[c], cells.Cell(c));
  });
  std::vector<PlaneAssociation> planes;
  for (auto& part : found) std::move(part.begin(), part.end(), std::back_inserter(planes));
  return planes;
}

std::vector<PlaneAssociation> FindPlanes(std::span<const std::vector<PointCluster>* const> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options) {
  std::vector<ClusterList> lists;
  lists.reserve(clusters.size());
  for (const std::vector<PointCluster>* list : clusters) lists.emplace_back(*list);
  return FindPlanes(lists, poses, options, nullptr);
}

}  // namespace backsight
