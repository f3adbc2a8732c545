#include "stages/descriptor_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/random.h"
#include "stages/descriptor_boxes.h"
#include "tests/support/instruction_sets.h"

namespace backsight {
namespace {

/// Three blocks that sum to 100, of a few kinds.
std::vector<FpfhDescriptor> SomeDescriptors(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<FpfhDescriptor> descriptors(count);
  for (FpfhDescriptor& d : descriptors) {
    const double power = 1.0 + static_cast<double>(random.Index(4));
    for (float& bin : d) bin = static_cast<float>(std::pow(random.Uniform(), power));
    for (std::size_t block = 0; block < 3; ++block) {
      const std::span bins = std::span(d).subspan(11 * block, 11);
      const float sum = std::accumulate(bins.begin(), bins.end(), 0.0F);
      for (float& bin : bins) bin *= 100.0F / sum;
    }
  }
  return descriptors;
}

struct Grid {
  explicit Grid(const std::vector<FpfhDescriptor>& descriptors)
      : axes(descriptors, descriptors),
        scale(MakeGridScale(axes, descriptors, descriptors)),
        grid(descriptors, axes, scale) {}
  DescriptorAxes axes;
  DescriptorGridScale scale;
  DescriptorGrid grid;
};

constexpr std::size_t kRest = 2 * kFirstPairs - 1;  // its place among the halves

std::int64_t Half(const GridView& grid, std::size_t half, std::size_t place) {
  const auto pair = static_cast<std::uint32_t>(grid.pairs[PlaceOnGrid(half / 2, place)]);
  return static_cast<std::int16_t>(half % 2 == 0 ? pair : pair >> 16U);
}

/// a.b - |a|^2 / 2 - |b|^2 / 2 on the grid, by all axes: the greater, the closer.
std::int64_t Closeness(const GridView& a, std::size_t i, const GridView& b, std::size_t j) {
  std::int64_t sum = -std::int64_t{a.half_squares[i]} - b.half_squares[j];
  for (std::size_t half = 0; half < 2 * kDescriptorPairs; ++half) {
    if (half != kRest) sum += Half(a, half, i) * Half(b, half, j);
  }
  return sum;
}

/// The same by the first axes and the rest.
std::int64_t FirstCloseness(const GridView& a, std::size_t i, const GridView& b, std::size_t j) {
  std::int64_t sum = -std::int64_t{a.half_squares[i]} - b.half_squares[j];
  for (std::size_t half = 0; half <= kRest; ++half) sum += Half(a, half, i) * Half(b, half, j);
  return sum;
}

TEST(DescriptorAxes, KeepLengthsAndBeginWithTheWidest) {
  const auto descriptors = SomeDescriptors(1, 200);
  const DescriptorAxes axes(descriptors, descriptors);
  std::vector<std::vector<double>> turned_by;
  ForEachInstructionSet([&](const std::string& name) {
    std::vector<double> turned(descriptors.size() * kFrameStride);
    TurnDescriptors(descriptors.front().data(), descriptors.size(), axes.frame(), turned.data());
    std::vector<double> scatter(kDescriptorAxes, 0.0);
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      double squared = 0.0;
      for (std::size_t axis = 0; axis < kDescriptorAxes; ++axis) {
        const double x = turned[i * kFrameStride + axis];
        squared += x * x;
        scatter[axis] += x * x;
      }
      const double expected = axes.SquaredLength(descriptors[i]);
      EXPECT_NEAR(squared, expected, 1e-6 * expected) << name;
    }
    EXPECT_TRUE(std::is_sorted(scatter.rbegin() + 1, scatter.rend())) << name;
    turned_by.push_back(turned);
    EXPECT_EQ(turned, turned_by.front()) << name;
  });
}

TEST(DescriptorGrid, ErrorsAndOffsetsAreBounded) {
  const auto descriptors = SomeDescriptors(2, 130);
  const Grid on(descriptors);
  const GridView view = on.grid.view();
  for (std::size_t i = 0; i < 60; ++i) {
    const std::size_t j = i + 70;
    double squared = 0.0;
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      const double d =
          static_cast<double>(descriptors[i][bin]) - static_cast<double>(descriptors[j][bin]);
      squared += d * d;
    }
    const double steps = std::sqrt(squared) * on.scale.steps_per_unit;
    const double on_grid = std::sqrt(-2.0 * static_cast<double>(Closeness(view, i, view, j)));
    const double error = 2.0 * on.grid.largest_error() + 1.0;
    EXPECT_LE(on_grid, steps + error);
    EXPECT_GE(std::hypot(on_grid + error, 2.0 * on.grid.largest_offset()), steps);
  }
}

