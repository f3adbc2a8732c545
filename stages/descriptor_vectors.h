#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

inline constexpr std::size_t kDescriptorBins = 33;
inline constexpr std::size_t kDescriptorAxes = 31;
inline constexpr std::size_t kFrameStride = 32;

/// An origin and orthonormal axes.
struct DescriptorFrame {
  const double* origin;  ///< kDescriptorBins
  const double* basis;   ///< bin b's part along axis a at basis[b * kFrameStride + a]; zeros beyond
};

/// Coordinates of `count` descriptors, kDescriptorBins floats each, in the frame: axis a of
/// descriptor i at turned[i * kFrameStride + a], zeros beyond the axes. The same on all instruction
/// sets. `turned` has room for a multiple of kTurnedTogether descriptors.
void TurnDescriptors(const float* descriptors, std::size_t count, const DescriptorFrame& frame,
                     double* turned);
inline constexpr std::size_t kTurnedTogether = 4;

/// Sums of squared differences of all bins of `count` pairs, kDescriptorBins floats each. They are
/// summed in eight lanes, so that the bits are the same on all instruction sets.
void ComputeSquaredDistances(const float* rows, const float* columns,
                             const std::uint32_t* found_rows, const std::uint32_t* found_columns,
                             std::size_t count, double* squared);

}  // namespace backsight
