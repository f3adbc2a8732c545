#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace backsight {

/// Descriptors as the kernel takes them: bins of `rows` descriptors, and the sum of each one's
/// squares.
struct DescriptorRows {
  const float* bins;  ///< row by row, kDescriptorBins each
  const float* squares;
  std::size_t rows;
};

/// The same, bin by bin: bin k of descriptor j at bins[k * stride + j]. Readable, for every bin and
/// for `squares`, up to `stride`, a multiple of 16 that is no less than `columns`.
struct DescriptorColumns {
  const float* bins;
  const float* squares;
  std::size_t columns;
  std::size_t stride;
};

inline constexpr std::size_t kDescriptorBins = 33;

/// Squared distance and index of the descriptor of the other side.
struct DescriptorNeighbor {
  float squared;
  std::uint32_t index;
};

/// The k nearest of the other side for every row and every column, ascending, equal distances by
/// index; places beyond the other side's number hold infinity. Squared distances are |a|^2 + |b|^2
/// - 2 a.b with the product summed bin by bin: the same bits with every instruction set. Most
/// distances are only compared, a vector at a time, with the k-th so far. Time O(rows * columns).
void FindNearestDescriptors(const DescriptorRows& rows, const DescriptorColumns& columns,
                            std::size_t k, std::span<DescriptorNeighbor> of_rows,
                            std::span<DescriptorNeighbor> of_columns);

}  // namespace backsight
