#include "stages/georeferencing.h"

#include <algorithm>
#include <cmath>

namespace backsight {
namespace {

using Status = GeoreferencingResult::Status;

ControlAdjustmentInput MakeInput(const GeoreferencingInput& input,
                                 const GeoreferencingOptions& options,
                                 const std::vector<char>& excluded) {
  ControlAdjustmentInput made{input.survey_from_station, input.covariance, {},
                              options.sighting_sigma_m,  input.tilts,      options.estimate_scale};
  for (std::size_t k = 0; k < input.control.size(); ++k) {
    if (excluded[k] == 0) made.points.push_back(input.control[k]);
  }
  return made;
}

/// What the stations see of a point less its coordinates, along its axes, mean over the sightings.
Eigen::Vector3d MeanResidual(const SurveyedPoint& point, const ControlAdjustmentResult& placed) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sighting& sighting : point.sightings) {
    const RigidTransform& pose =
        placed.enu_from_station[static_cast<std::size_t>(sighting.station)];
    sum += placed.scale * (pose.rotation * sighting.point_m) + pose.translation - point.enu_m;
  }
  return point.axes.transpose() * sum / static_cast<double>(point.sightings.size());
}

CheckResidual Check(const SurveyedPoint& point, const ControlAdjustmentResult& placed,
                    double sighting_sigma_m) {
  const auto count = static_cast<double>(point.sightings.size());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, placed.covariance.cols());
  Eigen::Vector3d growth = Eigen::Vector3d::Zero();  // with the log of scale
  for (const Sighting& sighting : point.sightings) {
    const RigidTransform& pose =
        placed.enu_from_station[static_cast<std::size_t>(sighting.station)];
    const Eigen::Vector3d enu =
        placed.scale * (pose.rotation * sighting.point_m) + pose.translation;
    jacobian.middleCols<6>(6 * sighting.station) += PointJacobian(enu) / count;
    growth += (enu - pose.translation) / count;
  }
  Eigen::Matrix3d variance =
      jacobian * placed.covariance * jacobian.transpose() + point.Covariance();
  if (placed.scale_covariance.size() > 0) {
    const Eigen::Matrix3d mixed = jacobian * placed.scale_covariance * growth.transpose();
    const double log_sigma = placed.scale_sigma / placed.scale;
    variance += mixed + mixed.transpose() + log_sigma * log_sigma * growth * growth.transpose();
  }
  variance.diagonal().array() += sighting_sigma_m * sighting_sigma_m / count;
  return {MeanResidual(point, placed),
          (point.axes.transpose() * variance * point.axes).diagonal().cwiseSqrt(),
          static_cast<int>(point.sightings.size())};
}

/// The 99.9 % quantile of chi^2 (Wilson and Hilferty 1931).
double ChiSquaredLimit(int freedom) {
  const double k = 2.0 / (9.0 * freedom);
  constexpr double kNormalQuantile = 3.09;
  return freedom * std::pow(1.0 - k + kNormalQuantile * std::sqrt(k), 3);
}

class Georeferencing {
 public:
  Georeferencing(const GeoreferencingInput& input, const GeoreferencingOptions& options)
      : input_(input), options_(options) {
    result_.excluded.assign(input.control.size(), 0);
    result_.control.resize(input.control.size());
  }

  GeoreferencingResult Run() {
    if (!IsDetermined(MakeInput(input_, options_, result_.excluded))) return result_;
    if (!SearchBlunders()) {
      result_.status = Status::kContradictory;
      std::fill(result_.excluded.begin(), result_.excluded.end(), 0);
      Adjust();
    }
    if (result_.adjustment.status != ControlAdjustmentResult::Status::kAdjusted) {
      result_.status = Status::kDiverged;
      return result_;
    }
    if (result_.status != Status::kContradictory) result_.status = Status::kGeoreferenced;
    GrowCovariance();
    TestScale();
    SetResiduals();
    for (const SurveyedPoint& point : input_.check) {
      result_.check.push_back(Check(point, result_.adjustment, options_.sighting_sigma_m));
    }
    return result_;
  }

 private:
  /// Adjusts with the points in use; w of the others stays what it was.
  void Adjust() {
    result_.adjustment = AdjustToControl(MakeInput(input_, options_, result_.excluded));
    if (result_.adjustment.status != ControlAdjustmentResult::Status::kAdjusted) return;
    std::size_t next = 0;
    for (std::size_t k = 0; k < result_.excluded.size(); ++k) {
      if (result_.excluded[k] != 0) continue;
      const PointResidual& residual = result_.adjustment.residuals[next++];
      result_.control[k].w = residual.w;
      result_.control[k].checked = residual.checked;
    }
  }

