#pragma once

#include "core/rigid_transform.h"
#include "io/survey_project.h"

namespace backsight {

/// True if stations that stand where their priors say (5 sigma of both together granted) are
/// farther apart than 1.5 times `useful_range_m`, the larger range of the two.
bool ArePriorsTooFar(const StationPrior& a, const StationPrior& b, double useful_range_m);

/// True if a motion between two stations' own frames cannot be reconciled with their priors: turned
/// by more than 5 sigma, or shifted by more than 5 sigma + l. Sigmas are those of both priors
/// together; what the target's prior may be turned by shifts the source in proportion to its
/// distance.
bool ContradictsPriors(const StationPrior& source, const StationPrior& target,
                       const RigidTransform& target_from_source, double resolution_m);

}  // namespace backsight
