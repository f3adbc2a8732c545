#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace backsight {

/// Exact neighbour search among fixed 3D points (kd-tree, nanoflann). Queries are thread-safe.
class NeighborSearch {
 public:
  struct Neighbor {
    std::uint32_t index = 0;
    double distance_m = 0.0;
  };

  /// Keeps a copy of `points`. O(n log n).
  explicit NeighborSearch(std::span<const Eigen::Vector3d> points);
  ~NeighborSearch();
  NeighborSearch(NeighborSearch&&) noexcept;
  NeighborSearch& operator=(NeighborSearch&&) noexcept;

  /// The k nearest, nearest first; equal distances by index.
  std::vector<Neighbor> Nearest(const Eigen::Vector3d& query, std::size_t k) const;
  /// All within `radius_m` (closer than), nearest first; equal distances by index.
  std::vector<Neighbor> Within(const Eigen::Vector3d& query, double radius_m) const;

  std::size_t size() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace backsight
