#include "core/voxel_points.h"

#include <algorithm>

namespace backsight {

void VoxelPoints::Reserve(std::size_t voxels) {
  keys_.reserve(voxels);
  places_.reserve(voxels);
}

void VoxelPoints::Add(std::uint64_t key, const Eigen::Vector3d& point) {
  constexpr double kLast = kPlaces - 1.0;
  const Eigen::Vector3d corner = lattice_.Corner(VoxelLattice::Unpack(key));
  const Eigen::Array3d steps = (point - corner).array() * (kPlaces / lattice_.edge_m);
  const auto place = [&](int axis) {
    return static_cast<std::uint16_t>(std::clamp(steps[axis], 0.0, kLast));
  };
  keys_.push_back(key);
  places_.push_back({place(0), place(1), place(2)});
}

}  // namespace backsight
