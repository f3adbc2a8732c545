#include "pipeline/georeference_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "graph/network_covariance.h"

namespace backsight {
namespace {

using Role = ControlPoint::Role;

bool HasRole(const ControlPoint& point, Role role) { return point.role == role; }

Eigen::Vector3d EnuOf(const ControlPoint& point, const GeodeticFrame* frame) {
  return frame == nullptr ? point.crs_m : frame->EnuFromCrs(point.crs_m);
}

SurveyedPoint MakePoint(const ControlPoint& point, const GeodeticFrame* frame) {
  SurveyedPoint made;
  made.enu_m = EnuOf(point, frame);
  if (frame != nullptr) made.axes = frame->AxesAt(point.crs_m);
  made.sigma_m = point.sigma_m;
  return made;
}

std::vector<TiltObservation> LevelledStations(const std::vector<StationSpec>& stations) {
  std::vector<TiltObservation> tilts;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (!stations[s].levelled) continue;
    tilts.push_back({static_cast<int>(s), stations[s].level_sigma_deg * std::numbers::pi / 180.0});
  }
  return tilts;
}

/// By component, of the points with role control and in whole metres: a slip of the pen in one of
/// them does not move it far.
Eigen::Vector3d MedianOfControl(const std::vector<ControlPoint>& control) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ControlPoint& point : control) {
      if (HasRole(point, Role::kControl)) values.push_back(point.crs_m[axis]);
    }
    if (values.empty()) return control.front().crs_m;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = std::round(*middle);
  }
  return median;
}

/// Now, because after the registration it would cost the night.
void RequireConvertible(const SurveyProject& project, const ControlPoint& point,
                        const GeodeticFrame* frame) {
  if (frame == nullptr) return;
  const std::string where = fmt::format("{}: control: {}", project.path, point.id);
  Eigen::Vector3d back;
  try {
    back = frame->CrsFromEnu(MakePoint(point, frame).enu_m);
  } catch (const InputError& error) {
    InputError::Details details = error.details();
    details.where = where;
    throw InputError(details);
  }
  constexpr double kSame = 1e-3;  // far outside its zone a projection may know no way back
  if ((back - point.crs_m).norm() <= kSame) return;
  throw InputError(
      {where,
       fmt::format("({:.3f}, {:.3f}, {:.3f})", point.crs_m.x(), point.crs_m.y(), point.crs_m.z()),
       "a place where " + frame->name() + " is defined",
       "check the order (easting, northing, height), units and zone"});
}

void RequireEnoughControl(const SurveyProject& project, const GeodeticFrame* frame) {
  ControlAdjustmentInput input;
  input.tilts = LevelledStations(project.stations);
  for (const ControlPoint& point : project.control) {
    if (HasRole(point, Role::kControl)) input.points.push_back(MakePoint(point, frame));
  }
  if (IsDetermined(input)) return;
  throw InputError(
      {project.path,
       fmt::format("control: {} points with role control{}{}", input.points.size(),
                   input.points.size() >= 3 ? ", all on one line" : "",
                   input.tilts.empty() ? ", no levelled station" : ""),
       "three that are not on one line, or two that are not above one another and a station with "
       "levelled: true",
       "measure more control, or remove crs and control to register without"});
}

/// The joint covariance of a component's station frames, in the order of `part.stations`.
Eigen::MatrixXd JointCovarianceOf(const NetworkPart& part, const std::vector<Station>& stations,
                                  const Network& network) {
  const auto rows = static_cast<Eigen::Index>(6 * part.stations.size());
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(rows, rows);
  if (part.refinement.covariance.rows() != rows) {
    // Without refinement only each station's own is known.
    for (std::size_t i = 1; i < part.stations.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(6 * i);
      joint.block<6, 6>(row, row) = network.covariance[static_cast<std::size_t>(part.stations[i])];
    }
    return joint;
  }
  const auto datum = static_cast<std::size_t>(part.stations.front());
  return InFrame(stations[datum].model.StationFromInstrument(), part.refinement.covariance);
}

