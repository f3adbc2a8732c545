#pragma once

#include <vector>

#include "core/rigid_transform.h"
#include "pipeline/station_pipeline.h"

namespace backsight {

/// Motions target_from_source under which what two levelled stations saw from above agrees, best
/// first, at most six; none unless both are levelled. Found without key points, among all headings
/// and all places within reach. Instrument frames. Some 40 ms.
std::vector<RigidTransform> ProposeByPlans(const Station& source, const Station& target);

}  // namespace backsight
