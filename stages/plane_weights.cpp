#include "stages/plane_weights.h"

#include <algorithm>
#include <cmath>

namespace backsight {
namespace {

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void CapCount(double cap, PointCluster* cluster) {
  if (cluster->count <= cap) return;
  cluster->scatter *= cap / cluster->count;
  cluster->count = cap;
}

PlaneWeights SetNetworkWeights(std::span<const RigidTransform> poses,
                               const ExecutionContext& context,
                               std::vector<WeightedPlane>* planes) {
  std::vector<PlaneAgreement> agreements(planes->size());
  context.ParallelFor(
      planes->size(), [&](std::size_t k) { agreements[k] = Agreement((*planes)[k], poses); }, 64);
  std::vector<double> thickness;
  std::vector<double> excess;  // per degree of freedom
  for (const PlaneAgreement& agreement : agreements) {
    thickness.push_back(agreement.own_thickness_m2);
    excess.push_back(agreement.excess_m2 / agreement.freedom);
  }
  constexpr double kFloor = 0.001 * 0.001;  // m^2: no plane is better than a millimetre
  const double variance = std::max(Median(thickness), kFloor);
  constexpr double kMedianOfChiSquared3 = 0.789;  // per degree of freedom
  // Noise-free data must not divide by zero; a thousandth of sigma0 is as good as exact.
  const double scale = std::max(Median(excess) / kMedianOfChiSquared3, 1e-6 * variance);

  PlaneWeights weights;
  weights.sigma0_m = std::sqrt(variance);
  weights.agreement_scale = scale / variance;
  double sum = 0.0;
  double freedom = 0.0;
  for (std::size_t k = 0; k < planes->size(); ++k) {
    WeightedPlane& plane = (*planes)[k];
    double count = 0.0;
    for (const PlaneObservation& o : plane.observations) count += o.cluster.count;
    constexpr double kThick = 100.0;  // only planes ten times as thick as most lose weight
    constexpr double kApart = 9.0;    // and those whose patches disagree three times as much
    const double thick = 1.0 / (1.0 + thickness[k] / (kThick * variance));
    const double apart = 1.0 / (1.0 + excess[k] / (kApart * scale));
    const double robust = thick * thick * apart * apart;
    plane.weight = count / (2.0 * variance) * robust;
    sum += robust * agreements[k].excess_m2 / variance;
    freedom += robust * agreements[k].freedom;
  }
  const double unknowns = 6.0 * (static_cast<double>(poses.size()) - 1.0);
  if (freedom > unknowns) weights.agreement_factor = sum / (freedom - unknowns);
  return weights;
}

}  // namespace backsight
