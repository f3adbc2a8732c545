#include "core/kernel_motion.h"

#include "core/rigid_transform.h"

namespace backsight {

KernelMotion::KernelMotion(const RigidTransform& transform) {
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      rotation[static_cast<std::size_t>(3 * row + column)] = transform.rotation(row, column);
    }
    translation[static_cast<std::size_t>(row)] = transform.translation[row];
  }
}

}  // namespace backsight