/// The sightings of a point from the stations of a component, by place in it.
std::vector<Sighting> SightingsIn(const NetworkPart& part, const std::vector<Station>& stations,
                                  const ControlPoint& point) {
  std::vector<Sighting> sightings;
  for (const ControlMeasurement& measured : point.measured) {
    for (std::size_t i = 0; i < part.stations.size(); ++i) {
      const Station& station = stations[static_cast<std::size_t>(part.stations[i])];
      if (station.spec.id != measured.station) continue;
      sightings.push_back({static_cast<int>(i), measured.xyz_m});
    }
  }
  return sightings;
}

GeoreferencedPart GeoreferencePart(const SurveyProject& project, const GeodeticFrame* frame,
                                   const std::vector<Station>& stations, const Network& network,
                                   const NetworkPart& part, const GeoreferencingOptions& options) {
  GeoreferencedPart made;
  GeoreferencingInput input;
  std::vector<StationSpec> specs;
  for (const int station : part.stations) {
    const auto s = static_cast<std::size_t>(station);
    input.survey_from_station.push_back(network.survey_from_station[s]);
    specs.push_back(stations[s].spec);
  }
  input.covariance = JointCovarianceOf(part, stations, network);
  input.tilts = LevelledStations(specs);
  for (std::size_t k = 0; k < project.control.size(); ++k) {
    SurveyedPoint point = MakePoint(project.control[k], frame);
    point.sightings = SightingsIn(part, stations, project.control[k]);
    if (point.sightings.empty()) continue;
    const bool control = HasRole(project.control[k], Role::kControl);
    (control ? input.control : input.check).push_back(std::move(point));
    (control ? made.control : made.check).push_back(static_cast<int>(k));
  }
  made.result = Georeference(input, options);
  return made;
}

}  // namespace

double GeoreferencedNetwork::ScaleOf(int component) const {
  const auto c = static_cast<std::size_t>(component);
  return c < parts.size() && parts[c].placed() ? parts[c].result.adjustment.scale : 1.0;
}

Eigen::Vector3d GeoreferencedNetwork::OutputFromEnu(const Eigen::Vector3d& enu) const {
  return frame ? frame->CrsFromEnu(enu) : enu;
}

std::shared_ptr<const GeodeticFrame> MakeControlFrame(const SurveyProject& project) {
  if (!project.crs && project.control.empty()) return nullptr;
  if (project.control.empty()) {
    throw InputError({project.path, "crs without control",
                      "control points that tie the network to it",
                      "give control, or remove crs to register without"});
  }
  std::shared_ptr<GeodeticFrame> frame;
  if (project.crs) {
    frame = std::make_shared<GeodeticFrame>(project.crs->horizontal, project.crs->vertical,
                                            project.path + ": crs");
    frame->SetOrigin(MedianOfControl(project.control));
  }
  for (const ControlPoint& point : project.control) RequireConvertible(project, point, frame.get());
  RequireEnoughControl(project, frame.get());
  return frame;
}

GeoreferencedNetwork GeoreferenceNetwork(const SurveyProject& project,
                                         std::shared_ptr<const GeodeticFrame> frame,
                                         const std::vector<Station>& stations,
                                         const Network& network,
                                         const GeoreferencingOptions& options) {
  GeoreferencedNetwork made;
  made.enu_from_station.resize(stations.size());
  made.covariance.assign(stations.size(), Matrix6d::Zero());
  if (project.control.empty()) return made;
  made.frame = std::move(frame);
  for (const NetworkPart& part : network.parts) {
    made.parts.push_back(
        GeoreferencePart(project, made.frame.get(), stations, network, part, options));
    const GeoreferencedPart& placed = made.parts.back();
    for (std::size_t i = 0; placed.placed() && i < part.stations.size(); ++i) {
      const auto s = static_cast<std::size_t>(part.stations[i]);
      const auto row = static_cast<Eigen::Index>(6 * i);
      made.enu_from_station[s] = placed.result.adjustment.enu_from_station[i];
      made.covariance[s] = placed.result.adjustment.covariance.block<6, 6>(row, row);
    }
  }
  return made;
}

}  // namespace backsight
