#include "stages/map_grid.h"

namespace backsight {

MapGrid::MapGrid(double resolution_m) : resolution_m_(resolution_m), per_m_(1.0 / resolution_m) {}

std::optional<std::uint64_t> MapGrid::VoxelAt(const Eigen::Vector3f& point) const {
  std::array<std::uint16_t, 3> place{};
  for (int axis = 0; axis < 3; ++axis) {
    const double along = std::floor(per_m_ * static_cast<double>(point[axis])) + kMiddle;
    if (!(along >= 0.0 && along < 2.0 * kMiddle)) return std::nullopt;
    place[static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(along);
  }
  return Morton::Of(place);
}

Eigen::Vector3f MapGrid::CenterOf(std::uint64_t voxel) const {
  const auto place = Morton::Place(voxel);
  return Eigen::Vector3d(CenterOf(place[0]), CenterOf(place[1]), CenterOf(place[2])).cast<float>();
}

MapGrid::Walk MapGrid::Begin(const Eigen::Vector3f& from, const Eigen::Vector3f& to,
                             std::uint64_t voxel) const {
  const auto place = Morton::Place(voxel);
  const Eigen::Vector3f way = to - from;
  const float length = std::sqrt(way.x() * way.x() + way.y() * way.y() + way.z() * way.z());
  Walk walk;
  walk.length = static_cast<double>(length);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const auto along = static_cast<double>(way[i] / length);
    const std::uint64_t bits = Morton::kAxis << axis;
    walk.part[axis] = voxel & bits;
    // Subtracting all of the axis's bits adds one to them: the carry runs over the bits between.
    walk.step[axis] = std::uint64_t{0} - (along > 0.0 ? bits : std::uint64_t{1} << axis);
    walk.next[axis] = walk.between[axis] = std::numeric_limits<double>::max();
    if (along == 0.0) continue;
    const auto half = static_cast<float>((along > 0.0 ? 1.0 : -1.0) * resolution_m_ * 0.5);
    const double border = CenterOf(place[axis]) + static_cast<double>(half);
    walk.next[axis] = (border - static_cast<double>(from[i])) / along;
    walk.between[axis] = resolution_m_ / std::abs(along);
  }
  return walk;
}

}  // namespace backsight
