#include "stages/descriptor_groups.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace backsight {
namespace {

/// The closest pivot of every descriptor.
std::vector<std::uint32_t> ClosestPivots(const GridView& descriptors, const GridView& pivots) {
  std::vector<std::uint32_t> closest(descriptors.size);
  for (std::size_t row = 0; row < closest.size(); row += kRowBlock) {
    std::array<std::uint32_t, kRowBlock> of_block{};
    FindClosest(descriptors, row, pivots, of_block);
    std::copy_n(of_block.begin(), std::min(kRowBlock, closest.size() - row),
                closest.begin() + static_cast<std::ptrdiff_t>(row));
  }
  return closest;
}

/// Where the numbers of each value begin once they are sorted, and the end of all.
std::vector<std::size_t> Begins(const std::vector<std::uint32_t>& numbers, std::size_t values) {
  std::vector<std::size_t> begins(values + 1, 0);
  for (const std::uint32_t number : numbers) ++begins[number + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  return begins;
}

/// Places of the numbers, sorted by them.
std::vector<std::uint32_t> SortedPlaces(const std::vector<std::uint32_t>& numbers,
                                        std::vector<std::size_t> begins) {
  std::vector<std::uint32_t> places(numbers.size());
  for (std::uint32_t i = 0; i < numbers.size(); ++i) places[begins[numbers[i]]++] = i;
  return places;
}

}  // namespace

DescriptorGroups::DescriptorGroups(const DescriptorGrid& descriptors, const DescriptorGrid& pivots)
    : pivot_(ClosestPivots(descriptors.view(), pivots.view())),
      begins_(Begins(pivot_, pivots.view().size)),
      order_(SortedPlaces(pivot_, begins_)),
      grid_(descriptors.Chosen(order_)) {
  std::sort(pivot_.begin(), pivot_.end());
}

ColumnRange DescriptorGroups::Around(std::size_t pivot) const {
  constexpr std::size_t kFewest = 128;
  constexpr std::size_t kMost = 512;
  static_assert(kFewest % kGridPadding == 0 && kMost % kGridPadding == 0);
  const std::size_t whole = order_.size() / kGridPadding * kGridPadding;
  ColumnRange range;
  range.begin = std::min(begins_[pivot] / kGridPadding * kGridPadding, whole);
  const std::size_t padded = (begins_[pivot + 1] + kGridPadding - 1) / kGridPadding * kGridPadding;
  range.end = std::min(std::clamp(padded, range.begin + kFewest, range.begin + kMost), whole);
  range.begin = std::min(range.begin, range.end - std::min(range.end, kFewest));
  return range;
}

DescriptorGrid ChoosePivots(const DescriptorGrid& grid) {
  constexpr std::size_t kShare = 64;
  constexpr std::size_t kMost = 128;
  const std::size_t size = grid.view().size;
  const std::size_t count =
      std::clamp(size / kShare / kGridPadding * kGridPadding, kGridPadding, kMost);
  std::vector<std::uint32_t> places(count);
  for (std::size_t i = 0; i < count; ++i) places[i] = static_cast<std::uint32_t>(i * size / count);
  return grid.Chosen(places);
}

}  // namespace backsight
