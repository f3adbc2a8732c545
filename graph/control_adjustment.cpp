#include "graph/control_adjustment.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "graph/network_covariance.h"

namespace backsight {
namespace {

using Status = ControlAdjustmentResult::Status;
using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// Gauss-Newton over [enu_from_survey; log of scale, where sought; stations but the first].
class Adjuster {
 public:
  Adjuster(const ControlAdjustmentInput& input, bool move_stations)
      : input_(input),
        poses_(input.survey_from_station.begin(), input.survey_from_station.end()),
        moved_(move_stations ? static_cast<Eigen::Index>(6 * (poses_.size() - 1)) : 0),
        first_station_(input.estimate_scale ? 7 : 6) {
    for (const SurveyedPoint& point : input.points) weights_.push_back(WeightMatrix(point));
    if (moved_ == 0) return;
    // A tenth of a micrometre: keeps poses that are known exactly from making it singular.
    constexpr double kFloor = 1e-14;
    Eigen::MatrixXd free = input.covariance.bottomRightCorner(moved_, moved_);
    free.diagonal().array() += kFloor;
    free_information_ = free.ldlt().solve(Eigen::MatrixXd::Identity(moved_, moved_));
  }

  ControlAdjustmentResult Run() {
    const std::optional<RigidTransform> start = StartMotion(input_);
    if (!IsDetermined(input_) || !start) return {};
    result_.enu_from_survey = *start;
    result_.status = Status::kDiverged;
    constexpr int kMaxIterations = 30;
    for (int i = 0; i < kMaxIterations; ++i) {
      Assemble();
      const Eigen::VectorXd step = -matrix_.ldlt().solve(gradient_);
      if (!step.allFinite()) return std::move(result_);
      Move(step);
      // At a scale of zero nothing moves any more, which is no end but a collapse.
      constexpr double kLargestScale = 1e6;
      if (!(result_.scale > 1.0 / kLargestScale && result_.scale < kLargestScale)) {
        return std::move(result_);
      }
      constexpr double kSettled = 1e-9;  // m and rad
      if (step.cwiseAbs().maxCoeff() < kSettled) {
        result_.status = Status::kAdjusted;
        break;
      }
    }
    Assemble();
    Finish();
    return std::move(result_);
  }

 private:
  Eigen::Index size() const { return first_station_ + moved_; }

  /// Sightings of one point share the error of its coordinates.
  Eigen::MatrixXd Variance(const SurveyedPoint& point) const {
    const auto n = static_cast<Eigen::Index>(point.sightings.size());
    Eigen::MatrixXd variance = point.Covariance().replicate(n, n);
    variance.diagonal().array() += input_.sighting_sigma_m * input_.sighting_sigma_m;
    return variance;
  }
  Eigen::MatrixXd WeightMatrix(const SurveyedPoint& point) const {
    const Eigen::MatrixXd variance = Variance(point);
    return variance.ldlt().solve(Eigen::MatrixXd::Identity(variance.rows(), variance.cols()));
  }

  Eigen::Vector3d EnuPoint(const Eigen::Vector3d& survey) const {
    return result_.scale * (result_.enu_from_survey.rotation * survey) +
           result_.enu_from_survey.translation;
  }

  /// Column of a station's perturbation, or -1 where it stays.
  Eigen::Index ColumnOf(int station) const {
    return moved_ == 0 || station == 0 ? -1 : first_station_ + 6 * (station - 1);
  }

  Eigen::VectorXd ResidualsOf(const SurveyedPoint& point) const {
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(3 * point.sightings.size()));
    for (std::size_t i = 0; i < point.sightings.size(); ++i) {
      const Sighting& sighting = point.sightings[i];
      const Eigen::Vector3d survey =
          poses_[static_cast<std::size_t>(sighting.station)] * sighting.point_m;
      residuals.segment<3>(static_cast<Eigen::Index>(3 * i)) = EnuPoint(survey) - point.enu_m;
    }
    return residuals;
  }

