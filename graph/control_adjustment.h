#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/control_points.h"

namespace backsight {

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

/// The motion alone that carries the network, as it is, closest to the points: stations stay where
/// the free network has them. Residuals without w; no covariance.
ControlAdjustmentResult FitToControl(const ControlAdjustmentInput& input);

/// Joins the free network (its poses as observations with their covariance) and control points
/// (weighted by theirs) in one adjustment, so that a bent network follows its control; the
/// quadratic of the free network stands for all its observations. Levelled stations add that their
/// mean axis is vertical, which the free network left open. Gauss-Newton; time O((6 M)^3).
ControlAdjustmentResult AdjustToControl(const ControlAdjustmentInput& input);

}  // namespace backsight
