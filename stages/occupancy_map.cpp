#include "stages/occupancy_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.h"
#include "stages/map_grid.h"

namespace backsight {
namespace {

constexpr std::size_t kMostCounted = 7;
using LogOdds = std::array<float, kMostCounted + 1>;  // by how many stations say so

/// Log odds of so many observations of probability `each`, which stay within those of 0.1192 and
/// 0.971; in single precision, as OctoMap adds them.
LogOdds Repeated(double each) {
  const auto log_odds = [](double p) { return static_cast<float>(std::log(p / (1.0 - p))); };
  LogOdds sums{};
  for (std::size_t n = 1; n < sums.size(); ++n) {
    sums[n] = std::clamp(sums[n - 1] + log_odds(each), log_odds(0.1192), log_odds(0.971));
  }
  return sums;
}

void Insert(std::uint64_t voxel, VoxelBits* bits) {
  (*bits)[voxel >> 6U & 7U] |= std::uint64_t{1} << (voxel & 63U);
}

template <class Visit>
void VisitVoxels(std::uint64_t key, const VoxelBits& bits, Visit visit) {
  for (std::size_t word = 0; word < bits.size(); ++word) {
    for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1) {
      visit(key << VoxelBlocks<VoxelBits>::kVoxelBits | word << 6U |
            static_cast<std::uint64_t>(std::countr_zero(rest)));
    }
  }
}

/// Where a station measured what stands still.
struct StillVoxels {
  VoxelBlocks<VoxelBits> voxels;
  std::optional<double> outside_m;  // from the origin of a point that lies outside the map
};

StillVoxels FindStillVoxels(const MapGrid& grid, const PlacedSurface& placed,
                            const MovingLeaves& moving, double scale) {
  StillVoxels still;
  const auto& leaves = placed.surface.model.leaves;
  auto next_moving = moving.leaves.begin();
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    next_moving = std::find_if(next_moving, moving.leaves.end(), [&](auto m) { return m >= i; });
    if (next_moving != moving.leaves.end() && *next_moving == i) continue;
    const Eigen::Vector3d point = placed.frame_from_instrument * (scale * leaves.Mean(i));
    const auto voxel = grid.VoxelAt(point.cast<float>());
    if (voxel) {
      Insert(*voxel, &still.voxels.At(*voxel >> VoxelBlocks<VoxelBits>::kVoxelBits));
    } else {
      still.outside_m = point.norm();
    }
  }
  return still;
}

void RequireInside(const std::vector<StillVoxels>& still, double resolution_m) {
  for (const StillVoxels& station : still) {
    if (!station.outside_m) continue;
    throw InputError({"outputs.map",
                      fmt::format("resolution_m: {} for points {:.0f} m from the frame's origin",
                                  resolution_m, *station.outside_m),
                      "points within 32768 voxels of it", "state a coarser resolution_m"});
  }
}

void RequireMemory(std::size_t needed, const OccupancyMapOptions& options) {
  if (needed <= options.memory_bytes) return;
  throw InputError({"outputs.map",
                    fmt::format("resolution_m: {} needs more than {} MB of memory",
                                options.resolution_m, options.memory_bytes >> 20U),
                    "a map that fits", "state a coarser resolution_m, or map: none"});
}

/// The voxels that the beams cross from the station to the centres of `ends`.
VoxelBlocks<VoxelBits> FindCrossedVoxels(const MapGrid& grid, const Eigen::Vector3f& station,
                                         const VoxelBlocks<VoxelBits>& ends,
                                         const OccupancyMapOptions& options,
                                         const ExecutionContext& context) {
  VoxelBlocks<VoxelBits> crossed;
  std::uint64_t key = ~std::uint64_t{0};
  VoxelBits* bits = nullptr;
  const auto cross = [&](std::uint64_t voxel) {
    if (voxel >> VoxelBlocks<VoxelBits>::kVoxelBits != key) {
      key = voxel >> VoxelBlocks<VoxelBits>::kVoxelBits;
      bits = &crossed.At(key);
    }
    Insert(voxel, bits);
  };
  for (std::size_t i = 0; i < ends.size(); ++i) {
    context.CheckStop();
    RequireMemory(crossed.Bytes(), options);
    VisitVoxels(ends.keys()[i], ends.blocks()[i],
                [&](std::uint64_t end) { grid.VisitBeam(station, grid.CenterOf(end), cross); });
  }
  return crossed;
}

}  // namespace

