#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "core/archive.h"
#include "core/voxel_lattice.h"

namespace backsight {

/// One point in each of some voxels of a lattice, in 14 bytes instead of 32: the voxel's key
/// (VoxelLattice::Pack) and, along each axis, in which 65,536th of its edge the point lies. A point
/// that is given back is the middle of these. So it lies within its voxel and at most 2^-17 edges
/// beside where it was along each axis (0.8 um in voxels of 0.1 m), but for the rounding of
/// doubles.
class VoxelPoints {
 public:
  VoxelPoints() = default;
  explicit VoxelPoints(const VoxelLattice& lattice) : lattice_(lattice) {}

  const VoxelLattice& lattice() const { return lattice_; }
  std::size_t size() const { return keys_.size(); }
  void Reserve(std::size_t voxels);
  /// A point that rounding has brought out of the voxel `key` is put to its face.
  void Add(std::uint64_t key, const Eigen::Vector3d& point);
  /// Moves all points, and the lattice with them.
  void Translate(const Eigen::Vector3d& by) { lattice_.origin += by; }

  std::uint64_t Key(std::size_t i) const { return keys_[i]; }
  std::span<const std::uint64_t> keys() const { return keys_; }
  Eigen::Vector3d operator[](std::size_t i) const {
    const Eigen::Vector3i cell = VoxelLattice::Unpack(keys_[i]);
    const Places& places = places_[i];
    const auto along = [&](int axis) {
      const double in_cell = (places[static_cast<std::size_t>(axis)] + 0.5) / kPlaces;
      return lattice_.origin[axis] + lattice_.edge_m * (cell[axis] + in_cell);
    };
    return {along(0), along(1), along(2)};
  }
  class DistanceFrom;

  class Iterator;
  Iterator begin() const;
  Iterator end() const;

  template <class Archive>
  friend void Transfer(Archive& archive, VoxelPoints& points) {
    archive(points.lattice_, points.keys_, points.places_);
    if constexpr (Archive::kReads) {
      if (points.places_.size() != points.size()) throw DamagedArchive();
    }
  }

 private:
  friend class VoxelLeaves;  // which merges columns
  using Places = std::array<std::uint16_t, 3>;
  static constexpr int kPlaces = 1 << 16;  // along an edge

  VoxelLattice lattice_;
  std::vector<std::uint64_t> keys_;
  std::vector<Places> places_;
};

/// Squared distances of points from a query, found without their positions.
class VoxelPoints::DistanceFrom {
 public:
  /// `points` must outlive it. The query lies in `cell`, at `in_cell` edges from its corner.
  DistanceFrom(const VoxelPoints& points, const Eigen::Vector3i& cell,
               const Eigen::Vector3d& in_cell)
      : points_(points),
        cell_(cell),
        place_(in_cell * kPlaces - Eigen::Vector3d::Constant(0.5)),
        place_m_(points.lattice_.edge_m / kPlaces) {}

  /// In m^2, of point i, whose cell is `cell`.
  double Squared(const Eigen::Vector3i& cell, std::size_t i) const {
    const Places& places = points_.places_[i];
    const auto along = [&](int axis) {
      const auto cells = static_cast<std::int64_t>(cell[axis] - cell_[axis]);
      const auto at = cells * kPlaces + places[static_cast<std::size_t>(axis)];
      return static_cast<double>(at) - place_[axis];
    };
    const double x = along(0), y = along(1), z = along(2);
    return (x * x + y * y + z * z) * (place_m_ * place_m_);
  }

 private:
  const VoxelPoints& points_;
  Eigen::Vector3i cell_;  // of the query
  Eigen::Vector3d
      place_;  // of the query from its cell's corner, from the middle of the first place
  double place_m_;
};

class VoxelPoints::Iterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = Eigen::Vector3d;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = Eigen::Vector3d;

  Iterator(const VoxelPoints& points, std::size_t at) : points_(&points), at_(at) {}
  Eigen::Vector3d operator*() const { return (*points_)[at_]; }
  Iterator& operator++() { return ++at_, *this; }
  Iterator operator++(int) { return {*points_, at_++}; }
  bool operator==(const Iterator& other) const { return at_ == other.at_; }

 private:
  const VoxelPoints* points_;
  std::size_t at_;
};

inline VoxelPoints::Iterator VoxelPoints::begin() const { return {*this, 0}; }
inline VoxelPoints::Iterator VoxelPoints::end() const { return {*this, size()}; }

}  // namespace backsight
