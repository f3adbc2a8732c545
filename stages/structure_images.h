#pragma once

#include <vector>

#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"

namespace backsight {

/// Other motions that lay the walls, floors and ceilings of two clouds on each other as well: what
/// buildings and halls built at right angles allow. Key points cannot be relied on to propose them,
/// because a motion under which both scanners happen to stand at mirrored places draws all votes.
///
/// The three principal directions of the target's normals give the 24 turns of a cube; for each,
/// along each direction, the shifts at which surfaces facing that way coincide most (correlation of
/// their offsets) give the translation. `target_from_source` must hold up to such a turn and shift,
/// as any motion that fits such a building does. Best first by correlation, at most 24; none where
/// the surfaces have no two dominant directions, as in a forest. About 20 ms.
std::vector<RigidTransform> FindStructureImages(const Surface& source,
                                                const CloudIndex& source_index,
                                                const Surface& target,
                                                const CloudIndex& target_index,
                                                const RigidTransform& target_from_source);

}  // namespace backsight
