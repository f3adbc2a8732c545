#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "io/geodetic_frame.h"
#include "io/survey_project.h"
#include "pipeline/network_pipeline.h"
#include "stages/georeferencing.h"

namespace backsight {

/// A component of the network and what its control made of it.
struct GeoreferencedPart {
  GeoreferencingResult result;
  std::vector<int> control;  ///< indices into SurveyProject::control, in the result's order
  std::vector<int> check;

  bool placed() const {
    return result.status == GeoreferencingResult::Status::kGeoreferenced ||
           result.status == GeoreferencingResult::Status::kContradictory;
  }
};

/// All components in the frame of the control: `enu` of the project's CRS, or the local Cartesian
/// grid itself where the project names no CRS.
struct GeoreferencedNetwork {
  std::shared_ptr<const GeodeticFrame> frame;  ///< null: a local grid, or no control
  std::vector<GeoreferencedPart> parts;        ///< by component; empty without control
  std::vector<std::optional<RigidTransform>> enu_from_station;  ///< by station
  std::vector<Matrix6d> covariance;                             ///< of these, Retract's convention

  /// Coordinates measured in stations of a component grow by this much.
  double ScaleOf(int component) const;
  /// From enu to the coordinates that outputs are in.
  Eigen::Vector3d OutputFromEnu(const Eigen::Vector3d& enu) const;
};

/// Ties every component to the control that its stations measured; `frame`: MakeControlFrame of the
/// project.
GeoreferencedNetwork GeoreferenceNetwork(const SurveyProject& project,
                                         std::shared_ptr<const GeodeticFrame> frame,
                                         const std::vector<Station>& stations,
                                         const Network& network,
                                         const GeoreferencingOptions& options);

}  // namespace backsight
