#include "io/run_records.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "io/picture_record.h"

namespace backsight {

std::string ToString(StationStatus status) {
  switch (status) {
    case StationStatus::kRegistered:
      return "registered";
    case StationStatus::kNotRegistered:
      return "not_registered";
    case StationStatus::kUnreadable:
      return "unreadable";
  }
  throw InternalError("unknown StationStatus");
}

std::string ToString(LinkStatus status) {
  switch (status) {
    case LinkStatus::kAccepted:
      return "accepted";
    case LinkStatus::kDoubtful:
      return "doubtful";
    case LinkStatus::kRejected:
      return "rejected";
    case LinkStatus::kFailed:
      return "failed";
    case LinkStatus::kSkipped:
      return "skipped";
  }
  throw InternalError("unknown LinkStatus");
}

std::string ToString(PictureRecord::Kind kind) {
  switch (kind) {
    case PictureRecord::Kind::kPlan:
      return "plan";
    case PictureRecord::Kind::kSection:
      return "section";
    case PictureRecord::Kind::kDetail:
      return "detail";
    case PictureRecord::Kind::kDistances:
      return "distances";
  }
  throw InternalError("unknown PictureRecord::Kind");
}

std::optional<PoseSigma> SigmaOf(const PoseRecord& pose) {
  if (!pose.covariance) return std::nullopt;
  BACKSIGHT_CHECK(pose.covariance->allFinite(), "covariance of station " + pose.station);
  return SigmaOf(pose.survey_from_station, *pose.covariance);
}

PoseSigma SigmaOf(const RigidTransform& motion, const Matrix6d& covariance) {
  const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(motion.translation);
  const Eigen::Matrix3d position = jacobian * covariance * jacobian.transpose();
  // Rounding may leave a variance of a fixed station just below zero.
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(position, Eigen::EigenvaluesOnly)
          .eigenvalues();
  return PoseSigma{
      covariance.diagonal().head<3>().cwiseMax(0.0).cwiseSqrt() * (180.0 / std::numbers::pi),
      position.diagonal().cwiseMax(0.0).cwiseSqrt(), std::sqrt(std::max(0.0, eigenvalues.z()))};
}

ErrorEllipse EllipseOf(const RigidTransform& motion, const Matrix6d& covariance) {
  const Eigen::Matrix<double, 2, 6> jacobian = PointJacobian(motion.translation).topRows<2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      Eigen::Matrix2d(jacobian * covariance * jacobian.transpose()));
  const Eigen::Vector2d axes = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  const double azimuth = std::atan2(major.x(), major.y()) * (180.0 / std::numbers::pi);
  return {axes.y(), axes.x(), azimuth < 0.0 ? azimuth + 180.0 : azimuth};
}

}  // namespace backsight
