#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/archive.h"
#include "core/point_cluster.h"
#include "core/voxel_points.h"
#include "core/voxel_spread.h"

namespace backsight {

/// The occupied voxels of a lattice, each with the cluster of its points: key
/// (VoxelLattice::Pack), mean and spread, each in a row of its own. 32 bytes per voxel; how precise
/// they are, VoxelPoints and VoxelSpread say.
class VoxelLeaves {
 public:
  VoxelLeaves() = default;
  explicit VoxelLeaves(const VoxelLattice& lattice) : means_(lattice) {}

  const VoxelLattice& lattice() const { return means_.lattice(); }
  std::size_t size() const { return means_.size(); }
  bool empty() const { return size() == 0; }
  void Reserve(std::size_t voxels);
  /// The mean must lie in the voxel `key`, but for rounding.
  void Add(std::uint64_t key, const PointCluster& cluster);
  static constexpr std::size_t kMostParts = 256;
  /// Brings kMostParts parts at most, of one lattice, each sorted by key, no key twice, into one:
  /// O(n log parts). Beside what they hold it takes the memory of one column, at most 19 bytes per
  /// voxel.
  static VoxelLeaves Merge(std::vector<VoxelLeaves> parts);
  /// Moves all points, and the lattice with them; the keys stay.
  void Translate(const Eigen::Vector3d& by) { means_.Translate(by); }

  std::uint64_t Key(std::size_t i) const { return means_.Key(i); }
  Eigen::Vector3d Mean(std::size_t i) const { return means_[i]; }
  double Count(std::size_t i) const { return spreads_[i].count(); }
  PointCluster Cluster(std::size_t i) const { return spreads_[i].About(means_[i]); }

  std::span<const std::uint64_t> keys() const { return means_.keys(); }
  const VoxelPoints& means() const { return means_; }

  template <class Archive>
  friend void Transfer(Archive& archive, VoxelLeaves& leaves) {
    archive(leaves.means_, leaves.spreads_);
    if constexpr (Archive::kReads) {
      if (leaves.spreads_.size() != leaves.size()) throw DamagedArchive();
    }
  }

 private:
  VoxelPoints means_;
  std::vector<VoxelSpread> spreads_;
};

}  // namespace backsight
