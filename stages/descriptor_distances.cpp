#include "stages/descriptor_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "stages/descriptor_groups.h"

namespace backsight {
namespace {

constexpr DescriptorNeighbor kNoNeighbor{std::numeric_limits<double>::infinity(), 0};

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
    const double at_most = on_grid + both_errors;
    return HalfLimitOf(std::sqrt(at_most * at_most + both_offsets * both_offsets) + both_errors);
  }

 private:
  static std::int32_t HalfLimitOf(double steps) {
    constexpr double kUp = 1.0 + 1e-9;  // for the roundings here
    const double half = 0.5 * steps * steps * kUp + 1.0;
    return half < kNoLimit ? static_cast<std::int32_t>(half) : kNoLimit;
  }
};

/// The k-th largest, 1 <= k <= size: no more than k - 1 are larger.
std::int32_t KthLargest(std::span<const std::int32_t, kSeedClasses> values, std::size_t k) {
  std::int32_t kth = std::numeric_limits<std::int32_t>::max();
  for (const std::int32_t value : values) {
    std::int32_t larger = 0;
    for (const std::int32_t other : values) larger += other > value ? 1 : 0;
    kth = larger < static_cast<std::int32_t>(k) ? std::min(kth, value) : kth;
  }
  return kth;
}

/// One side's lists of nearest neighbours, and what must be looked at to complete them.
class Lists {
 public:
  Lists(const DescriptorGroups& own, std::size_t k, const Rounding& rounding,
        std::span<DescriptorNeighbor> neighbors)
      : own_(own),
        k_(k),
        rounding_(rounding),
        neighbors_(neighbors),
        limits_(own.grid().view().stride, 0) {
    std::fill_n(limits_.begin(), own.order().size(), kNoLimit);
    std::fill(neighbors.begin(), neighbors.end(), kNoNeighbor);
  }

  const std::int32_t* limits() const { return limits_.data(); }

  /// Upper bounds from those of the others that have the same pivot: the k-th of as many classes'
  /// nearest.
  void Seed(const DescriptorGroups& others) {
    if (k_ > kSeedClasses / 2) return;
    std::array<std::int32_t, kRowBlock * kSeedClasses> seeds{};
    const std::size_t size = own_.order().size();
    for (std::size_t row = 0; row < size; row += kRowBlock) {
      const ColumnRange range = others.Around(own_.PivotOf(row));
      if (range.begin == range.end) return;
      FindSeeds(own_.grid().view(), row, others.grid().view(), range.begin, range.end, seeds);
      for (std::size_t r = 0; r < std::min(kRowBlock, size - row); ++r) {
        const std::int32_t kth =
            KthLargest(std::span(seeds).subspan(r * kSeedClasses).first<kSeedClasses>(), k_);
        limits_[row + r] = rounding_.HalfLimitFromGrid(1.0 - kth);
      }
    }
  }

  /// `other` by its number before it was grouped.
  void Offer(std::size_t own, double squared, std::uint32_t other) {
    DescriptorNeighbor* list = neighbors_.data() + own_.order()[own] * k_;
    const DescriptorNeighbor offered{squared, other};
    if (!IsBefore(offered, list[k_ - 1])) return;
    std::size_t place = k_ - 1;
    for (; place > 0 && IsBefore(offered, list[place - 1]); --place) list[place] = list[place - 1];
    list[place] = offered;
    if (std::isfinite(list[k_ - 1].squared)) {
      limits_[own] = std::min(limits_[own], rounding_.HalfLimit(list[k_ - 1].squared));
    }
  }

 private:
  static bool IsBefore(const DescriptorNeighbor& a, const DescriptorNeighbor& b) {
    return a.squared < b.squared || (a.squared == b.squared && a.index < b.index);
  }

  const DescriptorGroups& own_;
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

/// Compares all pairs of the two sides that are close enough.
class Comparison {
 public:
  Comparison(std::span<const FpfhDescriptor> source, std::span<const FpfhDescriptor> target,
             const DescriptorGroups& rows, const DescriptorGroups& columns)
      : source_(source),
        target_(target),
        rows_(rows),
        columns_(columns),
        found_(kRowBlock * kTile),
        originals_(found_.size()),
        squared_(found_.size()) {}

  void Run(Lists* of_rows, Lists* of_columns) {
    const std::size_t stride = columns_.grid().view().stride;
    for (std::size_t begin = 0; begin < stride; begin += kTile) {
      const std::size_t end = std::min(begin + kTile, stride);
      for (std::size_t row = 0; row < rows_.order().size(); row += kRowBlock) {
        const std::size_t count = Find(row, begin, end, *of_rows, *of_columns);
        for (std::size_t n = 0; n < count; ++n) {
          of_rows->Offer(found_[n].row, squared_[n], originals_[n].column);
          of_columns->Offer(found_[n].column, squared_[n], originals_[n].row);
        }
      }
    }
  }

 private:
  /// Close pairs of a block of rows with a tile of columns, and their distances.
  std::size_t Find(std::size_t row, std::size_t begin, std::size_t end, const Lists& of_rows,
                   const Lists& of_columns) {
    const GridView rows = rows_.grid().view();
    const GridView columns = columns_.grid().view();
    std::size_t count = FindClose(rows, row, columns, begin, end,
                                  {of_rows.limits() + row, of_columns.limits()}, found_.data());
    if (count == 0) return 0;
    count = DropPadding(std::span(found_).first(count), rows.size, columns.size);
    for (std::size_t n = 0; n < count; ++n) {
      originals_[n] = {rows_.order()[found_[n].row], columns_.order()[found_[n].column]};
    }
    ComputeSquaredDistances(source_.front().data(), target_.front().data(),
                            std::span(originals_).first(count), squared_.data());
    return count;
  }

  std::span<const FpfhDescriptor> source_, target_;
  const DescriptorGroups& rows_;
  const DescriptorGroups& columns_;
  std::vector<GridPair> found_;
  std::vector<GridPair> originals_;  // the same by their numbers before they were grouped
  std::vector<double> squared_;
};

}  // namespace

void FindNearestDescriptors(std::span<const FpfhDescriptor> source,
                            std::span<const FpfhDescriptor> target, std::size_t k,
                            std::span<DescriptorNeighbor> of_source,
                            std::span<DescriptorNeighbor> of_target) {
  if (source.empty() || target.empty()) {
    std::fill(of_source.begin(), of_source.end(), kNoNeighbor);
    std::fill(of_target.begin(), of_target.end(), kNoNeighbor);
    return;
  }
  const DescriptorGridScale scale = MakeGridScale(source, target);
  const DescriptorGrid source_grid(source, scale);
  const DescriptorGrid target_grid(target, scale);
  const DescriptorGrid pivots = ChoosePivots(target_grid);
  const DescriptorGroups rows(source_grid, pivots);
  const DescriptorGroups columns(target_grid, pivots);
  const Rounding rounding{scale.steps_per_unit,
                          source_grid.largest_error() + target_grid.largest_error(),
                          source_grid.largest_offset() + target_grid.largest_offset()};
  Lists of_rows(rows, k, rounding, of_source);
  Lists of_columns(columns, k, rounding, of_target);
  of_rows.Seed(columns);
  of_columns.Seed(rows);
  Comparison(source, target, rows, columns).Run(&of_rows, &of_columns);
}

}  // namespace backsight
