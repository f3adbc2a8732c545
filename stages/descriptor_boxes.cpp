#include "stages/descriptor_boxes.h"

#include <algorithm>
#include <array>

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/descriptor_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef BACKSIGHT_STAGES_DESCRIPTOR_BOXES_ONCE
#define BACKSIGHT_STAGES_DESCRIPTOR_BOXES_ONCE
namespace backsight {
namespace {

constexpr std::size_t kCoordinates = 2 * kFirstPairs;  // the last one is the rest
constexpr std::size_t kTogether = kMostLanes;          // panels side by side

/// Where the first coordinate of a panel is; the next is kTogether places further.
constexpr std::size_t PlaceOfPanel(std::size_t panel) {
  return panel / kTogether * kTogether * kCoordinates + panel % kTogether;
}

/// Of some descriptors the lowest and the highest along each coordinate.
struct Box {
  std::array<std::int32_t, kCoordinates> lowest, highest;

  Box(const GridView& grid, std::size_t begin, std::size_t count) {
    for (std::size_t c = 0; c < kCoordinates; ++c) {
      lowest[c] = highest[c] = CoordinateOf(grid, c, begin);
      for (std::size_t i = 1; i < count; ++i) {
        const std::int32_t value = CoordinateOf(grid, c, begin + i);
        lowest[c] = std::min(lowest[c], value);
        highest[c] = std::max(highest[c], value);
      }
    }
  }
};

struct BoxesView {
  const std::int32_t* lowest;
  const std::int32_t* highest;
  const std::int32_t* limits;
};

}  // namespace
}  // namespace backsight
#endif

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

std::size_t Near(const Box& rows, std::int32_t row_limit, const BoxesView& boxes, std::size_t begin,
                 std::size_t end, std::uint32_t* near) {
  const hn::CappedTag<std::int32_t, kTogether> d;
  const hn::RebindToUnsigned<decltype(d)> u;
  std::size_t count = 0;
  for (std::size_t panel = begin; panel < end; panel += hn::Lanes(d)) {
    const std::size_t first = PlaceOfPanel(panel);
    auto squared = hn::Zero(d);
    for (std::size_t c = 0; c < kCoordinates; ++c) {
      const auto lowest = hn::LoadU(d, boxes.lowest + first + c * kTogether);
      const auto highest = hn::LoadU(d, boxes.highest + first + c * kTogether);
      const auto above = hn::Sub(lowest, hn::Set(d, rows.highest[c]));
      const auto below = hn::Sub(hn::Set(d, rows.lowest[c]), highest);
      const auto gap = hn::Max(hn::Max(above, below), hn::Zero(d));
      squared = hn::Add(squared, hn::Mul(gap, gap));
    }
    const auto limit = hn::Max(hn::Set(d, row_limit), hn::LoadU(d, boxes.limits + panel));
    const auto number = hn::Iota(d, static_cast<std::int32_t>(panel));
    const auto too_far = hn::Gt(hn::ShiftRight<1>(squared), limit);
    const auto is_one = hn::Lt(number, hn::Set(d, static_cast<std::int32_t>(end)));
    const auto is_near = hn::AndNot(too_far, is_one);
    hn::StoreU(hn::BitCast(u, hn::Compress(number, is_near)), u, near + count);
    count += hn::CountTrue(d, is_near);
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Near);

DescriptorBoxes::DescriptorBoxes(const GridView& columns) {
  const std::size_t panels = columns.stride / kGridPadding;
  const std::size_t padded = (panels + kTogether - 1) / kTogether * kTogether;
  lowest_.resize(padded * kCoordinates);
  highest_.resize(padded * kCoordinates);
  limits_.resize(padded);
  for (std::size_t panel = 0; panel < panels; ++panel) {
    const Box box(columns, panel * kGridPadding, kGridPadding);
    const std::size_t first = PlaceOfPanel(panel);
    for (std::size_t c = 0; c < kCoordinates; ++c) {
      lowest_[first + c * kTogether] = box.lowest[c];
      highest_[first + c * kTogether] = box.highest[c];
    }
  }
}

void DescriptorBoxes::SetLimits(const std::int32_t* limits, std::size_t begin, std::size_t end) {
  for (std::size_t panel = begin; panel < end; ++panel) {
    const std::int32_t* of_panel = limits + panel * kGridPadding;
    limits_[panel] = *std::max_element(of_panel, of_panel + kGridPadding);
  }
}

std::size_t DescriptorBoxes::FindNear(const GridView& rows, std::size_t row, std::int32_t row_limit,
                                      std::size_t begin, std::size_t end,
                                      std::uint32_t* near) const {
  Box box(rows, row, kRowBlock);
  // Two rests that were rounded up are at most one farther apart than they were.
  --box.lowest.back();
  ++box.highest.back();
  return HWY_DYNAMIC_DISPATCH(Near)(
      box, row_limit, {lowest_.data(), highest_.data(), limits_.data()}, begin, end, near);
}

}  // namespace backsight
#endif
