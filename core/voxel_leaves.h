#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/archive.h"
#include "core/cluster_spread.h"
#include "core/point_cluster.h"

namespace backsight {

/// The occupied voxels of a lattice, each with the cluster of its points: key
/// (VoxelLattice::Pack), mean and spread, each in a row of its own. 60 bytes per voxel; what the
/// spread's precision is, ClusterSpread says.
class VoxelLeaves {
 public:
  std::size_t size() const { return keys_.size(); }
  bool empty() const { return keys_.empty(); }
  void Reserve(std::size_t voxels);
  void Add(std::uint64_t key, const PointCluster& cluster);
  static constexpr std::size_t kMostParts = 256;
  /// Brings kMostParts parts at most, each sorted by key, no key twice, into one: O(n log parts).
  /// Beside what they hold it takes the memory of one column, at most 29 bytes per voxel.
  static VoxelLeaves Merge(std::vector<VoxelLeaves> parts);
  /// Moves all points; the keys stay.
  void Translate(const Eigen::Vector3d& by);

  std::uint64_t Key(std::size_t i) const { return keys_[i]; }
  const Eigen::Vector3d& Mean(std::size_t i) const { return means_[i]; }
  double Count(std::size_t i) const { return spreads_[i].count(); }
  PointCluster Cluster(std::size_t i) const { return spreads_[i].About(means_[i]); }

  std::span<const std::uint64_t> keys() const { return keys_; }
  std::span<const Eigen::Vector3d> means() const { return means_; }

  template <class Archive>
  friend void Transfer(Archive& archive, VoxelLeaves& leaves) {
    archive(leaves.keys_, leaves.means_, leaves.spreads_);
    if constexpr (Archive::kReads) {
      if (leaves.means_.size() != leaves.size() || leaves.spreads_.size() != leaves.size()) {
        throw DamagedArchive();
      }
    }
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::vector<Eigen::Vector3d> means_;
  std::vector<ClusterSpread> spreads_;
};

}  // namespace backsight
