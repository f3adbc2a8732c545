#pragma once

#include <span>

#include "core/cache_line_vector.h"
#include "stages/descriptor_axes.h"
#include "stages/descriptor_kernels.h"
#include "stages/station_model.h"

namespace backsight {

/// Where descriptors are rounded to whole steps, so that products are exact in integers: the same
/// grid for both sides of a search.
struct DescriptorGridScale {
  double steps_per_unit = 1.0;
};

/// The finest grid on which squared distances fit 31 bits.
DescriptorGridScale MakeGridScale(const DescriptorAxes& axes, std::span<const FpfhDescriptor> a,
                                  std::span<const FpfhDescriptor> b);

/// Descriptors on a grid along their principal axes. Some axes are left out, so that distances on
/// the grid are at most too short. Beside the first axes each has the length of the others'
/// coordinates, its rest, rounded up: a.b <= first axes' a.b + rest * rest (Cauchy-Schwarz), a
/// bound on the distance that takes a quarter of the products.
class DescriptorGrid {
 public:
  DescriptorGrid(std::span<const FpfhDescriptor> descriptors, const DescriptorAxes& axes,
                 const DescriptorGridScale& scale);

  /// Those at these places, in their order, without their largest error and offset.
  DescriptorGrid Chosen(std::span<const std::uint32_t> places) const;

  GridView view() const { return {pairs_.data(), half_squares_.data(), size_, stride_}; }
  /// By how much rounding has moved any of the descriptors, at most, in steps.
  double largest_error() const { return largest_error_; }
  /// How far any lies from the mean along the axes that are left out, at most, in steps.
  double largest_offset() const { return largest_offset_; }

 private:
  explicit DescriptorGrid(std::size_t size);
  /// Rounds a descriptor's coordinates to the grid; returns the squared error, in steps.
  double Place(std::size_t at, const double* turned, double steps_per_unit);

  std::size_t size_;
  std::size_t stride_;
  CacheLineVector<std::int32_t> pairs_;
  CacheLineVector<std::int32_t> half_squares_;
  double largest_error_ = 0.0;
  double largest_offset_ = 0.0;
};

}  // namespace backsight
