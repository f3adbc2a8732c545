#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/correspondences.h"
#include "stages/surface.h"

namespace backsight {

/// Rotations target_from_source that lay the walls of one building on each other: four where both
/// stations are levelled (z up), otherwise the 24 of a cube. Empty where either cloud has no
/// dominant directions: fewer than three tenths of what is not floor face them.
std::vector<Eigen::Matrix3d> AlignedRotations(const Surface& source, const Surface& target,
                                              bool levelled);

/// Motions for known rotations: every correspondence then asks for one translation, and where
/// several key points ask for the same, within 6 l, there is a motion. Three of them are enough
/// where RGE's edges, which must tell rotations too, need twice as many. The `count` translations
/// with the most distinct source key points, of all rotations together, best first. Time
/// O(rotations * correspondences), about 10 ms for 7,500 correspondences and four rotations.
std::vector<RigidTransform> VoteForTranslations(const Correspondences& c,
                                                std::span<const Eigen::Matrix3d> rotations,
                                                double resolution_m, std::size_t count);

}  // namespace backsight
