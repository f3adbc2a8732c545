#include "stages/descriptor_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "stages/descriptor_grid.h"

namespace backsight {
namespace {

constexpr std::size_t kTile = 256;  // columns whose bins stay in the first cache
constexpr std::int32_t kNoLimit = std::int32_t{1} << 30;

/// From distances to those of the grid, rounded so that nothing is missed.
struct Rounding {
  double steps_per_unit;
  double both_errors;   // of two descriptors together, steps
  double both_offsets;  // along the axes that the grid leaves out, likewise

  /// More than half the squared distance on the grid of what is no farther than this.
  std::int32_t HalfLimit(double squared) const {
    return HalfLimitOf(std::sqrt(squared) * steps_per_unit + both_errors);
  }
  /// The same from a half squared distance on the grid itself.
  std::int32_t HalfLimitFromGrid(double half_squared) const {
    const double on_grid = std::sqrt(2.0 * std::max(half_squared, 0.0));
    return HalfLimitOf(std::hypot(on_grid + both_errors, both_offsets) + both_errors);
  }

 private:
  static std::int32_t HalfLimitOf(double steps) {
    constexpr double kUp = 1.0 + 1e-9;  // for the roundings here
    const double half = 0.5 * steps * steps * kUp + 1.0;
    return half < kNoLimit ? static_cast<std::int32_t>(half) : kNoLimit;
  }
};

/// One side's lists of nearest neighbours, and what must be looked at to complete them.
class Lists {
 public:
  Lists(const GridView& own, std::size_t k, const Rounding& rounding,
        std::span<DescriptorNeighbor> neighbors)
      : k_(k), rounding_(rounding), neighbors_(neighbors), limits_(own.stride, 0) {
    std::fill_n(limits_.begin(), own.size, kNoLimit);
    std::fill(neighbors.begin(), neighbors.end(),
              DescriptorNeighbor{std::numeric_limits<double>::infinity(), 0});
  }

  const std::int32_t* limits() const { return limits_.data(); }

  /// Upper bounds from a part of the others: the k-th of as many classes' nearest.
  void Seed(const GridView& own, const GridView& others) {
    const std::size_t end = others.size / kSeedShare / kGridPadding * kGridPadding;
    if (end == 0 || k_ > kSeedClasses / 2) return;
    std::array<std::int32_t, kRowBlock * kSeedClasses> seeds{};
    for (std::size_t row = 0; row < own.size; row += kRowBlock) {
      FindSeeds(own, row, others, end, seeds);
      for (std::size_t r = 0; r < std::min(kRowBlock, own.size - row); ++r) {
        const auto begin = seeds.begin() + static_cast<std::ptrdiff_t>(r * kSeedClasses);
        const auto kth = begin + static_cast<std::ptrdiff_t>(k_ - 1);
        std::nth_element(begin, kth, begin + kSeedClasses, std::greater<>());
        limits_[row + r] = rounding_.HalfLimitFromGrid(1.0 - *kth);
      }
    }
  }

  void Offer(std::size_t own, double squared, std::size_t other) {
    DescriptorNeighbor* list = neighbors_.data() + own * k_;
    const DescriptorNeighbor offered{squared, static_cast<std::uint32_t>(other)};
    if (!IsBefore(offered, list[k_ - 1])) return;
    std::size_t place = k_ - 1;
    for (; place > 0 && IsBefore(offered, list[place - 1]); --place) list[place] = list[place - 1];
    list[place] = offered;
    if (std::isfinite(list[k_ - 1].squared)) {
      limits_[own] = std::min(limits_[own], rounding_.HalfLimit(list[k_ - 1].squared));
    }
  }

 private:
  static constexpr std::size_t kSeedShare = 8;

  static bool IsBefore(const DescriptorNeighbor& a, const DescriptorNeighbor& b) {
    return a.squared < b.squared || (a.squared == b.squared && a.index < b.index);
  }

  std::size_t k_;
  Rounding rounding_;
  std::span<DescriptorNeighbor> neighbors_;
  std::vector<std::int32_t> limits_;
};

/// Pairs of descriptors only, first; returns their number.
std::size_t DropPadding(std::span<GridPair> pairs, std::size_t rows, std::size_t columns) {
  const auto end = std::remove_if(pairs.begin(), pairs.end(), [&](const GridPair& pair) {
    return pair.row >= rows || pair.column >= columns;
  });
  return static_cast<std::size_t>(end - pairs.begin());
}

}  // namespace

void FindNearestDescriptors(std::span<const FpfhDescriptor> source,
                            std::span<const FpfhDescriptor> target, std::size_t k,
                            std::span<DescriptorNeighbor> of_source,
                            std::span<DescriptorNeighbor> of_target) {
  const DescriptorGridScale scale = MakeGridScale(source, target);
  const DescriptorGrid source_grid(source, scale);
  const DescriptorGrid target_grid(target, scale);
  const GridView a = source_grid.view();
  const GridView b = target_grid.view();
  const Rounding rounding{scale.steps_per_unit,
                          source_grid.largest_error() + target_grid.largest_error(),
                          source_grid.largest_offset() + target_grid.largest_offset()};
  Lists rows(a, k, rounding, of_source);
  Lists columns(b, k, rounding, of_target);
  rows.Seed(a, b);
  columns.Seed(b, a);
  std::vector<GridPair> found(kRowBlock * kTile);
  std::vector<double> squared(found.size());
  for (std::size_t begin = 0; begin < b.stride; begin += kTile) {
    const std::size_t end = std::min(begin + kTile, b.stride);
    for (std::size_t row = 0; row < a.size; row += kRowBlock) {
      std::size_t count =
          FindClose(a, row, b, begin, end, {rows.limits() + row, columns.limits()}, found.data());
      if (count == 0) continue;
      count = DropPadding(std::span(found).first(count), a.size, b.size);
      ComputeSquaredDistances(source.front().data(), target.front().data(),
                              std::span(found).first(count), squared.data());
      for (std::size_t n = 0; n < count; ++n) {
        rows.Offer(found[n].row, squared[n], found[n].column);
        columns.Offer(found[n].column, squared[n], found[n].row);
      }
    }
  }
}

}  // namespace backsight
