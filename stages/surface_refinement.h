#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"

namespace backsight {

/// Voxels of the source that a refinement uses (ChooseSurfaces): more of them say little more.
inline constexpr std::size_t kRefinedSurfaces = 15000;

/// Generalised ICP on voxel means (Segal et al. 2009, doi 10.15607/RSS.2009.V.021): minimises the
/// squared distances of nearest voxels of like normal, with `normal_sigma_m` across a voxel's
/// surface and its edge along it, plus 0.5 r^T prior r, r = LocalDifference(T, start). So curved
/// and small surfaces, which no plane covers, have their say; on dense scans the planes'
/// information prevails. Returns the start where fewer than 100 voxels match. `chosen`: voxels of
/// the source with a defined normal; `target_index` is the target's. Time O(iterations * chosen).
RigidTransform RefineOnSurfaces(const Surface& source, std::span<const std::uint32_t> chosen,
                                const Surface& target, const CloudIndex& target_index,
                                const RigidTransform& start, const Matrix6d& prior,
                                double normal_sigma_m, int max_iterations = 10);

/// A few steps of it on 4,000 voxels: enough to compare motions.
RigidTransform RefineRoughly(const Surface& source, const Surface& target,
                             const CloudIndex& target_index,
                             const RigidTransform& target_from_source);

}  // namespace backsight
