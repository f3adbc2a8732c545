#include "stages/plane_weights.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"

namespace backsight {
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
  thickness.reserve(agreements.size());
  for (const PlaneAgreement& agreement : agreements) {
    thickness.push_back(agreement.own_thickness_m2);
  }
  constexpr double kFloor = 0.001 * 0.001;  // m^2: no plane is better than a millimetre
  const double variance = std::max(Median(thickness), kFloor);
  std::vector<double> excess;  // per degree of freedom, 1 where formal errors are true
  for (const PlaneAgreement& agreement : agreements) {
    const double own = std::max(agreement.own_thickness_m2, variance);
    excess.push_back(agreement.excess_m2 / own / agreement.freedom);
  }
  constexpr double kMedianOfChiSquared3 = 0.789;  // per degree of freedom
  // Noise-free data must not divide by zero; a thousandth of sigma0 is as good as exact.
  const double scale = std::max(Median(excess) / kMedianOfChiSquared3, 1e-6);

  PlaneWeights weights;
  weights.sigma0_m = std::sqrt(variance);
  double sum = 0.0;
  double freedom = 0.0;
  double slope = 0.0;
  constexpr double kFar = 3.78;  // chi^2 of 3 degrees of freedom at 99 %, per degree
  for (std::size_t k = 0; k < planes->size(); ++k) {
    WeightedPlane& plane = (*planes)[k];
    double count = 0.0;
    for (const PlaneObservation& o : plane.observations) count += o.cluster.count;
    const double relative = excess[k] / scale;
    const double robust = relative > kFar ? kFar / relative : 1.0;
    plane.weight = count / (2.0 * std::max(thickness[k], variance)) * robust;
    const double size = robust * agreements[k].freedom;
    sum += size * excess[k];
    freedom += size;
    slope += relative > kFar ? size * (1.0 - 2.0 / agreements[k].freedom) : size;
  }
  weights.slope = freedom > 0.0 ? slope / freedom : 1.0;
  const double unknowns = 6.0 * (static_cast<double>(poses.size()) - 1.0);
  if (freedom > unknowns) weights.agreement_factor = sum / (freedom - unknowns);
  return weights;
}

}  // namespace backsight
