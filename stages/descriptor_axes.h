#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "stages/descriptor_vectors.h"
#include "stages/station_model.h"

namespace backsight {

/// The axes along which the descriptors of a search differ most, the principal ones of a sample of
/// both sides, in descending order. The last two of 33 are left out: the bins of each of the three
/// blocks have the same sum in all descriptors, so that there is next to nothing along three of
/// them.
class DescriptorAxes {
 public:
  /// Neither side is empty.
  DescriptorAxes(std::span<const FpfhDescriptor> a, std::span<const FpfhDescriptor> b);

  DescriptorFrame frame() const { return {mean_.data(), basis_.data()}; }
  /// From the sample's mean.
  double SquaredLength(const FpfhDescriptor& descriptor) const;

 private:
  std::array<double, kDescriptorBins> mean_{};
  std::array<double, kDescriptorBins * kFrameStride> basis_{};
};

}  // namespace backsight
