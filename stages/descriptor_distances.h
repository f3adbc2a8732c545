#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "stages/station_model.h"

namespace backsight {

/// Squared distance and index of the descriptor of the other side.
struct DescriptorNeighbor {
  double squared;
  std::uint32_t index;
};

/// Descriptors are finite. The k nearest of the other side for every source and every target, k
/// places each, ascending by the sum of the squared differences of all bins in double, equal
/// distances by index; places beyond the other side's number hold infinity. Exact: products in
/// integers only rule out, by bounds that hold with their rounding, what cannot be among them.
/// First bounds come from descriptors that have the same closest pivot. The same on all instruction
/// sets. Time O(sources * targets); both sides' lists come from the same products.
void FindNearestDescriptors(std::span<const FpfhDescriptor> source,
                            std::span<const FpfhDescriptor> target, std::size_t k,
                            std::span<DescriptorNeighbor> of_source,
                            std::span<DescriptorNeighbor> of_target);

}  // namespace backsight
