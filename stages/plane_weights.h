#pragma once

#include <span>
#include <vector>

#include "core/execution.h"
#include "graph/planar_statistics.h"

namespace backsight {

/// A dense cluster tells no more than `cap` points would: its errors are not independent.
void CapCount(double cap, PointCluster* cluster);

struct PlaneWeights {
  double sigma0_m = 0.0;         ///< median of the patches' own thickness, at least 1 mm
  double agreement_scale = 1.0;  ///< typical excess per degree of freedom, formal value 1
  /// Mean derivative of a plane's pull by its misfit, over its weight: what robust weights take
  /// from the information beyond what they take from the pull (Huber 1981, chapter 6). 1 without
  /// them.
  double slope = 1.0;
  double agreement_factor = 1.0;  ///< weighted excess per degree of freedom of the whole network
};

/// Maximum-likelihood weights n / (2 sigma^2), sigma^2 the patches' own thickness or sigma0^2,
/// whichever is larger. A plane whose excess per degree of freedom, e, is beyond what 99 % of
/// planes have when errors are normal and of the median's scale, is weighed down by that bound over
/// e.
PlaneWeights SetNetworkWeights(std::span<const RigidTransform> poses,
                               const ExecutionContext& context, std::vector<WeightedPlane>* planes);

}  // namespace backsight
