#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace backsight {

/// Log odds of being occupied of 8 x 8 x 8 voxels in Morton order; NaN: unknown.
using OctomapBlock = std::array<float, 512>;

/// The bytes of an OctoMap file of octree type "OcTree" (Hornung et al. 2013, doi
/// 10.1007/s10514-012-9321-0), those that OctoMap 1.9 writes: inner nodes hold the largest value
/// below them, eight equal leaves become one. `keys` are the blocks' (VoxelBlocks), ascending;
/// `fill(i, values)` states the voxels of keys[i], of which at least one is known.
std::string OctomapBytes(double resolution_m, std::span<const std::uint64_t> keys,
                         const std::function<void(std::size_t i, OctomapBlock& values)>& fill);

}  // namespace backsight
