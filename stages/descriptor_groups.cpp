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

/// Of the axes that the first pairs hold whole, the one along which these places differ most.
std::size_t WidestAxis(const GridView& grid, std::span<const std::uint32_t> places) {
  std::size_t widest = 0;
  double largest = -1.0;
  for (std::size_t axis = 0; axis + 1 < kFirstAxes; ++axis) {
    double sum = 0.0;
    double squares = 0.0;
    for (const std::uint32_t place : places) {
      const double x = CoordinateOf(grid, axis, place);
      sum += x;
      squares += x * x;
    }
    const double scatter = squares - sum * sum / static_cast<double>(places.size());
    if (scatter > largest) largest = scatter, widest = axis;
  }
  return widest;
}

/// Sorts places so that like ones are side by side: by halves along the widest axis.
void SortAlike(const GridView& grid, std::span<std::uint32_t> places) {
  if (places.size() < 3) return;
  const std::size_t axis = WidestAxis(grid, places);
  const std::size_t half = places.size() / 2;
  std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(half), places.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return CoordinateOf(grid, axis, a) < CoordinateOf(grid, axis, b);
                   });
  SortAlike(grid, places.first(half));
  SortAlike(grid, places.subspan(half));
}

}  // namespace

DescriptorGroups::DescriptorGroups(const DescriptorGrid& descriptors, const DescriptorGrid& pivots)
    : pivot_(ClosestPivots(descriptors.view(), pivots.view())),
      begins_(Begins(pivot_, pivots.view().size)),
      order_(SortedPlaces(pivot_, begins_)),
      grid_(descriptors.Chosen(order_)) {
  const auto at = [this](std::size_t pivot) {
    return pivot_.begin() + static_cast<std::ptrdiff_t>(begins_[pivot]);
  };
  for (std::uint32_t pivot = 0; pivot + 1 < begins_.size(); ++pivot) {
    std::fill(at(pivot), at(pivot + 1), pivot);
  }
}

ColumnRange DescriptorGroups::Around(std::size_t pivot) const {
  constexpr std::size_t kWidth = 256;
  static_assert(kWidth % kGridPadding == 0);
  const std::size_t whole = order_.size() / kGridPadding * kGridPadding;
  const std::size_t width = std::min(kWidth, whole);
  const std::size_t middle = (begins_[pivot] + begins_[pivot + 1]) / 2;
  const std::size_t first = middle - std::min(middle, width / 2);
  const std::size_t begin =
      std::min((first + kGridPadding / 2) / kGridPadding * kGridPadding, whole - width);
  return {begin, begin + width};
}

DescriptorGrid ChoosePivots(const DescriptorGrid& grid) {
  constexpr std::size_t kShare = 32;
  constexpr std::size_t kMost = 256;
  const std::size_t size = grid.view().size;
  const std::size_t count =
      std::clamp(size / kShare / kGridPadding * kGridPadding, kGridPadding, kMost);
  std::vector<std::uint32_t> places(count);
  for (std::size_t i = 0; i < count; ++i) places[i] = static_cast<std::uint32_t>(i * size / count);
  SortAlike(grid.view(), places);
  return grid.Chosen(places);
}

}  // namespace backsight
