#pragma once

#include <Eigen/Core>
#include <array>
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

/// How the residuals of one point stand against its given coordinates, along its axes.
struct PointResidual {
  /// Baarda's w for a blunder in the given coordinates along each axis (Baarda 1968, A testing
  /// procedure for use in geodetic networks): standard normal without one; 0 where nothing else
  /// checks the point.
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  std::array<bool, 3> checked = {false, false, false};  ///< whether anything else checks it
};

struct ControlAdjustmentResult {
  enum class Status {
    kAdjusted,
    kUndetermined,  ///< points and levelled stations leave a freedom open; everything else is unset
    kDiverged,
  };
  Status status = Status::kUndetermined;
  /// p_enu = scale * rotation * p_survey + translation.
  RigidTransform enu_from_survey;
  double scale = 1.0;
  double scale_sigma = 0.0;
  /// Station frames in enu; coordinates measured in them grow by `scale`.
  std::vector<RigidTransform> enu_from_station;
  Eigen::MatrixXd covariance;  ///< of these, 6 rows per station, Retract's convention
  /// Of these with the log of scale, as many rows; empty where scale was not estimated.
  Eigen::VectorXd scale_covariance;
  std::vector<PointResidual> residuals;
  int redundancy = 0;
  double chi2 = 0.0;  ///< weighted sum of squares; its expectation is the redundancy
};

/// True if the points fix a motion: three that are not on one line (second singular value of their
/// spread above 1/20 of the first), or two that are not above one another and levelled stations.
bool IsDetermined(const ControlAdjustmentInput& input);

/// The motion alone that carries the network, as it is, closest to the points: stations stay where
/// the free network has them. Residuals without w; no covariance.
ControlAdjustmentResult FitToControl(const ControlAdjustmentInput& input);

/// Joins the free network (its poses as observations with their covariance) and control points
/// (weighted by theirs) in one adjustment, so that a bent network follows its control; the
/// quadratic of the free network stands for all its observations. Levelled stations add that their
/// mean axis is vertical, which the free network left open. Gauss-Newton; time O((6 M)^3).
ControlAdjustmentResult AdjustToControl(const ControlAdjustmentInput& input);

}  // namespace backsight
