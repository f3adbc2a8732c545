#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace backsight {

/// Integer cell of a cubic lattice and its packed form: 21 bits per axis, so coordinates up to
/// +-2^20 cells (104 km at 0.1 m). Packed keys sort by x, then y, then z.
struct VoxelLattice {
  double edge_m = 0.1;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  static constexpr std::int64_t kHalfRange = std::int64_t{1} << 20;

  Eigen::Vector3i Cell(const Eigen::Vector3d& point) const {
    return ((point - origin) / edge_m).array().floor().cast<int>();
  }
  /// True if the point's cell fits the packed key.
  bool Contains(const Eigen::Vector3d& point) const {
    return ((point - origin).array().abs() < edge_m * static_cast<double>(kHalfRange - 2)).all();
  }
  std::uint64_t Key(const Eigen::Vector3d& point) const { return Pack(Cell(point)); }
  Eigen::Vector3d Corner(const Eigen::Vector3i& cell) const {
    return origin + edge_m * cell.cast<double>();
  }

  bool operator==(const VoxelLattice& other) const {
    return edge_m == other.edge_m && origin == other.origin;
  }

  static std::uint64_t Pack(const Eigen::Vector3i& cell) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + kHalfRange) & 0x1FFFFFU; };
    return part(cell.x()) << 42U | part(cell.y()) << 21U | part(cell.z());
  }
  static Eigen::Vector3i Unpack(std::uint64_t key) {
    const auto part = [](std::uint64_t k) {
      return static_cast<int>(static_cast<std::int64_t>(k & 0x1FFFFFU) - kHalfRange);
    };
    return {part(key >> 42U), part(key >> 21U), part(key)};
  }
};

template <class Archive>
void Transfer(Archive& archive, VoxelLattice& lattice) {
  archive(lattice.edge_m, lattice.origin);
}

}  // namespace backsight
