#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/point_cluster.h"
#include "core/voxel_leaves.h"

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

/// Gathers streamed points into voxel clusters. Sums are formed relative to the voxel's corner, so
/// nothing cancels at large coordinates. The result is in the frame of the points, depends on their
/// order only by rounding and is sorted by key. Time O(points), memory 88 bytes and 8 to 16 more
/// per occupied voxel.
class VoxelClusterer {
 public:
  explicit VoxelClusterer(const VoxelLattice& lattice) : lattice_(lattice) {}

  /// `point` must lie within the lattice (VoxelLattice::Contains).
  void Add(const Eigen::Vector3d& point) {
    const Eigen::Vector3i cell = lattice_.Cell(point);
    Add(VoxelLattice::Pack(cell), point - lattice_.Corner(cell));
  }
  /// A point of the voxel `key`, `offset` from its corner.
  void Add(std::uint64_t key, const Eigen::Vector3d& offset);

  VoxelLeaves Finish() const;

 private:
  struct Sums {
    std::uint64_t key = 0;
    double count = 0.0;
    std::array<double, 3> first{};   // sum of d = point - corner
    std::array<double, 6> second{};  // sum of d d^T: xx xy xz yy yz zz
  };

  static constexpr std::uint32_t kNone = ~0U;
  PointCluster ClusterOf(const Sums& sums) const;
  std::uint32_t VoxelOf(std::uint64_t key);
  std::size_t SlotOf(std::uint64_t key) const;
  void Grow();

  VoxelLattice lattice_;
  // Voxels by the hash of their keys; a power of two, at most half of them taken.
  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(64, kNone);
  std::vector<Sums> sums_;
  std::uint64_t last_key_ = ~std::uint64_t{0};
  std::uint32_t last_voxel_ = 0;
};

}  // namespace backsight