  /// The point in use with the largest |w|, if that is beyond the limit; otherwise -1.
  int MostSuspicious() const {
    int worst = -1;
    double largest = options_.blunder_limit;
    for (std::size_t k = 0; k < result_.excluded.size(); ++k) {
      const double w = result_.control[k].w.cwiseAbs().maxCoeff();
      if (result_.excluded[k] != 0 || w <= largest) continue;
      largest = w;
      worst = static_cast<int>(k);
    }
    return worst;
  }

  /// False if points remain suspected that cannot be excluded.
  bool SearchBlunders() {
    std::size_t excluded = 0;
    while (true) {
      Adjust();
      if (result_.adjustment.status != ControlAdjustmentResult::Status::kAdjusted) return true;
      const int worst = MostSuspicious();
      if (worst < 0) return true;
      if (3 * ++excluded > input_.control.size()) return false;
      if (AnotherExplainsIt(worst)) return false;
      result_.excluded[static_cast<std::size_t>(worst)] = 1;
      const ControlAdjustmentInput rest = MakeInput(input_, options_, result_.excluded);
      // Three points cannot tell which of them is wrong once one is gone.
      if (rest.points.size() < 3 || !IsDetermined(rest)) return false;
    }
  }

  /// True if leaving out another suspicious point instead of `worst` would end all suspicion too:
  /// then nothing tells which of them is wrong (four heights over three unknowns, for one).
  bool AnotherExplainsIt(int worst) const {
    for (std::size_t k = 0; k < result_.excluded.size(); ++k) {
      const double w = result_.control[k].w.cwiseAbs().maxCoeff();
      if (static_cast<int>(k) == worst || result_.excluded[k] != 0 || w <= options_.blunder_limit) {
        continue;
      }
      std::vector<char> excluded = result_.excluded;
      excluded[k] = 1;
      const ControlAdjustmentInput rest = MakeInput(input_, options_, excluded);
      const ControlAdjustmentResult without = AdjustToControl(rest);
      if (without.status != ControlAdjustmentResult::Status::kAdjusted) continue;
      const bool calm = std::none_of(
          without.residuals.begin(), without.residuals.end(), [&](const PointResidual& residual) {
            return residual.w.cwiseAbs().maxCoeff() > options_.blunder_limit;
          });
      if (calm) return true;
    }
    return false;
  }

  void GrowCovariance() {
    ControlAdjustmentResult& adjustment = result_.adjustment;
    if (adjustment.redundancy < 1 || adjustment.chi2 <= ChiSquaredLimit(adjustment.redundancy)) {
      return;
    }
    result_.variance_factor = adjustment.chi2 / adjustment.redundancy;
    adjustment.covariance *= result_.variance_factor;
    adjustment.scale_covariance *= result_.variance_factor;
    adjustment.scale_sigma *= std::sqrt(result_.variance_factor);
  }

  void TestScale() {
    ControlAdjustmentInput used = MakeInput(input_, options_, result_.excluded);
    used.estimate_scale = true;
    const ControlAdjustmentResult scaled = AdjustToControl(used);
    if (scaled.status != ControlAdjustmentResult::Status::kAdjusted) return;
    result_.scale_test =
        ScaleTest{scaled.scale - 1.0, scaled.scale_sigma * std::sqrt(result_.variance_factor)};
  }

  void SetResiduals() {
    const ControlAdjustmentResult free =
        FitToControl(MakeInput(input_, options_, result_.excluded));
    if (free.status != ControlAdjustmentResult::Status::kAdjusted) {
      result_.status = GeoreferencingResult::Status::kDiverged;
      return;
    }
    for (std::size_t k = 0; k < input_.control.size(); ++k) {
      const SurveyedPoint& point = input_.control[k];
      result_.control[k].free_m = MeanResidual(point, free);
      result_.control[k].adjusted_m = MeanResidual(point, result_.adjustment);
      result_.control[k].sightings = static_cast<int>(point.sightings.size());
    }
  }

  const GeoreferencingInput& input_;
  const GeoreferencingOptions& options_;
  GeoreferencingResult result_;
};

}  // namespace

void VisitOptions(OptionVisitor& visitor, GeoreferencingOptions& options) {
  visitor.Real("sighting_sigma_m", options.sighting_sigma_m, "m", 1e-6, 1.0,
               "standard deviation of each coordinate of a target as a station measured it");
  visitor.Flag("estimate_scale", options.estimate_scale,
               "let control scale the network; otherwise scale is 1 and only tested");
  visitor.Real("blunder_limit", options.blunder_limit, "1", 2.0, 100.0,
               "standardised residual (Baarda's w) beyond which a control point is a blunder; "
               "3.29 errs once in 1000");
}

GeoreferencingResult Georeference(const GeoreferencingInput& input,
                                  const GeoreferencingOptions& options) {
  return Georeferencing(input, options).Run();
}

}  // namespace backsight