void OccupancyMap::Add(const VoxelBlocks<VoxelBits>& voxels, Counts Block::*counts) {
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    Counts& sum = blocks_.At(voxels.keys()[i]).*counts;
    for (std::size_t word = 0; word < voxels.blocks()[i].size(); ++word) {
      const std::uint64_t full = sum[0][word] & sum[1][word] & sum[2][word];
      std::uint64_t carry = voxels.blocks()[i][word] & ~full;
      for (VoxelBits& digit : sum) {
        const std::uint64_t before = digit[word];
        digit[word] ^= carry;
        carry &= before;
      }
    }
  }
}

std::vector<std::uint64_t> OccupancyMap::Keys() const {
  std::vector<std::uint64_t> keys = blocks_.keys();
  std::sort(keys.begin(), keys.end());
  return keys;
}

void OccupancyMap::Fill(std::uint64_t key, std::array<float, 512>& log_odds) const {
  static const LogOdds kOccupied = Repeated(0.7);
  static const LogOdds kFree = [] {
    LogOdds odds = Repeated(0.4);
    odds[0] = std::numeric_limits<float>::quiet_NaN();
    return odds;
  }();
  const Block& block = *blocks_.Find(key);
  for (std::size_t voxel = 0; voxel < log_odds.size(); ++voxel) {
    const auto count = [&](const Counts& counts) {
      std::size_t sum = 0;
      for (std::size_t digit = 0; digit < counts.size(); ++digit) {
        sum |= (counts[digit][voxel >> 6U] >> (voxel & 63U) & 1U) << digit;
      }
      return sum;
    };
    const std::size_t measured = count(block.occupied);
    log_odds[voxel] = measured > 0 ? kOccupied[measured] : kFree[count(block.free)];
  }
}

std::size_t OccupancyMap::Bytes() const {
  constexpr std::size_t kNodeBytes = 5;
  constexpr std::size_t kInnerNodes = 1 + 8 + 64 + 10;  // of a block, and on the way to it
  std::size_t known = 0;
  for (const Block& block : blocks_.blocks()) {
    for (std::size_t word = 0; word < 8; ++word) {
      std::uint64_t any = 0;
      for (std::size_t digit = 0; digit < 3; ++digit) {
        any |= block.occupied[digit][word] | block.free[digit][word];
      }
      known += static_cast<std::size_t>(std::popcount(any));
    }
  }
  return blocks_.Bytes() + kNodeBytes * (known + kInnerNodes * blocks_.size());
}

OccupancyMap DrawOccupancyMap(const std::vector<PlacedSurface>& surfaces,
                              const std::vector<MovingLeaves>& moving,
                              const OccupancyMapOptions& options, const ExecutionContext& context) {
  const MapGrid grid(options.resolution_m);
  OccupancyMap map;
  std::vector<StillVoxels> still(surfaces.size());
  context.ParallelFor(surfaces.size(), [&](std::size_t s) {
    still[s] = FindStillVoxels(grid, surfaces[s], moving[s], options.scale);
  });
  RequireInside(still, options.resolution_m);
  for (const StillVoxels& station : still) map.AddOccupied(station.voxels);
  RequireMemory(map.Bytes(), options);
  // Few stations at a time, each within its share whatever the number of threads, so that memory
  // and verdict do not depend on it.
  constexpr std::size_t kTogether = 4;
  OccupancyMapOptions share = options;
  share.memory_bytes /= kTogether;
  for (std::size_t first = 0; first < surfaces.size(); first += kTogether) {
    const std::size_t count = std::min(kTogether, surfaces.size() - first);
    std::vector<VoxelBlocks<VoxelBits>> crossed(count);
    context.ParallelFor(count, [&](std::size_t k) {
      const PlacedSurface& viewer = surfaces[first + k];
      if (!viewer.surface.scanner_credible) return;
      const Eigen::Vector3f station = viewer.frame_from_instrument.translation.cast<float>();
      crossed[k] = FindCrossedVoxels(grid, station, still[first + k].voxels, share, context);
    });
    for (const VoxelBlocks<VoxelBits>& voxels : crossed) map.AddFree(voxels);
    RequireMemory(map.Bytes(), options);
  }
  return map;
}

}  // namespace backsight
