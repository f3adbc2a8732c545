#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// Upper limits of the classes by which the plan colours accepted links, metres; the last class is
/// open.
inline constexpr double kResidualClassesM[] = {0.002, 0.005, 0.010};

/// Class 0 to 3 of a network residual.
int ResidualClass(double residual_m);

/// Plan view (x to the right, y up, to scale) of one component of the network as inline SVG:
/// stations with labels, accepted links by residual class, rejected links dashed, axes, scale bar.
/// Throws InternalError for a non-finite position or residual.
std::string PlanSvg(const RunRecord& run, int component);

}  // namespace backsight
