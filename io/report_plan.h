#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// Upper limits of the classes by which the plan colours accepted links, metres; the last class is
/// open.
inline constexpr double kResidualClassesM[] = {0.002, 0.005, 0.010};

/// Class 0 to 3 of a network residual.
int ResidualClass(double residual_m);

/// Where a station stands in drawings and tables: in the frame of the control where that places it,
/// otherwise in the survey frame.
const RigidTransform& ShownPose(const PoseRecord& pose);
/// The covariance of that; none where there is none.
std::optional<Matrix6d> ShownCovariance(const PoseRecord& pose);

/// Whether the frame of the control has true north, unlike the coordinates, which have grid north.
bool IsTrueNorth(const RunRecord& run);

/// Plan view (to scale) of one component of the network as inline SVG with its legend below:
/// stations with names and exaggerated error ellipses, accepted links by residual class with their
/// worst direction, rejected links dashed, axes, scale bar. Throws InternalError for a non-finite
/// position or residual.
std::string PlanSvg(const RunRecord& run, int component);

}  // namespace backsight
