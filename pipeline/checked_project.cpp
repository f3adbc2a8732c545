#include "pipeline/checked_project.h"

#include <fmt/format.h>

#include <vector>

#include "pipeline/control_frame.h"

namespace backsight {
namespace {

const StationSpec* FindStation(const SurveyProject& project, const std::string& id) {
  for (const StationSpec& station : project.stations) {
    if (station.id == id) return &station;
  }
  return nullptr;
}

std::vector<ProjectFault> FindFarSightings(const SurveyProject& project, const WholeParts& whole,
                                           double max_range_m) {
  std::vector<ProjectFault> faults;
  for (std::size_t k = 0; k < project.control.size(); ++k) {
    const ControlPoint& point = project.control[k];
    for (std::size_t m = 0; m < point.measured.size(); ++m) {
      const ControlMeasurement& measured = point.measured[m];
      const StationSpec* const station = FindStation(project, measured.station);
      if (station == nullptr || (!whole.stations && station->scanner_origin_m)) continue;
      const Eigen::Vector3d scanner = station->scanner_origin_m.value_or(Eigen::Vector3d::Zero());
      const double distance_m = (measured.xyz_m - scanner).norm();
      if (distance_m <= max_range_m) continue;
      faults.push_back(
          {ProjectFault::Place::kSighting, k, m,
           fmt::format("{} at {:.1f} m from station {}", point.id, distance_m, measured.station),
           fmt::format(
               "a target within registration.max_range_m, {:g} m of the scanner, in the scan's "
               "own coordinates",
               max_range_m),
           "are these metres, and this station's coordinates?"});
    }
  }
  return faults;
}

}  // namespace

SurveyProject ReadCheckedProject(const std::string& path, SurveyOptions* options) {
  return ReadSurveyProject(
      path, OptionSections(*options), [&](const SurveyProject& project, const WholeParts& whole) {
        std::vector<ProjectFault> faults = FindControlFaults(project, whole);
        if (!whole.control) return faults;
        for (ProjectFault& fault : FindFarSightings(project, whole, options->ingest.max_range_m)) {
          faults.push_back(std::move(fault));
        }
        return faults;
      });
}

}  // namespace backsight
