#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/cluster_spread.h"
#include "core/rigid_transform.h"
#include "graph/cluster_list.h"
#include "graph/octree_cells.h"
#include "graph/plane_rules.h"

namespace backsight {

/// Sums what a station has in the root cells of a lattice and in their octants, once for all
/// searches that it takes part in (PairPlaneSearch). Only what HasEnough is kept, and of the
/// deepest octants only those that are planar. Time O(n log n) for n clusters, memory 64 bytes for
/// each cell or octant kept, taken 2 MB at a time.
class PlaneTree {
 public:
  struct Node {
    Eigen::Vector3d mean;  ///< of all points in the cell, the station's frame
    ClusterSpread spread;
    std::uint32_t first_child = 0;  ///< of those that are kept, one after the other
    std::uint8_t octants = 0;       ///< those that are kept
    bool is_planar = false;

    PointCluster Local() const { return spread.About(mean); }
  };

  /// `lattice_from_station` moves the clusters into the lattice's frame. Of the options those that
  /// concern one station count; max_depth is at most OctreeCells::kDepth.
  PlaneTree(const ClusterList& clusters, const RigidTransform& lattice_from_station,
            const PlaneSearchOptions& options);

  const RigidTransform& lattice_from_station() const { return lattice_from_station_; }
  const PlaneSearchOptions& options() const { return options_; }
  std::size_t roots() const { return root_keys_.size(); }
  const Node& Root(std::size_t place) const { return NodeAt(root_nodes_[place]); }
  std::uint64_t RootKey(std::size_t place) const { return root_keys_[place]; }
  /// The place of the cell OctreeCells::Root among the roots, which ascend.
  std::optional<std::uint32_t> FindRoot(std::uint64_t key) const;
  /// What is in an octant, null where there is not enough for a plane.
  const Node* Child(const Node& node, std::uint32_t octant) const;

 private:
  std::uint32_t AddNode(std::span<const PathEntry> entries, int depth, const ClusterList& clusters);
  void AddChildren(std::uint32_t node, std::span<const PathEntry> entries, int depth,
                   const ClusterList& clusters);
  void MakeSlots();
  const Node& NodeAt(std::uint32_t node) const { return blocks_[node / kBlock][node % kBlock]; }
  Node& NodeAt(std::uint32_t node) { return blocks_[node / kBlock][node % kBlock]; }

  static constexpr std::uint32_t kNone = ~0U;
  static constexpr std::uint32_t kBlock = 1U << 15U;
  PlaneSearchOptions options_;
  RigidTransform lattice_from_station_;
  std::vector<std::vector<Node>> blocks_;  // of kBlock nodes: one vector would move them to grow
  std::uint32_t node_count_ = 0;
  std::vector<std::uint64_t> root_keys_;  // ascending
  std::vector<std::uint32_t> root_nodes_;
  struct RootSlot {
    std::uint64_t key = 0;
    std::uint32_t place = kNone;
  };
  std::vector<RootSlot> slots_;  // places of roots by the hash of their keys
};

}  // namespace backsight
