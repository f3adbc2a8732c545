#pragma once

#include <memory>
#include <vector>

#include "graph/control_adjustment.h"
#include "io/geodetic_frame.h"
#include "io/survey_project.h"

namespace backsight {

/// The frame of the project's control, its origin amid the control; null for a local grid or no
/// control. Throws InputError where FindControlFaults finds a fault.
std::shared_ptr<const GeodeticFrame> MakeControlFrame(const SurveyProject& project);

/// Why control cannot place the project whatever the network: a CRS that GeodeticFrame refuses, a
/// CRS without control, places where the CRS is not used, too few control points or all on one
/// line.
std::vector<ProjectFault> FindControlFaults(const SurveyProject& project, const WholeParts& whole);

/// A point without its sightings, in enu of `frame`, or as given where that is null.
SurveyedPoint MakeSurveyedPoint(const ControlPoint& point, const GeodeticFrame* frame);

/// By place among `stations`.
std::vector<TiltObservation> LevelledStations(const std::vector<StationSpec>& stations);

}  // namespace backsight
