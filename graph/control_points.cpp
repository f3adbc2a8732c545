#include "graph/control_points.h"

#include <Eigen/SVD>

#include "graph/rigid_fit.h"

namespace backsight {

Eigen::Matrix3d SurveyedPoint::Covariance() const {
  return axes * sigma_m.array().square().matrix().asDiagonal() * axes.transpose();
}

bool IsDetermined(const ControlAdjustmentInput& input) {
  const auto n = static_cast<Eigen::Index>(input.points.size());
  if (n < 2) return false;
  Eigen::Matrix3Xd spread(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    spread.col(k) = input.points[static_cast<std::size_t>(k)].enu_m;
  }
  spread.colwise() -= Eigen::Vector3d(spread.rowwise().mean());
  constexpr double kNotOnALine = 0.05;
  const auto singular = [](const auto& matrix) {
    return Eigen::VectorXd(Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues());
  };
  const Eigen::VectorXd all = singular(spread);
  if (n >= 3 && all[1] > kNotOnALine * all[0]) return true;
  return !input.tilts.empty() && singular(spread.topRows(2))[0] > kNotOnALine * all[0];
}

Eigen::Vector3d MeanSurveyPoint(const SurveyedPoint& point, std::span<const RigidTransform> poses) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sighting& sighting : point.sightings) {
    sum += poses[static_cast<std::size_t>(sighting.station)] * sighting.point_m;
  }
  return sum / static_cast<double>(point.sightings.size());
}

std::optional<RigidTransform> StartMotion(const ControlAdjustmentInput& input) {
  Correspondences pairs;
  std::vector<double> weights;
  const Eigen::Vector3d up = EstimateVertical(input.tilts, input.survey_from_station).mean;
  for (const SurveyedPoint& point : input.points) {
    const Eigen::Vector3d seen = MeanSurveyPoint(point, input.survey_from_station);
    const double weight = 3.0 / point.sigma_m.squaredNorm();
    pairs.Add(seen, point.enu_m, 0, 0);
    weights.push_back(weight);
    if (input.tilts.empty()) continue;
    constexpr double kAbove = 10.0;
    pairs.Add(seen + kAbove * up, point.enu_m + kAbove * Eigen::Vector3d::UnitZ(), 0, 0);
    weights.push_back(weight);
  }
  return FitRigid(pairs, weights);
}

}  // namespace backsight
