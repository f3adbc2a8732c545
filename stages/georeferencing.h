#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/option_visitor.h"
#include "graph/control_adjustment.h"

namespace backsight {

struct GeoreferencingOptions {
  double sighting_sigma_m = 0.001;  ///< of each coordinate of a target as a station measured it
  bool estimate_scale = false;      ///< otherwise the scanners' scale stands
  double blunder_limit = 3.29;      ///< Baarda's w beyond which a point is suspected
};
void VisitOptions(OptionVisitor& visitor, GeoreferencingOptions& options);

/// One component of the free network and the survey points that its stations measured.
struct GeoreferencingInput {
  std::vector<RigidTransform> survey_from_station;
  Eigen::MatrixXd covariance;  ///< as in ControlAdjustmentInput
  std::vector<SurveyedPoint> control;
  std::vector<SurveyedPoint> check;  ///< takes no part in any fit
  std::vector<TiltObservation> tilts;
};

/// A control point: what the stations see of it less its given coordinates, along its axes, metres.
struct ControlResidual {
  Eigen::Vector3d free_m = Eigen::Vector3d::Zero();  ///< with the network moved as a whole
  Eigen::Vector3d adjusted_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< PointResidual; of an excluded point its last
  std::array<bool, 3> checked = {false, false, false};  ///< PointResidual
  int sightings = 0;
};

/// The same of a check point.
struct CheckResidual {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< that the covariances predict of it
  int sightings = 0;
};

/// What control says of the network's scale; applied only if asked for.
struct ScaleTest {
  double minus_one = 0.0;
  double sigma = 0.0;
};

struct GeoreferencingResult {
  enum class Status {
    kGeoreferenced,
    kTooFewPoints,   ///< less than three control points off a line, or two and levelled stations
    kContradictory,  ///< more blunders than can be told: nothing is excluded, covariances grown
    kDiverged,
  };
  Status status = Status::kTooFewPoints;
  ControlAdjustmentResult adjustment;    ///< with the control points in use
  std::vector<ControlResidual> control;  ///< all of them
  std::vector<char> excluded;            ///< control points found to be blunders
  double variance_factor = 1.0;  ///< applied to the covariance; above 1 only where significant
  std::optional<ScaleTest> scale_test;  ///< absent: its adjustment did not converge
  std::vector<CheckResidual> check;
};

/// Ties a component to its control. Each point is tested against the others (Baarda's w, a priori
/// variances); the most suspicious is excluded and all are tested anew, up to a third of them and
/// as long as the rest determine the motion. Beyond that, or where another point in its place would
/// explain the residuals as well, the control contradicts itself, which the status says. Scale is 1
/// unless asked for, and always tested; where it is estimated, its uncertainty is in what is
/// predicted of check points. Time O(blunders (6 M)^3).
GeoreferencingResult Georeference(const GeoreferencingInput& input,
                                  const GeoreferencingOptions& options);

}  // namespace backsight
