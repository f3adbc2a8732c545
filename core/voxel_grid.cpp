#include "core/voxel_grid.h"

#include <algorithm>
#include <utility>

#include "core/key_slot.h"

namespace backsight {

void VoxelClusterer::Add(std::uint64_t key, const Eigen::Vector3d& d) {
  if (key != last_key_) {  // neighbours in a scan line mostly share their voxel
    last_key_ = key;
    last_voxel_ = VoxelOf(key);
  }
  Sums& s = sums_[last_voxel_];
  s.count += 1.0;
  s.first[0] += d.x(), s.first[1] += d.y(), s.first[2] += d.z();
  s.second[0] += d.x() * d.x(), s.second[1] += d.x() * d.y(), s.second[2] += d.x() * d.z();
  s.second[3] += d.y() * d.y(), s.second[4] += d.y() * d.z(), s.second[5] += d.z() * d.z();
}

std::size_t VoxelClusterer::SlotOf(std::uint64_t key) const {
  std::size_t slot = KeySlot(key, slots_.size() - 1);
  while (slots_[slot] != kNone && sums_[slots_[slot]].key != key) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

/// A new one where there is none yet.
std::uint32_t VoxelClusterer::VoxelOf(std::uint64_t key) {
  const std::size_t slot = SlotOf(key);
  if (slots_[slot] != kNone) return slots_[slot];
  const auto voxel = static_cast<std::uint32_t>(sums_.size());
  slots_[slot] = voxel;
  sums_.push_back({.key = key});
  if (2 * sums_.size() > slots_.size()) Grow();
  return voxel;
}

void VoxelClusterer::Grow() {
  slots_.assign(2 * slots_.size(), kNone);
  for (std::uint32_t voxel = 0; voxel < sums_.size(); ++voxel) {
    slots_[SlotOf(sums_[voxel].key)] = voxel;
  }
}

PointCluster VoxelClusterer::ClusterOf(const Sums& s) const {
  const Eigen::Vector3d first(s.first[0], s.first[1], s.first[2]);
  Eigen::Matrix3d second;
  second << s.second[0], s.second[1], s.second[2], s.second[1], s.second[3], s.second[4],
      s.second[2], s.second[4], s.second[5];
  const Eigen::Vector3d mean = first / s.count;
  return {s.count, lattice_.Corner(VoxelLattice::Unpack(s.key)) + mean,
          second - first * mean.transpose()};
}

VoxelLeaves VoxelClusterer::Finish() const {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(sums_.size());
  for (std::uint32_t voxel = 0; voxel < sums_.size(); ++voxel) {
    order.emplace_back(sums_[voxel].key, voxel);
  }
  std::sort(order.begin(), order.end());
  VoxelLeaves leaves(lattice_);
  leaves.Reserve(sums_.size());
  for (const auto& [key, voxel] : order) leaves.Add(key, ClusterOf(sums_[voxel]));
  return leaves;
}

}  // namespace backsight
