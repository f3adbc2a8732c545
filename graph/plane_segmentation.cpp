#include "graph/plane_segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/voxel_grid.h"
#include "graph/common_cells.h"
#include "graph/for_each.h"

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

class Splitter {
 public:
  Splitter(const PlaneSearchOptions& options, std::span<const RigidTransform> poses,
           std::vector<PlaneAssociation>* planes)
      : options_(options), judge_(options, poses), planes_(planes) {}

  /// `items` lie in the cube with this centre and edge, ascending station.
  void Split(std::span<Item> items, const Eigen::Vector3d& center, double edge, int depth) {
    GatherParts(items);
    if (judge_.size() < 2 || Accept(PlaneCell(center, options_.root_edge_m, depth)) ||
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

  /// The stations that have enough in the cell.
  void GatherParts(std::span<const Item> items) {
    judge_.Clear();
    for (std::size_t i = 0; i < items.size();) {
      const std::uint32_t station = items[i].station;
      int clusters = 0;
      ClusterSum sum;
      for (; i < items.size() && items[i].station == station; ++i, ++clusters) {
        sum.Add(*items[i].local);
      }
      const PointCluster local = sum.Sum();
      if (HasEnough(local.count, clusters, options_)) judge_.Add(station, local);
    }
  }

  /// Records the plane if at least two stations see one plane here and agree on it.
  bool Accept(std::uint64_t cell) {
    PlaneAssociation plane;
    if (!judge_.Judge(&plane.observations)) return false;
    plane.cell = cell;
    planes_->push_back(std::move(plane));
    return true;
  }

  const PlaneSearchOptions& options_;
  PlaneJudge judge_;
  std::vector<PlaneAssociation>* planes_;
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
    locals_.clear();
    for (const CellEntry& entry : cell) {
      locals_.push_back(clusters_[entry.station][entry.cluster]);
    }
    items_.clear();
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const std::uint32_t station = cell[i].station;
      items_.push_back({station, &locals_[i], poses_[station] * locals_[i].mean});
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
  std::vector<PointCluster> locals_;
  std::vector<Item> items_;
};

}  // namespace

std::uint64_t PlaneCell(const Eigen::Vector3i& cell, int depth) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  return Mix(VoxelLattice::Pack(cell) + kGolden * static_cast<std::uint64_t>(depth + 1));
}

std::uint64_t PlaneCell(const Eigen::Vector3d& world_point, double root_edge_m, int depth) {
  const VoxelLattice lattice{.edge_m = std::ldexp(root_edge_m, -depth)};
  return PlaneCell(lattice.Cell(world_point), depth);
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
