#include "stages/descriptor_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace backsight {
namespace {

constexpr std::size_t kBlocks = 3;
constexpr std::size_t kBlockBins = kDescriptorBins / kBlocks;
constexpr std::size_t kGridBins = 2 * kDescriptorPairs;
static_assert(std::tuple_size_v<FpfhDescriptor> == kDescriptorBins);
static_assert(kBlocks * (kBlockBins - 1) == kGridBins);
constexpr double kLargestNorm = 23000.0;  // steps: twice that, squared, is below 2^31

/// A descriptor in the turned axes (Helmert's): of each block the first ones, and how far it is
/// from a sum of 100 along the last.
struct TurnedDescriptor {
  std::array<double, kGridBins> axes;
  double offset2 = 0.0;  // of all blocks, squared

  explicit TurnedDescriptor(const FpfhDescriptor& d) {
    static const std::array<double, kBlockBins> scales = AxisScales();
    for (std::size_t block = 0; block < kBlocks; ++block) {
      const float* bins = d.data() + block * kBlockBins;
      double* out = axes.data() + block * (kBlockBins - 1);
      double sum = 0.0;
      for (std::size_t k = 1; k < kBlockBins; ++k) {
        sum += static_cast<double>(bins[k - 1]);
        out[k - 1] = (sum - static_cast<double>(k) * static_cast<double>(bins[k])) * scales[k];
      }
      const double off = sum + static_cast<double>(bins[kBlockBins - 1]) - 100.0;
      offset2 += off * off / static_cast<double>(kBlockBins);
    }
  }

 private:
  static std::array<double, kBlockBins> AxisScales() {
    std::array<double, kBlockBins> scales{};
    for (std::size_t k = 1; k < kBlockBins; ++k) {
      scales[k] = 1.0 / std::sqrt(static_cast<double>(k * (k + 1)));
    }
    return scales;
  }
};

double LargestNorm(std::span<const FpfhDescriptor> descriptors) {
  double largest = 0.0;
  for (const FpfhDescriptor& d : descriptors) {
    double squared = 0.0;
    for (const double axis : TurnedDescriptor(d).axes) squared += axis * axis;
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
  const double largest = std::max(LargestNorm(a), LargestNorm(b));
  // Rounding may lengthen a descriptor by half a step a bin.
  const double room = kLargestNorm - std::sqrt(static_cast<double>(kGridBins));
  if (largest > 0.0) scale.steps_per_unit = room / largest;
  return scale;
}

DescriptorGrid::DescriptorGrid(std::size_t size)
    : size_(size),
      stride_((size + kGridPadding - 1) / kGridPadding * kGridPadding),
      pairs_(stride_ * kDescriptorPairs, 0),
      half_squares_(stride_, 0) {}

DescriptorGrid::DescriptorGrid(std::span<const FpfhDescriptor> descriptors,
                               const DescriptorGridScale& scale)
    : DescriptorGrid(descriptors.size()) {
  double largest_error2 = 0.0;
  double largest_offset2 = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    const TurnedDescriptor turned(descriptors[i]);
    std::array<int, kGridBins> steps;
    double error = 0.0;
    std::int32_t square = 0;
    for (std::size_t k = 0; k < kGridBins; ++k) {
      const double place = turned.axes[k] * scale.steps_per_unit;
      steps[k] = Nearest(place);
      error += (place - steps[k]) * (place - steps[k]);
      square += steps[k] * steps[k];
    }
    largest_error2 = std::max(largest_error2, error);
    largest_offset2 = std::max(largest_offset2, turned.offset2);
    half_squares_[i] = square / 2;
    for (std::size_t p = 0; p < kDescriptorPairs; ++p) {
      pairs_[p * stride_ + i] = Pack(steps[2 * p], steps[2 * p + 1]);
    }
  }
  largest_error_ = std::sqrt(largest_error2);
  largest_offset_ = std::sqrt(largest_offset2) * scale.steps_per_unit;
}

DescriptorGrid DescriptorGrid::Chosen(std::span<const std::uint32_t> places) const {
  DescriptorGrid chosen(places.size());
  chosen.largest_error_ = largest_error_;
  chosen.largest_offset_ = largest_offset_;
  for (std::size_t i = 0; i < places.size(); ++i)
    chosen.half_squares_[i] = half_squares_[places[i]];
  for (std::size_t p = 0; p < kDescriptorPairs; ++p) {
    const std::int32_t* from = pairs_.data() + p * stride_;
    std::int32_t* to = chosen.pairs_.data() + p * chosen.stride_;
    for (std::size_t i = 0; i < places.size(); ++i) to[i] = from[places[i]];
  }
  return chosen;
}

}  // namespace backsight
