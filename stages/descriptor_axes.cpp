#include "stages/descriptor_axes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/error.h"

namespace backsight {
namespace {

constexpr int kBins = static_cast<int>(kDescriptorBins);
using BinMatrix = Eigen::Matrix<double, kBins, kBins>;
using BinColumns = Eigen::Matrix<double, kBins, Eigen::Dynamic>;
static_assert(std::tuple_size_v<FpfhDescriptor> == kDescriptorBins);

/// Some of the descriptors, evenly chosen, one a column.
BinColumns Sample(std::span<const FpfhDescriptor> descriptors) {
  constexpr std::size_t kMost = 256;
  const std::size_t count = std::min(kMost, descriptors.size());
  BinColumns sample(kBins, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const FpfhDescriptor& d = descriptors[i * descriptors.size() / count];
    sample.col(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::Matrix<float, kBins, 1>>(d.data()).cast<double>();
  }
  return sample;
}

BinColumns SampleOfBoth(std::span<const FpfhDescriptor> a, std::span<const FpfhDescriptor> b) {
  const BinColumns of_a = Sample(a);
  const BinColumns of_b = Sample(b);
  BinColumns sample(kBins, of_a.cols() + of_b.cols());
  sample << of_a, of_b;
  return sample;
}

}  // namespace

DescriptorAxes::DescriptorAxes(std::span<const FpfhDescriptor> a,
                               std::span<const FpfhDescriptor> b) {
  BinColumns sample = SampleOfBoth(a, b);
  Eigen::Map<Eigen::Matrix<double, kBins, 1>> mean(mean_.data());
  mean = sample.rowwise().mean();
  sample.colwise() -= mean;
  BinMatrix scatter = BinMatrix::Zero();
  scatter.selfadjointView<Eigen::Lower>().rankUpdate(sample);
  const Eigen::SelfAdjointEigenSolver<BinMatrix> ascending(scatter);
  BACKSIGHT_CHECK(ascending.info() == Eigen::Success, "bins of descriptors are finite");
  for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
    for (std::size_t axis = 0; axis < kDescriptorAxes; ++axis) {
      basis_[bin * kFrameStride + axis] = ascending.eigenvectors()(
          static_cast<int>(bin), static_cast<int>(kDescriptorBins - 1 - axis));
    }
  }
}

double DescriptorAxes::SquaredLength(const FpfhDescriptor& descriptor) const {
  constexpr std::size_t kTogether = 4;  // sums that do not wait for each other
  constexpr std::size_t kLast = kDescriptorBins - 1;
  static_assert(kLast % kTogether == 0);
  const auto from_mean = [&](std::size_t bin) {
    return static_cast<double>(descriptor[bin]) - mean_[bin];
  };
  std::array<double, kTogether> sums{};
  for (std::size_t bin = 0; bin < kLast; bin += kTogether) {
    for (std::size_t n = 0; n < kTogether; ++n) sums[n] += from_mean(bin + n) * from_mean(bin + n);
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]) + from_mean(kLast) * from_mean(kLast);
}

}  // namespace backsight
