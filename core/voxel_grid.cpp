#include "core/voxel_grid.h"

#include <algorithm>

namespace backsight {

void VoxelClusterer::Add(std::uint64_t key, const Eigen::Vector3d& d) {
  if (key != last_key_) {  // neighbours in a scan line mostly share their voxel
    const auto [slot, is_new] = slots_.try_emplace(key, static_cast<std::uint32_t>(sums_.size()));
    if (is_new) sums_.push_back({.key = key});
    last_key_ = key;
    last_slot_ = slot->second;
  }
  Sums& s = sums_[last_slot_];
  s.count += 1.0;
  s.first[0] += d.x(), s.first[1] += d.y(), s.first[2] += d.z();
  s.second[0] += d.x() * d.x(), s.second[1] += d.x() * d.y(), s.second[2] += d.x() * d.z();
  s.second[3] += d.y() * d.y(), s.second[4] += d.y() * d.z(), s.second[5] += d.z() * d.z();
}

std::vector<VoxelLeaf> VoxelClusterer::Finish() const {
  std::vector<VoxelLeaf> leaves;
  leaves.reserve(sums_.size());
  for (const Sums& s : sums_) {
    const Eigen::Vector3d first(s.first[0], s.first[1], s.first[2]);
    Eigen::Matrix3d second;
    second << s.second[0], s.second[1], s.second[2], s.second[1], s.second[3], s.second[4],
        s.second[2], s.second[4], s.second[5];
    const Eigen::Vector3d mean = first / s.count;
    VoxelLeaf leaf;
    leaf.key = s.key;
    leaf.cluster.count = s.count;
    leaf.cluster.mean = lattice_.Corner(VoxelLattice::Unpack(s.key)) + mean;
    leaf.cluster.scatter = second - first * mean.transpose();
    leaves.push_back(leaf);
  }
  std::sort(leaves.begin(), leaves.end(),
            [](const VoxelLeaf& a, const VoxelLeaf& b) { return a.key < b.key; });
  return leaves;
}

}  // namespace backsight
