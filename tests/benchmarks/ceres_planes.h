#pragma once

#include <span>
#include <vector>

#include "graph/planar_cost.h"

namespace backsight {

struct CeresPlanesResult {
  std::vector<RigidTransform> poses;
  double final_cost = 0.0;
  int iterations = 0;
  bool converged = false;
};

/// The least sum of weight * lambda_1 as Ceres finds it with automatic differentiation: planes are
/// unknowns of their own (a normal on the sphere and an offset), each observation has the four
/// residuals whose squares sum to its points' squared distances, and Ceres eliminates the planes
/// (SPARSE_SCHUR). At the best planes the cost is that of AdjustPlanes.
CeresPlanesResult AdjustPlanesWithCeres(std::span<const WeightedPlane> planes,
                                        std::span<const RigidTransform> start, int fixed_station,
                                        double relative_decrease, int threads);

}  // namespace backsight
