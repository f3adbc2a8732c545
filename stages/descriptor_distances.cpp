#include "stages/descriptor_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/cache_line_vector.h"
#include "stages/descriptor_boxes.h"
#include "stages/descriptor_groups.h"
#include "stages/descriptor_vectors.h"
#include "stages/nearest_lists.h"

namespace backsight {
namespace {

constexpr DescriptorNeighbor kNoNeighbor{std::numeric_limits<double>::infinity(), 0};

constexpr std::int32_t kNoLimit = std::int32_t{1} << 30;

/// From distances to those of the grid, rounded so that nothing is missed.
class Rounding {
 public:
  Rounding(const DescriptorGridScale& scale, const DescriptorGrid& a, const DescriptorGrid& b)
      : both_errors_(a.largest_error() + b.largest_error()),
        both_offsets_(a.largest_offset() + b.largest_offset()),
        slope_(scale.steps_per_unit * scale.steps_per_unit * (1.0 + both_errors_ / kUsual)),
        intercept_(both_errors_ * (both_errors_ + kUsual)) {}

  /// More than half the squared distance on the grid of what is no farther than this: of x steps,
  /// (x + e)^2 = x^2 + 2 e x + e^2, where 2 x <= x^2 / c + c for all c, so that no root is taken.
  std::int32_t HalfLimit(double squared) const {
    return HalfLimitOf(squared * slope_ + intercept_);
  }
  /// The same from a half squared distance on the grid itself.
  std::int32_t HalfLimitFromGrid(double half_squared) const {
    const double on_grid = std::sqrt(2.0 * std::max(half_squared, 0.0));
    const double at_most = on_grid + both_errors_;
    const double steps =
        std::sqrt(at_most * at_most + both_offsets_ * both_offsets_) + both_errors_;
    return HalfLimitOf(steps * steps);
  }

 private:
  static std::int32_t HalfLimitOf(double squared_steps) {
    constexpr double kUp = 1.0 + 1e-9;  // for the roundings here
    const double half = 0.5 * kUp * squared_steps + 1.0;
    return static_cast<std::int32_t>(std::min(half, static_cast<double>(kNoLimit)));
  }

  static constexpr double kUsual = 4000.0;  // c, steps
  double both_errors_;                      // of two descriptors together, steps
  double both_offsets_;                     // along the axes that the grid leaves out, likewise
  double slope_, intercept_;
};

/// One side's lists of nearest neighbours, and what must be looked at to complete them.
class Lists {
 public:
  Lists(const DescriptorGroups& own, std::size_t k, const Rounding& rounding)
      : own_(own),
        k_(k),
        rounding_(rounding),
        nearest_(own.order().size(), k),
        limits_(own.grid().view().stride, 0) {
    std::fill_n(limits_.begin(), own.order().size(), kNoLimit);
  }

  const std::int32_t* limits() const { return limits_.data(); }

  /// Upper bounds from those of the others that are grouped about the same pivot.
  void Seed(const DescriptorGroups& others) {
    if (k_ > kSeedClasses / 2) return;
    std::array<std::int32_t, kRowBlock> kth{};
    const std::size_t size = own_.order().size();
    for (std::size_t row = 0; row < size; row += kRowBlock) {
      const ColumnRange range = others.Around(own_.PivotOf(row));
      if (range.begin == range.end) return;
      FindSeeds(own_.grid().view(), row, others.grid().view(), range.begin, range.end, k_, kth);
      for (std::size_t r = 0; r < std::min(kRowBlock, size - row); ++r) {
        limits_[row + r] = rounding_.HalfLimitFromGrid(1.0 - kth[r]);
      }
    }
  }

  /// `others` by their numbers before they were grouped. The limits stay.
  void Offer(std::span<const std::uint32_t> own, std::span<const double> squared,
             std::span<const std::uint32_t> others) {
    nearest_.Offer(own, squared, others);
  }
  /// The limit of a list by the farthest that it holds.
  void Tighten(std::size_t n) {
    limits_[n] = std::min(limits_[n], rounding_.HalfLimit(nearest_.Squared(n, k_ - 1)));
  }

  /// The lists by their descriptors' numbers before they were grouped.
  void Write(std::span<DescriptorNeighbor> neighbors) const {
    for (std::size_t i = 0; i < own_.order().size(); ++i) {
      DescriptorNeighbor* list = neighbors.data() + own_.order()[i] * k_;
      for (std::size_t n = 0; n < k_; ++n)
        list[n] = {nearest_.Squared(i, n), nearest_.Number(i, n)};
    }
  }

 private:
  const DescriptorGroups& own_;
  std::size_t k_;
  Rounding rounding_;
  NearestLists nearest_;
  CacheLineVector<std::int32_t> limits_;
};

/// Whether to rule out by the first axes before all are compared: not where they have ruled out
/// little.
class FirstAxes {
 public:
  bool AreWorthIt() const { return columns_ < kTrial || 3 * compared_ < 2 * columns_; }
  void Count(std::size_t columns, std::size_t compared) {
    columns_ += columns;
    compared_ += compared;
  }

