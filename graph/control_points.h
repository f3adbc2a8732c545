#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/pose_observations.h"

namespace backsight {

/// Where a station measured a survey point, station frame, metres.
struct Sighting {
  int station = 0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};

/// A point with coordinates in the Cartesian frame of the control, and where stations saw it.
struct SurveyedPoint {
  Eigen::Vector3d enu_m = Eigen::Vector3d::Zero();
  /// Columns: the orthonormal directions that the coordinates were given along (those of a map
  /// grid are turned against east and north by its convergence).
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();  ///< along `axes`, positive
  std::vector<Sighting> sightings;                    ///< one at least

  /// m^2, enu.
  Eigen::Matrix3d Covariance() const;
};

/// A free network and the control points that tie it to the ground. `enu` is any Cartesian frame
/// whose z axis is up where levelled stations take part.
struct ControlAdjustmentInput {
  std::span<const RigidTransform> survey_from_station;
  /// Joint covariance of these, 6 rows per station, Retract's convention; the first station is the
  /// datum, its rows are zero.
  Eigen::MatrixXd covariance;
  std::vector<SurveyedPoint> points;
  double sighting_sigma_m = 0.001;     ///< of each coordinate of a sighting
  std::vector<TiltObservation> tilts;  ///< levelled stations
  bool estimate_scale = false;
};

/// True if the points fix a motion: three that are not on one line (second singular value of their
/// spread above 1/20 of the first), or two that are not above one another and levelled stations.
bool IsDetermined(const ControlAdjustmentInput& input);

/// Where the stations see a point, survey frame: mean over its sightings.
Eigen::Vector3d MeanSurveyPoint(const SurveyedPoint& point, std::span<const RigidTransform> poses);

/// The closest motion enu_from_survey in closed form, from which the adjustment starts; nothing
/// where the sighted points leave it open. Levelled stations give each point a second one above it.
std::optional<RigidTransform> StartMotion(const ControlAdjustmentInput& input);

}  // namespace backsight
