#pragma once

#include <span>
#include <vector>

#include "core/execution.h"
#include "graph/planar_statistics.h"

namespace backsight {

/// A dense cluster tells no more than `cap` points would: its errors are not independent.
void CapCount(double cap, PointCluster* cluster);

struct PlaneWeights {
  double sigma0_m = 0.0;          ///< median of the patches' own thickness, at least 1 mm
  double agreement_scale = 1.0;   ///< typical excess per degree of freedom, formal value 1
  double agreement_factor = 1.0;  ///< weighted excess per degree of freedom of the whole network
};

/// Maximum-likelihood weights n / (2 sigma0^2) times robust factors that take out planes whose
/// stations disagree more than most do, and planes ten times as thick as most.
PlaneWeights SetNetworkWeights(std::span<const RigidTransform> poses,
                               const ExecutionContext& context, std::vector<WeightedPlane>* planes);

}  // namespace backsight
