#include "pipeline/georeference_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "graph/network_covariance.h"
#include "pipeline/control_frame.h"

namespace backsight {
namespace {

using Role = ControlPoint::Role;

bool HasRole(const ControlPoint& point, Role role) { return point.role == role; }

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
    SurveyedPoint point = MakeSurveyedPoint(project.control[k], frame);
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
