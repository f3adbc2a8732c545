#include "stages/descriptor_vectors.h"

#include <algorithm>

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/descriptor_vectors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Coordinates along all axes of kTurnedTogether descriptors; bin b of descriptor i at
/// bins[b * kTurnedTogether + i].
HWY_INLINE void TurnTogether(const double* HWY_RESTRICT bins, const double* HWY_RESTRICT basis,
                             double* HWY_RESTRICT turned) {
  const hn::CappedTag<double, 8> d;
  for (std::size_t axis = 0; axis < kFrameStride; axis += hn::Lanes(d)) {
    auto sum0 = hn::Zero(d), sum1 = sum0, sum2 = sum0, sum3 = sum0;
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      const auto part = hn::LoadU(d, basis + bin * kFrameStride + axis);
      const double* x = bins + bin * kTurnedTogether;
      sum0 = hn::Add(sum0, hn::Mul(part, hn::Set(d, x[0])));
      sum1 = hn::Add(sum1, hn::Mul(part, hn::Set(d, x[1])));
      sum2 = hn::Add(sum2, hn::Mul(part, hn::Set(d, x[2])));
      sum3 = hn::Add(sum3, hn::Mul(part, hn::Set(d, x[3])));
    }
    hn::StoreU(sum0, d, turned + axis);
    hn::StoreU(sum1, d, turned + axis + kFrameStride);
    hn::StoreU(sum2, d, turned + axis + 2 * kFrameStride);
    hn::StoreU(sum3, d, turned + axis + 3 * kFrameStride);
  }
}

void Turn(const float* HWY_RESTRICT descriptors, std::size_t count, const DescriptorFrame& frame,
          double* HWY_RESTRICT turned) {
  double bins[kTurnedTogether * kDescriptorBins] = {};
  for (std::size_t begin = 0; begin < count; begin += kTurnedTogether) {
    for (std::size_t i = 0; i < std::min(kTurnedTogether, count - begin); ++i) {
      const float* from = descriptors + (begin + i) * kDescriptorBins;
      for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
        bins[bin * kTurnedTogether + i] = static_cast<double>(from[bin]) - frame.origin[bin];
      }
    }
    TurnTogether(bins, frame.basis, turned + begin * kFrameStride);
  }
}

void Distances(const float* HWY_RESTRICT rows, const float* HWY_RESTRICT columns,
               const std::uint32_t* found_rows, const std::uint32_t* found_columns,
               std::size_t count, double* HWY_RESTRICT squared) {
  constexpr std::size_t kLanes = 8;
  constexpr std::size_t kWhole = kDescriptorBins / kLanes * kLanes;
  const hn::CappedTag<double, kLanes> d;
  const hn::Rebind<float, decltype(d)> in_float;
  const auto load = [&](const float* p) { return hn::PromoteTo(d, hn::LoadU(in_float, p)); };
  for (std::size_t n = 0; n < count; ++n) {
    const float* a = rows + found_rows[n] * kDescriptorBins;
    const float* b = columns + found_columns[n] * kDescriptorBins;
    HWY_ALIGN double sums[kLanes];
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
      auto sum = hn::Zero(d);
      for (std::size_t bin = lane; bin < kWhole; bin += kLanes) {
        const auto difference = hn::Sub(load(a + bin), load(b + bin));
        sum = hn::Add(sum, hn::Mul(difference, difference));
      }
      hn::Store(sum, d, sums + lane);
    }
    for (std::size_t bin = kWhole; bin < kDescriptorBins; ++bin) {
      const double difference = static_cast<double>(a[bin]) - static_cast<double>(b[bin]);
      sums[bin - kWhole] += difference * difference;
    }
    squared[n] =
        ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Turn);
HWY_EXPORT(Distances);

void TurnDescriptors(const float* descriptors, std::size_t count, const DescriptorFrame& frame,
                     double* turned) {
  HWY_DYNAMIC_DISPATCH(Turn)(descriptors, count, frame, turned);
}

void ComputeSquaredDistances(const float* rows, const float* columns,
                             const std::uint32_t* found_rows, const std::uint32_t* found_columns,
                             std::size_t count, double* squared) {
  HWY_DYNAMIC_DISPATCH(Distances)(rows, columns, found_rows, found_columns, count, squared);
}

}  // namespace backsight
#endif
