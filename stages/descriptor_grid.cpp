#include "stages/descriptor_grid.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace backsight {
namespace {

constexpr double kLargestNorm = 23000.0;  // steps: twice that, squared, is below 2^31
static_assert(kDescriptorAxes == 2 * kDescriptorPairs - 1);

/// Not finite where any is not.
double LargestNorm(const DescriptorAxes& axes, std::span<const FpfhDescriptor> descriptors) {
  double largest = 0.0;
  double sum = 0.0;  // what is not finite stays in it
  for (const FpfhDescriptor& d : descriptors) {
    const double squared = axes.SquaredLength(d);
    largest = std::max(largest, squared);
    sum += squared;
  }
  return std::isfinite(sum) ? std::sqrt(largest) : sum;
}

/// Two halves of a lane, the first one low.
std::int32_t Pack(int low, int high) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(high) << 16U |
                                   (static_cast<std::uint32_t>(low) & 0xFFFFU));
}

/// Along the axes, and a zero, so that whole vectors are read.
using AxisSteps = Eigen::Array<int, static_cast<int>(kFrameStride), 1>;
using AxisPlaces = Eigen::Array<double, static_cast<int>(kFrameStride), 1>;

/// Half steps go up. Conversions cut towards zero, so what is cut must be positive.
AxisSteps Nearest(const AxisPlaces& places) {
  constexpr int kShift = 1 << 15;
  return (places + (kShift + 0.5)).cast<int>() - kShift;
}

/// What is left of a squared length once it is that of the axes of the grid, at most.
double SquaredOffset(double squared_length, const double* turned) {
  constexpr double kRounding = 1e-12;  // of both, relative
  const double along = Eigen::Map<const AxisPlaces>(turned).matrix().squaredNorm();
  return std::max(squared_length - along, 0.0) + kRounding * squared_length;
}

}  // namespace

DescriptorGridScale MakeGridScale(const DescriptorAxes& axes, std::span<const FpfhDescriptor> a,
                                  std::span<const FpfhDescriptor> b) {
  DescriptorGridScale scale;
  const double of_a = LargestNorm(axes, a);
  const double of_b = LargestNorm(axes, b);
  BACKSIGHT_CHECK(std::isfinite(of_a) && std::isfinite(of_b), "bins of descriptors are finite");
  const double largest = std::max(of_a, of_b);
  // Rounding may lengthen a descriptor by half a step an axis, and its rest by one.
  const double room = kLargestNorm - std::sqrt(static_cast<double>(kDescriptorAxes)) - 1.0;
  if (largest > 0.0) scale.steps_per_unit = room / largest;
  return scale;
}

DescriptorGrid::DescriptorGrid(std::size_t size)
    : size_(size),
      stride_((size + kGridPadding - 1) / kGridPadding * kGridPadding),
      pairs_(stride_ * kDescriptorPairs, 0),
      half_squares_(stride_, 0) {}

DescriptorGrid::DescriptorGrid(std::span<const FpfhDescriptor> descriptors,
                               const DescriptorAxes& axes, const DescriptorGridScale& scale)
    : DescriptorGrid(descriptors.size()) {
  std::array<double, kTurnedTogether * kFrameStride> turned;
  double largest_error2 = 0.0;
  double largest_offset2 = 0.0;
  for (std::size_t begin = 0; begin < size_; begin += kTurnedTogether) {
    const std::size_t count = std::min(kTurnedTogether, size_ - begin);
    TurnDescriptors(descriptors[begin].data(), count, axes.frame(), turned.data());
    for (std::size_t i = 0; i < count; ++i) {
      const double* coordinates = turned.data() + i * kFrameStride;
      const double length2 = axes.SquaredLength(descriptors[begin + i]);
      largest_error2 =
          std::max(largest_error2, Place(begin + i, coordinates, scale.steps_per_unit));
      largest_offset2 = std::max(largest_offset2, SquaredOffset(length2, coordinates));
    }
  }
  largest_error_ = std::sqrt(largest_error2);
  largest_offset_ = std::sqrt(largest_offset2) * scale.steps_per_unit;
}

double DescriptorGrid::Place(std::size_t at, const double* turned, double steps_per_unit) {
  const AxisPlaces places = Eigen::Map<const AxisPlaces>(turned) * steps_per_unit;
  const AxisSteps steps = Nearest(places);
  const AxisPlaces rounded = steps.cast<double>();
  constexpr int kFirst = static_cast<int>(kFirstAxes);
  constexpr int kLater = static_cast<int>(kDescriptorAxes) - kFirst;
  const int squared = steps.matrix().squaredNorm();
  const int rest2 = squared - steps.head<kFirst>().matrix().squaredNorm();
  half_squares_[at] = squared / 2;

  std::int32_t* pair = pairs_.data() + PlaceOnGrid(0, at);
  int axis = 0;
  for (; axis + 1 < kFirst; axis += 2, pair += kGridPadding) {
    *pair = Pack(steps[axis], steps[axis + 1]);
  }
  *pair = Pack(steps[axis], static_cast<int>(std::ceil(std::sqrt(static_cast<double>(rest2)))));
  for (axis += 1; axis < kFirst + kLater; axis += 2) {
    *(pair += kGridPadding) = Pack(steps[axis], steps[axis + 1]);
  }
  return (places - rounded).matrix().squaredNorm();
}

DescriptorGrid DescriptorGrid::Chosen(std::span<const std::uint32_t> places) const {
  DescriptorGrid chosen(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    chosen.half_squares_[i] = half_squares_[places[i]];
    const std::int32_t* from = pairs_.data() + PlaceOnGrid(0, places[i]);
    std::int32_t* to = chosen.pairs_.data() + PlaceOnGrid(0, i);
    for (std::size_t p = 0; p < kDescriptorPairs; ++p)
      to[p * kGridPadding] = from[p * kGridPadding];
  }
  return chosen;
}

}  // namespace backsight
