#pragma once

#include <Eigen/Core>
#include <span>

#include "core/rigid_transform.h"
#include "graph/planar_cost.h"

namespace backsight {

/// Directions of translation that the planes of two stations leave open: unit columns, frame of
/// `poses`, none, one, two or three. At poses that no adjustment of these planes has moved: it
/// bends their normals until they seem to know more.
///
/// A plane's normal u is known to sigma / sqrt(n lambda) along its axes of variance lambda only. So
/// planes that all contain a direction d still seem to know it (errors in variables): of their
/// information on a translation, G = sum f u u^T with f that of the offset between both patches,
/// N = sum f Cov(u) is expected from these errors alone. It is no knowledge, but holds patches of
/// the two stations with their centroids, which follow the beams, upon each other. d is open where
/// d^T G d < least_ratio d^T N d (docs/stages/fine_registration.md says what is usual). Sigma is
/// 1 mm at least. O(planes), some 0.2 us each.
Eigen::Matrix3Xd OpenTranslations(std::span<const WeightedPlane> planes,
                                  std::span<const RigidTransform> poses, double least_ratio);

/// `motion`, but with `point` (source frame) where `start` has it in the open directions; all else
/// follows as `information` on `motion` wants it (after solution remapping: Zhang, Kaess, Singh
/// 2016, doi 10.1109/ICRA.2016.7487211). To first order in how far that is.
RigidTransform HoldTranslations(const Eigen::Matrix3Xd& open, const Eigen::Vector3d& point,
                                const RigidTransform& start, const Matrix6d& information,
                                const RigidTransform& motion);

/// The information without what it says of translations in the open directions: as if such a
/// translation, whatever its size, were to be estimated as well.
Matrix6d WithoutTranslations(const Eigen::Matrix3Xd& open, const Matrix6d& information);

}  // namespace backsight