TEST(DescriptorGrid, FirstAxesAndTheRestBoundDistancesFromBelow) {
  const Grid on(SomeDescriptors(3, 150));
  const GridView view = on.grid.view();
  for (std::size_t i = 0; i < view.size; ++i) {
    for (std::size_t j = 0; j < view.size; ++j) {
      EXPECT_GE(FirstCloseness(view, i, view, j), Closeness(view, i, view, j));
    }
  }
}

TEST(FindClose, FirstAxesChangeNothing) {
  const Grid on(SomeDescriptors(4, 1000));
  const GridView view = on.grid.view();
  std::vector<std::uint32_t> panels(view.stride / kGridPadding);
  std::iota(panels.begin(), panels.end(), 0U);
  ForEachInstructionSet([&](const std::string& name) {
    Random random(5);
    for (std::size_t trial = 0; trial < 40; ++trial) {
      std::vector<std::int32_t> limits(view.stride);
      for (std::int32_t& limit : limits) {
        limit = static_cast<std::int32_t>(random.Index(random.Index(50) == 0 ? 40000000 : 400000));
      }
      const std::size_t row = random.Index(view.size / kRowBlock) * kRowBlock;
      const auto find = [&](bool first_axes) {
        std::vector<std::uint32_t> rows(kFoundRoom), columns(kFoundRoom);
        const CloseCount count =
            FindClose(view, row, view, panels, {limits.data() + row, limits.data()}, first_axes,
                      {rows.data(), columns.data()});
        std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
        for (std::size_t n = 0; n < count.pairs; ++n) found.emplace_back(rows[n], columns[n]);
        std::sort(found.begin(), found.end());
        return found;
      };
      std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
      for (std::size_t r = row; r < row + kRowBlock; ++r) {
        for (std::size_t j = 0; j < view.stride; ++j) {
          const std::int64_t closeness =
              j < view.size ? Closeness(view, r, view, j) : -std::int64_t{view.half_squares[r]};
          if (closeness + std::max(limits[r], limits[j]) > 0) expected.emplace_back(r, j);
        }
      }
      EXPECT_EQ(find(true), expected) << name;
      EXPECT_EQ(find(false), expected) << name;
    }
  });
}

/// Panels that hold a column close enough to a row of the block.
std::vector<std::uint32_t> PanelsWithClose(const GridView& view, std::size_t row,
                                           const std::vector<std::int32_t>& limits) {
  std::vector<std::uint32_t> panels;
  for (std::size_t j = 0; j < view.size; ++j) {
    for (std::size_t r = row; r < row + kRowBlock; ++r) {
      const auto panel = static_cast<std::uint32_t>(j / kGridPadding);
      const bool is_close = Closeness(view, r, view, j) + std::max(limits[r], limits[j]) > 0;
      if (is_close && (panels.empty() || panels.back() != panel)) panels.push_back(panel);
    }
  }
  return panels;
}

TEST(DescriptorBoxes, RuleOutOnlyPanelsWithoutClose) {
  const Grid on(SomeDescriptors(6, 2000));
  const DescriptorGroups groups(on.grid, ChoosePivots(on.grid));
  const GridView view = groups.grid().view();
  const std::size_t panels = view.stride / kGridPadding;
  DescriptorBoxes boxes(view);
  Random random(7);
  std::vector<std::int32_t> limits(view.stride);
  for (std::int32_t& limit : limits) limit = static_cast<std::int32_t>(random.Index(1000000));
  boxes.SetLimits(limits.data(), 0, panels);
  ForEachInstructionSet([&](const std::string& name) {
    std::size_t near_ones = 0;
    for (std::size_t row = 0; row < view.size; row += 20 * kRowBlock) {
      const auto row_limit =
          *std::max_element(limits.data() + row, limits.data() + row + kRowBlock);
      std::vector<std::uint32_t> near(panels + kMostLanes);
      near.resize(boxes.FindNear(view, row, row_limit, 16, panels, near.data()));
      EXPECT_TRUE(std::is_sorted(near.begin(), near.end())) << name;
      for (const std::uint32_t panel : PanelsWithClose(view, row, limits)) {
        if (panel < 16) continue;
        EXPECT_TRUE(std::binary_search(near.begin(), near.end(), panel)) << name << " " << panel;
      }
      near_ones += near.size();
    }
    EXPECT_LT(near_ones, (panels - 16) * (view.size / (20 * kRowBlock)) * 9 / 10) << name;
  });
}

