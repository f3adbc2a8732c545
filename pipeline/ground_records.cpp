#include "pipeline/ground_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace backsight {
namespace {

std::string NameOf(GeoreferencingResult::Status status) {
  switch (status) {
    case GeoreferencingResult::Status::kGeoreferenced:
      return "georeferenced";
    case GeoreferencingResult::Status::kTooFewPoints:
      return "too_few_points";
    case GeoreferencingResult::Status::kContradictory:
      return "contradictory";
    case GeoreferencingResult::Status::kDiverged:
      return "diverged";
  }
  return {};
}

SurveyPointRecord ControlRecord(const SurveyProject& project, const GeoreferencedPart& part,
                                std::size_t place) {
  const GeoreferencingResult& result = part.result;
  SurveyPointRecord record;
  const ControlPoint& point = project.control[static_cast<std::size_t>(part.control[place])];
  record.id = point.id;
  record.position = point.crs_m;
  record.excluded = result.excluded[place] != 0;
  record.sightings = result.control[place].sightings;
  record.residual_m = result.control[place].adjusted_m;
  record.free_residual_m = result.control[place].free_m;
  record.w = result.control[place].w;
  record.checked = result.control[place].checked;
  return record;
}

SurveyPointRecord CheckPointRecord(const SurveyProject& project, const GeoreferencedPart& part,
                                   std::size_t place) {
  SurveyPointRecord record;
  const ControlPoint& point = project.control[static_cast<std::size_t>(part.check[place])];
  record.id = point.id;
  record.position = point.crs_m;
  record.check = true;
  record.sightings = part.result.check[place].sightings;
  record.residual_m = part.result.check[place].mean_m;
  record.sigma_m = part.result.check[place].sigma_m;
  return record;
}

CheckRecord Summarize(const std::vector<CheckResidual>& residuals) {
  CheckRecord check;
  if (residuals.empty()) return check;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double predicted = 0.0;
  for (const CheckResidual& residual : residuals) {
    squares += residual.mean_m.cwiseAbs2();
    predicted += residual.sigma_m.squaredNorm();
  }
  const auto n = static_cast<double>(residuals.size());
  check.points = static_cast<int>(residuals.size());
  check.rmse_m = (squares / n).cwiseSqrt();
  check.rmse_horizontal_m = check.rmse_m.head<2>().norm();
  check.rmse_3d_m = check.rmse_m.norm();
  check.predicted_3d_m = std::sqrt(predicted / n);
  return check;
}

}  // namespace

