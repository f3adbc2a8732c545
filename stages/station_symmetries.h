#pragma once

#include <vector>

#include "core/execution.h"
#include "stages/cloud_agreement.h"
#include "stages/coarse_registration.h"
#include "stages/matching.h"

namespace backsight {

/// Motions other than identity that carry a station's cloud onto itself: the half turn of a hall,
/// the step of a facade from bay to bay. A motion between two stations, followed by such a one,
/// gathers much the same surfaces, so a pair with a symmetric station has rivals.
///
/// The station is matched with itself, its key points with others than themselves; RGN and RGE
/// and its structure (FindStructureImages) propose, the clouds decide: at least a quarter of the
/// voxels on surfaces of like normal and fewer than a tenth of the blocks in view seen through.
/// With each motion its inverse; at most 24, best first. Cost as of one coarse registration.
std::vector<RigidTransform> FindSymmetries(const Surface& surface, const StationFeatures& features,
                                           const CloudIndex& index, const MatchingOptions& matching,
                                           const CoarseOptions& coarse,
                                           const ExecutionContext& context);

}  // namespace backsight