  Eigen::MatrixXd JacobianOf(const SurveyedPoint& point) const {
    Eigen::MatrixXd rows =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * point.sightings.size()), size());
    for (std::size_t i = 0; i < point.sightings.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(3 * i);
      const Sighting& sighting = point.sightings[i];
      const Eigen::Vector3d survey =
          poses_[static_cast<std::size_t>(sighting.station)] * sighting.point_m;
      const Eigen::Vector3d enu = EnuPoint(survey);
      rows.block<3, 6>(row, 0) = PointJacobian(enu);
      if (input_.estimate_scale) {
        rows.block<3, 1>(row, 6) = enu - result_.enu_from_survey.translation;
      }
      const Eigen::Index column = ColumnOf(sighting.station);
      if (column < 0) continue;
      rows.block<3, 6>(row, column) =
          result_.scale * result_.enu_from_survey.rotation * PointJacobian(survey);
    }
    return rows;
  }

  void Add(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
           const Eigen::MatrixXd& weight) {
    const Eigen::MatrixXd weighted = weight * jacobian;
    matrix_.noalias() += jacobian.transpose() * weighted;
    gradient_.noalias() += weighted.transpose() * residuals;
    result_.chi2 += residuals.dot(weight * residuals);
  }

  void Assemble() {
    matrix_ = Eigen::MatrixXd::Zero(size(), size());
    gradient_ = Eigen::VectorXd::Zero(size());
    result_.chi2 = 0.0;
    for (std::size_t k = 0; k < input_.points.size(); ++k) {
      Add(JacobianOf(input_.points[k]), ResidualsOf(input_.points[k]), weights_[k]);
    }
    AddVertical();
    AddFreeNetwork();
  }

  /// The part of the levelling that the free network left open: its mean axis is vertical.
  void AddVertical() {
    if (input_.tilts.empty()) return;
    const Eigen::Matrix3d& rotation = result_.enu_from_survey.rotation;
    const Vertical vertical = EstimateVertical(input_.tilts, poses_);
    const Eigen::Vector3d axis = rotation * vertical.mean;
    Jacobian jacobian = Jacobian::Zero(3, size());
    jacobian.leftCols<3>() = -Skew(axis);
    for (const TiltObservation& tilt : input_.tilts) {
      const Eigen::Index column = ColumnOf(tilt.station);
      if (column < 0) continue;
      const Eigen::Vector3d z = poses_[static_cast<std::size_t>(tilt.station)].rotation.col(2);
      jacobian.middleCols<3>(column) = -tilt.weight() / vertical.weight * rotation * Skew(z);
    }
    Add(jacobian.topRows<2>(), axis.head<2>(), vertical.weight * Eigen::Matrix2d::Identity());
  }

  void AddFreeNetwork() {
    if (moved_ == 0) return;
    Eigen::VectorXd difference(moved_);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(moved_, moved_);
    for (std::size_t s = 1; s < poses_.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(6 * (s - 1));
      const Vector6d xi = LocalDifference(poses_[s], input_.survey_from_station[s]);
      difference.segment<6>(row) = xi;
      jacobian.block<6, 6>(row, row) = LocalDifferenceJacobian(xi);
    }
    const Eigen::VectorXd weighted = free_information_ * difference;
    matrix_.bottomRightCorner(moved_, moved_).noalias() +=
        jacobian.transpose() * free_information_ * jacobian;
    gradient_.tail(moved_).noalias() += jacobian.transpose() * weighted;
    result_.chi2 += difference.dot(weighted);
  }

  void Move(const Eigen::VectorXd& step) {
    const Vector6d motion = step.head<6>();
    result_.enu_from_survey = Retract(result_.enu_from_survey, motion);
    if (input_.estimate_scale) result_.scale *= std::exp(step[6]);
    for (std::size_t s = 1; moved_ > 0 && s < poses_.size(); ++s) {
      const Vector6d xi = step.segment<6>(ColumnOf(static_cast<int>(s)));
      poses_[s] = Retract(poses_[s], xi);
    }
  }

  void Finish() {
    const Eigen::MatrixXd inverse = matrix_.ldlt().solve(Eigen::MatrixXd::Identity(size(), size()));
    if (input_.estimate_scale) result_.scale_sigma = result_.scale * std::sqrt(inverse(6, 6));
    int observations = input_.tilts.empty() ? 0 : 2;
    for (std::size_t k = 0; k < input_.points.size(); ++k) {
      const SurveyedPoint& point = input_.points[k];
      observations += static_cast<int>(3 * point.sightings.size());
      result_.residuals.push_back(Test(point, weights_[k], inverse));
    }
    result_.redundancy = observations - static_cast<int>(first_station_);
    const RigidTransform& motion = result_.enu_from_survey;
    for (const RigidTransform& pose : poses_) {
      result_.enu_from_station.push_back(
          {motion.rotation * pose.rotation, EnuPoint(pose.translation)});
    }
    if (moved_ > 0) PropagateCovariance(inverse);
  }

  PointResidual Test(const SurveyedPoint& point, const Eigen::MatrixXd& weight,
                     const Eigen::MatrixXd& inverse) const {
    const auto n = static_cast<Eigen::Index>(point.sightings.size());
    const Eigen::VectorXd residuals = ResidualsOf(point);
    const Eigen::MatrixXd jacobian = JacobianOf(point);
    const Eigen::MatrixXd shift = point.axes.replicate(n, 1);  // of all sightings, by a blunder
    PointResidual result;
    const Eigen::MatrixXd cofactors = Variance(point) - jacobian * inverse * jacobian.transpose();
    const Eigen::MatrixXd weighted = weight * shift;
    const Eigen::Matrix3d alone = shift.transpose() * weighted;
    const Eigen::Matrix3d checked = weighted.transpose() * cofactors * weighted;
    const Eigen::Vector3d pull = weighted.transpose() * residuals;
    constexpr double kChecked = 1e-4;  // of the weight: redundancy below it is rounding
    for (int axis = 0; axis < 3; ++axis) {
      if (checked(axis, axis) < kChecked * alone(axis, axis)) continue;
      result.w[axis] = pull[axis] / std::sqrt(checked(axis, axis));
      result.checked[static_cast<std::size_t>(axis)] = true;
    }
    return result;
  }

  void PropagateCovariance(const Eigen::MatrixXd& inverse) {
    const auto rows = static_cast<Eigen::Index>(6 * poses_.size());
    const RigidTransform& motion = result_.enu_from_survey;
    Matrix6d adjoint = Adjoint(motion);
    adjoint.bottomRightCorner<3, 3>() *= result_.scale;
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows, size());
    for (std::size_t s = 0; s < poses_.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(6 * s);
      jacobian.block<6, 6>(row, 0).setIdentity();
      if (input_.estimate_scale) {
        jacobian.block<3, 1>(row + 3, 6) =
            result_.scale * (motion.rotation * poses_[s].translation);
      }
      const Eigen::Index column = ColumnOf(static_cast<int>(s));
      if (column >= 0) jacobian.block<6, 6>(row, column) = adjoint;
    }
    result_.covariance = jacobian * inverse * jacobian.transpose();
    if (input_.estimate_scale) result_.scale_covariance = jacobian * inverse.col(6);
  }

  const ControlAdjustmentInput& input_;
  std::vector<RigidTransform> poses_;
  Eigen::Index moved_;          // rows of the stations that move
  Eigen::Index first_station_;  // their first column
  std::vector<Eigen::MatrixXd> weights_;
  Eigen::MatrixXd free_information_;
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd gradient_;
  ControlAdjustmentResult result_;
};