std::vector<GeoreferenceRecord> MakeGeoreferenceRecords(const SurveyProject& project,
                                                        const GeoreferencedNetwork& ground) {
  std::vector<GeoreferenceRecord> records;
  for (const GeoreferencedPart& part : ground.parts) {
    GeoreferenceRecord record;
    record.component = static_cast<int>(records.size());
    record.status = NameOf(part.result.status);
    record.crs = ground.frame ? ground.frame->name() : "local grid of the control";
    if (ground.frame) {
      record.heights = ground.frame->heights();
      record.origin_deg_deg_m = ground.frame->origin();
      record.origin_crs_m = ground.frame->CrsFromEnu(Eigen::Vector3d::Zero());
      record.convergence_deg = ground.frame->convergence_deg();
      record.point_scale = ground.frame->point_scale();
    }
    if (part.placed()) {
      const ControlAdjustmentResult& adjustment = part.result.adjustment;
      record.enu_from_survey = adjustment.enu_from_survey;
      record.scale = adjustment.scale;
      if (const std::optional<ScaleTest>& test = part.result.scale_test) {
        record.scale_test = ScaleRecord{1e6 * test->minus_one, 1e6 * test->sigma};
      }
      record.redundancy = adjustment.redundancy;
      record.variance_factor = part.result.variance_factor;
      for (std::size_t k = 0; k < part.control.size(); ++k) {
        record.points.push_back(ControlRecord(project, part, k));
      }
      for (std::size_t k = 0; k < part.check.size(); ++k) {
        record.points.push_back(CheckPointRecord(project, part, k));
      }
      record.check = Summarize(part.result.check);
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::optional<GroundPose> MakeGroundPose(const GeoreferencedNetwork& ground, std::size_t station) {
  if (station >= ground.enu_from_station.size() || !ground.enu_from_station[station]) return {};
  GroundPose pose;
  pose.enu_from_station = *ground.enu_from_station[station];
  pose.covariance = ground.covariance[station];
  pose.position = ground.OutputFromEnu(pose.enu_from_station.translation);
  return pose;
}

namespace {

/// How the tie of one component ended, where that is not well.
std::string StatusWarning(const GeoreferenceRecord& record) {
  const std::string component = fmt::format("component {}", ComponentNumber(record.component));
  if (record.status == "too_few_points") {
    return component + " has too few control points and stays in its survey frame";
  }
  if (record.status == "diverged")
    return component +
           ": the adjustment to control failed: network and control are of different shape; check "
           "units, ids and stations of the sightings";
  if (record.status == "contradictory") {
    return fmt::format(
        "{}: the control points contradict each other or the network (variance factor {:.1f}), and "
        "it cannot be told which are wrong; all are used",
        component, record.variance_factor);
  }
  if (record.variance_factor > 1.0) {
    return fmt::format(
        "{}: control and network disagree beyond their sigmas without a single blunder; "
        "covariances were multiplied by {:.1f}",
        component, record.variance_factor);
  }
  return {};
}

/// Coordinates of control that no redundancy tests: an error in them would not show.
std::string UncheckedWarning(const GeoreferenceRecord& record) {
  constexpr const char* kAxes[] = {"easting", "northing", "height"};
  std::string list;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::string ids;
    for (const SurveyPointRecord& point : record.points) {
      if (point.check || point.excluded || point.checked[axis]) continue;
      ids += (ids.empty() ? "" : ", ") + point.id;
    }
    if (!ids.empty()) list += fmt::format("{}{} of {}", list.empty() ? "" : "; ", kAxes[axis], ids);
  }
  return list.empty() ? "" : "nothing else checks these coordinates of control: " + list;
}

/// Survey points of the project that no station of any component measured.
std::string UnusedWarning(const SurveyProject& project, const GeoreferencedNetwork& ground) {
  std::string ids;
  for (std::size_t k = 0; k < project.control.size(); ++k) {
    const auto holds = [&](const std::vector<int>& points) {
      return std::find(points.begin(), points.end(), static_cast<int>(k)) != points.end();
    };
    const bool seen = std::any_of(
        ground.parts.begin(), ground.parts.end(),
        [&](const GeoreferencedPart& part) { return holds(part.control) || holds(part.check); });
    if (!seen) ids += (ids.empty() ? "" : ", ") + project.control[k].id;
  }
  return ids.empty() ? "" : "survey points measured only from stations that are not placed: " + ids;
}

std::string ScaleWarning(const GeoreferenceRecord& record) {
  if (!record.placed()) return {};
  if (!record.scale_test) {
    return fmt::format(
        "component {}: the network's scale could not be tested, because an adjustment with scale "
        "did not converge",
        ComponentNumber(record.component));
  }
  constexpr double kNoticeable = 50.0;  // ppm
  const auto [off_ppm, sigma_ppm] = *record.scale_test;
  if (std::abs(off_ppm) <= std::max(kNoticeable, 3.0 * sigma_ppm)) return {};
  return fmt::format(
      "control says that the network's scale is off by {:.0f} ppm (sigma {:.0f}): check units, "
      "zone, and whether grid distances were taken for ground distances",
      off_ppm, sigma_ppm);
}

}  // namespace

std::vector<std::string> SightingWarnings(const SurveyProject& project,
                                          const std::vector<Station>& stations) {
  std::vector<std::string> warnings;
  for (const ControlPoint& point : project.control) {
    for (const ControlMeasurement& measured : point.measured) {
      const auto station = std::find_if(stations.begin(), stations.end(), [&](const Station& s) {
        return s.spec.id == measured.station;
      });
      if (station == stations.end() || !station->usable()) continue;
      const Eigen::Vector3d scanner =
          station->spec.scanner_origin_m.value_or(Eigen::Vector3d::Zero());
      const double distance_m = (measured.xyz_m - scanner).norm();
      constexpr double kFar = 5.0;
      if (distance_m <= kFar * station->record.extent_m) continue;
      warnings.push_back(fmt::format(
          "{} was measured {:.1f} m from station {}, whose scan reaches {:.1f} m for 95 % of its "
          "points: are these metres, and this station's coordinates?",
          point.id, distance_m, measured.station, station->record.extent_m));
    }
  }
  return warnings;
}

std::vector<std::string> GroundWarnings(const SurveyProject& project,
                                        const GeoreferencedNetwork& ground,
                                        const std::vector<GeoreferenceRecord>& records) {
  std::vector<std::string> warnings;
  const auto add = [&](std::string warning) {
    if (!warning.empty()) warnings.push_back(std::move(warning));
  };
  for (const GeoreferenceRecord& record : records) {
    add(StatusWarning(record));
    for (const SurveyPointRecord& point : record.points) {
      if (!point.excluded) continue;
      add(fmt::format(
          "control point {} is off by ({:.1f}, {:.1f}, {:.1f}) mm, a blunder (w = {:.1f}); it was "
          "excluded",
          point.id, 1000.0 * point.residual_m.x(), 1000.0 * point.residual_m.y(),
          1000.0 * point.residual_m.z(), point.w->cwiseAbs().maxCoeff()));
    }
    add(UncheckedWarning(record));
    add(ScaleWarning(record));
  }
  if (!records.empty()) add(UnusedWarning(project, ground));
  return warnings;
}

}  // namespace backsight
