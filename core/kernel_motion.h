#pragma once

#include <array>

namespace backsight {

struct RigidTransform;

/// A rigid motion without Eigen, for kernels that are compiled for several instruction sets:
/// rotation, row by row, and translation.
struct KernelMotion {
  explicit KernelMotion(const RigidTransform& transform);

  std::array<double, 9> rotation;
  std::array<double, 3> translation;
};

}  // namespace backsight