/// Coordinates of either side may be national ones: about their far-away zero rotations and
/// translations would be all but the same, so both sides are centred on the points.
ControlAdjustmentResult AdjustCentred(const ControlAdjustmentInput& input, bool move_stations) {
  if (input.points.empty()) return {};
  Eigen::Vector3d survey = Eigen::Vector3d::Zero();
  Eigen::Vector3d enu = Eigen::Vector3d::Zero();
  for (const SurveyedPoint& point : input.points) {
    survey += MeanSurveyPoint(point, input.survey_from_station);
    enu += point.enu_m;
  }
  survey /= static_cast<double>(input.points.size());
  enu /= static_cast<double>(input.points.size());

  ControlAdjustmentInput centred = input;
  std::vector<RigidTransform> poses(input.survey_from_station.begin(),
                                    input.survey_from_station.end());
  for (RigidTransform& pose : poses) pose.translation -= survey;
  centred.survey_from_station = poses;
  const RigidTransform to_centre{Eigen::Matrix3d::Identity(), -survey};
  centred.covariance = InFrame(to_centre, input.covariance);
  for (SurveyedPoint& point : centred.points) point.enu_m -= enu;

  ControlAdjustmentResult result = Adjuster(centred, move_stations).Run();
  const RigidTransform from_centre{Eigen::Matrix3d::Identity(), enu};
  result.enu_from_survey.translation +=
      enu - result.scale * (result.enu_from_survey.rotation * survey);
  for (RigidTransform& pose : result.enu_from_station) pose.translation += enu;
  if (result.covariance.size() > 0) result.covariance = InFrame(from_centre, result.covariance);
  for (Eigen::Index row = 0; row < result.scale_covariance.size(); row += 6) {
    const Vector6d moved = Adjoint(from_centre) * result.scale_covariance.segment<6>(row);
    result.scale_covariance.segment<6>(row) = moved;
  }
  return result;
}

}  // namespace

ControlAdjustmentResult FitToControl(const ControlAdjustmentInput& input) {
  ControlAdjustmentResult result = AdjustCentred(input, /*move_stations=*/false);
  for (PointResidual& residual : result.residuals) {
    residual.w.setZero();
    residual.checked = {false, false, false};
  }
  return result;
}

ControlAdjustmentResult AdjustToControl(const ControlAdjustmentInput& input) {
  return AdjustCentred(input, /*move_stations=*/true);
}

}  // namespace backsight
