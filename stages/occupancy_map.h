#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "core/voxel_blocks.h"
#include "stages/moving_objects.h"

namespace backsight {

struct OccupancyMapOptions {
  double resolution_m = 0.2;  ///< edge of the voxels
  double scale = 1.0;         ///< of coordinates measured in the stations
  std::size_t memory_bytes = std::size_t{2} << 30U;
};

/// A set of the voxels of a block, by the last nine bits of their Morton codes.
using VoxelBits = std::array<std::uint64_t, 8>;

/// How many stations say what of the voxels of a map, by blocks; beyond seven they are not counted.
class OccupancyMap {
 public:
  /// A station measured something in the first voxels, and looked through the second.
  void AddOccupied(const VoxelBlocks<VoxelBits>& voxels) { Add(voxels, &Block::occupied); }
  void AddFree(const VoxelBlocks<VoxelBits>& voxels) { Add(voxels, &Block::free); }

  /// Of the blocks that hold known voxels, ascending.
  std::vector<std::uint64_t> Keys() const;
  /// Log odds of being occupied of the voxels of a block that the map holds, as OctoMap's default
  /// sensor model and clamping give them: of measurements where there are any, otherwise of looks
  /// through. NaN: unknown.
  void Fill(std::uint64_t key, std::array<float, 512>& log_odds) const;

  /// Memory of the map and, at most, of its file.
  std::size_t Bytes() const;

 private:
  using Counts = std::array<VoxelBits, 3>;  // binary digits, lowest first
  struct Block {
    Counts occupied{};
    Counts free{};
  };
  void Add(const VoxelBlocks<VoxelBits>& voxels, Counts Block::*counts);

  VoxelBlocks<Block> blocks_;
};

/// A map of occupied, free and unknown space from what placed stations measured, in the frame that
/// they share and the voxels of MapGrid.
///
/// A voxel is occupied where a station measured something that does not move, as often as stations
/// did; free where beams from the stations pass on their way there. Beams do not clear voxels that
/// hold a surface, however many graze it. `moving[s]` are the leaves of surfaces[s] that are left
/// out. Time about 5 ns per voxel that a beam crosses, with one beam per station and occupied
/// voxel; stations side by side. Throws InputError where the stations' points reach farther from
/// the frame's origin than the map's 32768 voxels, and where map and file would need more memory
/// than given.
OccupancyMap DrawOccupancyMap(const std::vector<PlacedSurface>& surfaces,
                              const std::vector<MovingLeaves>& moving,
                              const OccupancyMapOptions& options, const ExecutionContext& context);

}  // namespace backsight
