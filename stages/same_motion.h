#pragma once

#include <numbers>

#include "core/rigid_transform.h"

namespace backsight {

/// Whether two motions of a pair, or two places of a station, are one: closer than 5 deg, and than
/// 10 l at the moved scanner.
inline bool IsSameMotion(const RigidTransform& a, const RigidTransform& b, double resolution_m) {
  constexpr double kNearAngle = 5.0 * std::numbers::pi / 180.0;
  return (a.translation - b.translation).norm() < 10.0 * resolution_m &&
         RotationAngle(a.rotation, b.rotation) < kNearAngle;
}

}  // namespace backsight