 private:
  static constexpr std::size_t kTrial = 32768;
  std::size_t columns_ = 0;
  std::size_t compared_ = 0;  // along all axes
};

/// Compares all pairs of the two sides that are close enough.
class Comparison {
 public:
  Comparison(std::span<const FpfhDescriptor> source, std::span<const FpfhDescriptor> target,
             const DescriptorGroups& rows, const DescriptorGroups& columns)
      : source_(source),
        target_(target),
        rows_(rows),
        columns_(columns),
        boxes_(columns.grid().view()),
        found_rows_(kFoundRoom),
        found_columns_(kFoundRoom),
        original_rows_(kFoundRoom),
        original_columns_(kFoundRoom),
        squared_(kFoundRoom) {}

  void Run(Lists* of_rows, Lists* of_columns) {
    const std::size_t panels = columns_.grid().view().stride / kGridPadding;
    for (std::size_t begin = 0; begin < panels; begin += kMostPanels) {
      RunPanels(begin, std::min(begin + kMostPanels, panels), of_rows, of_columns);
    }
  }

 private:
  static_assert(kMostPanels % kMostLanes == 0);  // as FindNear() wants it
  void RunPanels(std::size_t begin, std::size_t end, Lists* of_rows, Lists* of_columns) {
    constexpr std::size_t kRowsWithSameLimits = 16 * kRowBlock;
    for (std::size_t row = 0; row < rows_.order().size(); row += kRowBlock) {
      if (row % kRowsWithSameLimits == 0) boxes_.SetLimits(of_columns->limits(), begin, end);
      const bool worth_it = first_axes_.AreWorthIt();
      const GridLimits limits{of_rows->limits() + row, of_columns->limits()};
      const CloseCount found =
          FindClose(rows_.grid().view(), row, columns_.grid().view(),
                    Panels(row, *std::max_element(limits.rows, limits.rows + kRowBlock), begin, end,
                           worth_it),
                    limits, worth_it, {found_rows_.data(), found_columns_.data()});
      if (worth_it) first_axes_.Count((end - begin) * kGridPadding, found.columns);
      if (found.pairs == 0) continue;
      const std::size_t count = DropPadding(found.pairs);
      Offer(count, of_rows, of_columns);
      const std::size_t rows = std::min(kRowBlock, rows_.order().size() - row);
      for (std::size_t r = 0; r < rows; ++r) of_rows->Tighten(row + r);
      for (std::size_t n = 0; n < count; ++n) of_columns->Tighten(found_columns_[n]);
    }
  }

  /// Of [begin, end) those near a block of rows, or all.
  std::span<const std::uint32_t> Panels(std::size_t row, std::int32_t row_limit, std::size_t begin,
                                        std::size_t end, bool near_ones) {
    std::size_t count = end - begin;
    if (near_ones) {
      count = boxes_.FindNear(rows_.grid().view(), row, row_limit, begin, end, panels_.data());
    } else {
      std::iota(panels_.begin(), panels_.end(), static_cast<std::uint32_t>(begin));
    }
    return std::span(panels_).first(count);
  }

  /// Pairs of descriptors only, first, and what they were before they were grouped; returns their
  /// number.
  std::size_t DropPadding(std::size_t found) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < found; ++n) {
      const std::uint32_t row = found_rows_[n];
      const std::uint32_t column = found_columns_[n];
      if (row >= rows_.order().size() || column >= columns_.order().size()) continue;
      found_rows_[count] = row;
      found_columns_[count] = column;
      original_rows_[count] = rows_.order()[row];
      original_columns_[count] = columns_.order()[column];
      ++count;
    }
    return count;
  }

  void Offer(std::size_t count, Lists* of_rows, Lists* of_columns) {
    ComputeSquaredDistances(source_.front().data(), target_.front().data(), original_rows_.data(),
                            original_columns_.data(), count, squared_.data());
    const std::span<const double> squared = std::span(squared_).first(count);
    of_rows->Offer(std::span(found_rows_).first(count), squared,
                   std::span(original_columns_).first(count));
    of_columns->Offer(std::span(found_columns_).first(count), squared,
                      std::span(original_rows_).first(count));
  }

  std::span<const FpfhDescriptor> source_, target_;
  const DescriptorGroups& rows_;
  const DescriptorGroups& columns_;
  DescriptorBoxes boxes_;
  FirstAxes first_axes_;
  std::array<std::uint32_t, kMostPanels + kMostLanes> panels_{};
  std::vector<std::uint32_t> found_rows_, found_columns_;
  std::vector<std::uint32_t> original_rows_, original_columns_;  // before they were grouped
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
  const DescriptorAxes axes(source, target);
  const DescriptorGridScale scale = MakeGridScale(axes, source, target);
  const DescriptorGrid source_grid(source, axes, scale);
  const DescriptorGrid target_grid(target, axes, scale);
  const DescriptorGrid pivots = ChoosePivots(target_grid);
  const DescriptorGroups rows(source_grid, pivots);
  const DescriptorGroups columns(target_grid, pivots);
  const Rounding rounding(scale, source_grid, target_grid);
  Lists of_rows(rows, k, rounding);
  Lists of_columns(columns, k, rounding);
  of_rows.Seed(columns);
  of_columns.Seed(rows);
  Comparison(source, target, rows, columns).Run(&of_rows, &of_columns);
  of_rows.Write(of_source);
  of_columns.Write(of_target);
}

}  // namespace backsight