TEST(DescriptorBoxes, KeepWhatIsJustCloseEnough) {
  const Grid on(SomeDescriptors(8, 400));
  const GridView view = on.grid.view();
  const std::size_t panels = view.stride / kGridPadding;
  DescriptorBoxes boxes(view);
  const std::vector<std::int32_t> none(view.stride, 0);
  boxes.SetLimits(none.data(), 0, panels);
  ForEachInstructionSet([&](const std::string& name) {
    for (std::size_t row = 0; row < view.size; row += kRowBlock) {
      for (std::size_t j = row % 7; j < view.size; j += 7) {
        const auto half_squared = static_cast<std::int32_t>(-Closeness(view, row, view, j));
        std::vector<std::uint32_t> near(panels + kMostLanes);
        near.resize(boxes.FindNear(view, row, half_squared + 1, 0, panels, near.data()));
        ASSERT_TRUE(std::binary_search(near.begin(), near.end(), j / kGridPadding))
            << name << " " << row << " " << j;
      }
    }
  });
}

TEST(FindSeeds, AreTheKthLargestOfTheClasses) {
  const Grid on(SomeDescriptors(9, 300));
  const GridView view = on.grid.view();
  constexpr std::size_t kBegin = kGridPadding;
  constexpr std::size_t kEnd = 8 * kGridPadding;
  ForEachInstructionSet([&](const std::string& name) {
    for (const std::size_t k : {1U, 3U, 8U}) {
      for (std::size_t row = 0; row < 100; row += kRowBlock) {
        std::array<std::int32_t, kRowBlock> kth{};
        FindSeeds(view, row, view, kBegin, kEnd, k, kth);
        for (std::size_t r = 0; r < kRowBlock; ++r) {
          std::vector<std::int64_t> best(kSeedClasses, std::numeric_limits<std::int64_t>::min());
          for (std::size_t j = kBegin; j < kEnd; ++j) {
            best[j % kSeedClasses] =
                std::max(best[j % kSeedClasses], Closeness(view, row + r, view, j));
          }
          std::sort(best.rbegin(), best.rend());
          EXPECT_EQ(kth[r], best[k - 1]) << name << " " << row + r << " " << k;
        }
      }
    }
  });
}

TEST(DescriptorGroups, SortsByTheClosestPivot) {
  const Grid on(SomeDescriptors(1, 701));
  const GridView view = on.grid.view();
  const DescriptorGrid pivots = ChoosePivots(on.grid);
  const GridView p = pivots.view();
  ForEachInstructionSet([&](const std::string& name) {
    const DescriptorGroups groups(on.grid, pivots);
    std::vector<std::uint32_t> order = groups.order();
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::size_t closest = 0;
      for (std::size_t j = 1; j < p.size; ++j) {
        if (FirstCloseness(view, order[i], p, j) > FirstCloseness(view, order[i], p, closest)) {
          closest = j;
        }
      }
      EXPECT_EQ(groups.PivotOf(i), closest) << name;
      EXPECT_TRUE(i == 0 || groups.PivotOf(i - 1) <= closest);
      EXPECT_EQ(Closeness(groups.grid().view(), i, p, 0), Closeness(view, order[i], p, 0));
    }
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
  });
}

TEST(DescriptorGroups, ColumnsAroundAPivotAreWholeAndEnough) {
  for (const std::size_t size : {1U, 31U, 32U, 100U, 700U, 2000U}) {
    const Grid on(SomeDescriptors(size, size));
    const DescriptorGroups groups(on.grid, ChoosePivots(on.grid));
    const std::size_t whole = size / kGridPadding * kGridPadding;
    for (std::size_t pivot = 0; pivot < kGridPadding; ++pivot) {
      const ColumnRange range = groups.Around(pivot);
      EXPECT_EQ(range.begin % kGridPadding, 0U);
      EXPECT_EQ(range.end % kGridPadding, 0U);
      EXPECT_LE(range.end, whole);
      EXPECT_EQ(range.end - range.begin, std::min<std::size_t>(256, whole));
    }
  }
}

}  // namespace
}  // namespace backsight
