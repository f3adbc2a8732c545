#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace backsight {

/// A rigid motion, row by row, in front of a lattice.
struct LatticeMotion {
  std::array<double, 9> rotation;
  std::array<double, 3> translation;
};

/// The cells of edge `edge_m` that moved points lie in, packed as VoxelLattice::Pack does.
/// `points`: x, y and z of one after another. The same bits on every instruction set.
void FindSubcells(const double* points, std::size_t count, const LatticeMotion& motion,
                  double edge_m, std::uint64_t* keys);

}  // namespace backsight
