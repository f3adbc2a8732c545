#include "stages/descriptor_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace backsight {
namespace {

static_assert(std::tuple_size_v<FpfhDescriptor> == kDescriptorBins);
constexpr double kLargestNorm = 23000.0;  // steps: twice that, squared, is below 2^31

double LargestNorm(std::span<const FpfhDescriptor> descriptors, float center) {
  double largest = 0.0;
  for (const FpfhDescriptor& d : descriptors) {
    double squared = 0.0;
    for (const float bin : d) {
      const double offset = static_cast<double>(bin) - static_cast<double>(center);
      squared += offset * offset;
    }
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}

/// Half steps go up. Conversions cut towards zero, so what is cut must be positive.
int Nearest(double place) {
  constexpr int kShift = 1 << 15;
  return static_cast<int>(place + (kShift + 0.5)) - kShift;
}

/// Two halves of a lane, the first one low.
std::int32_t Pack(int low, int high) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(high) << 16U |
                                   (static_cast<std::uint32_t>(low) & 0xFFFFU));
}

}  // namespace

DescriptorGridScale MakeGridScale(std::span<const FpfhDescriptor> a,
                                  std::span<const FpfhDescriptor> b) {
  DescriptorGridScale scale;
  scale.center = 100.0F / 11.0F;
  const double largest = std::max(LargestNorm(a, scale.center), LargestNorm(b, scale.center));
  // Rounding may lengthen a descriptor by half a step a bin.
  const double room = kLargestNorm - std::sqrt(static_cast<double>(kDescriptorBins));
  if (largest > 0.0) scale.steps_per_unit = room / largest;
  return scale;
}

DescriptorGrid::DescriptorGrid(std::span<const FpfhDescriptor> descriptors,
                               const DescriptorGridScale& scale)
    : size_(descriptors.size()),
      stride_((descriptors.size() + kGridPadding - 1) / kGridPadding * kGridPadding),
      pairs_(stride_ * kDescriptorPairs, 0),
      half_squares_(stride_, 0) {
  double largest = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    std::array<int, 2 * kDescriptorPairs> steps{};
    double error = 0.0;
    std::int32_t square = 0;
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      const double place =
          (static_cast<double>(descriptors[i][bin]) - static_cast<double>(scale.center)) *
          scale.steps_per_unit;
      steps[bin] = Nearest(place);
      error += (place - steps[bin]) * (place - steps[bin]);
      square += steps[bin] * steps[bin];
    }
    largest = std::max(largest, error);
    half_squares_[i] = square / 2;
    for (std::size_t p = 0; p < kDescriptorPairs; ++p) {
      pairs_[p * stride_ + i] = Pack(steps[2 * p], steps[2 * p + 1]);
    }
  }
  largest_error_ = std::sqrt(largest);
}

}  // namespace backsight
