#pragma once

#include <cstddef>
#include <cstdint>

#include "core/kernel_motion.h"

namespace backsight {

/// The cells of edge `edge_m` that moved points lie in, packed as VoxelLattice::Pack does.
/// `points`: x, y and z of one after another. The same bits on every instruction set.
void FindSubcells(const double* points, std::size_t count, const KernelMotion& motion,
                  double edge_m, std::uint64_t* keys);

}  // namespace backsight
