#include "pipeline/control_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

using Place = ProjectFault::Place;

bool IsControl(const ControlPoint& point) { return point.role == ControlPoint::Role::kControl; }

/// By component, of the points with role control and in whole metres: a slip of the pen in one of
/// them does not move it far.
Eigen::Vector3d MedianOfControl(const std::vector<ControlPoint>& control) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ControlPoint& point : control) {
      if (IsControl(point)) values.push_back(point.crs_m[axis]);
    }
    if (values.empty()) return control.front().crs_m;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = std::round(*middle);
  }
  return median;
}

ProjectFault FaultAt(Place place, const InputError::Details& details) {
  return {place, 0, 0, details.found, details.expected, details.remedy};
}

/// After the registration it would cost the night.
std::vector<ProjectFault> PlaceFaults(const SurveyProject& project, const GeodeticFrame& frame) {
  std::vector<ProjectFault> faults;
  for (std::size_t k = 0; k < project.control.size(); ++k) {
    const std::optional<InputError::Details> fault = frame.FaultOf(project.control[k].crs_m);
    if (!fault) continue;
    faults.push_back(FaultAt(Place::kPoint, *fault));
    faults.back().point = k;
    faults.back().found = project.control[k].id + ": " + fault->found;
  }
  return faults;
}

/// Heights may need a grid that does not reach there.
std::vector<ProjectFault> HeightFaults(const SurveyProject& project, GeodeticFrame* frame) {
  std::vector<ProjectFault> faults;
  for (std::size_t k = 0; k < project.control.size(); ++k) {
    try {
      if (k == 0) frame->SetOrigin(MedianOfControl(project.control));
      frame->CrsFromEnu(MakeSurveyedPoint(project.control[k], frame).enu_m);
    } catch (const InputError& error) {
      faults.push_back(FaultAt(Place::kPoint, error.details()));
      faults.back().point = k;
      faults.back().found = project.control[k].id + ": " + error.details().found;
      if (k == 0) break;
    }
  }
  return faults;
}

std::vector<ProjectFault> CountFaults(const SurveyProject& project, const GeodeticFrame* frame) {
  ControlAdjustmentInput input;
  input.tilts = LevelledStations(project.stations);
  for (const ControlPoint& point : project.control) {
    if (IsControl(point)) input.points.push_back(MakeSurveyedPoint(point, frame));
  }
  if (IsDetermined(input)) return {};
  const std::size_t count = input.points.size();
  return {{Place::kControl, 0, 0,
           fmt::format("{} point{} with role control{}{}", count, count == 1 ? "" : "s",
                       count >= 3 ? ", all on one line" : "",
                       input.tilts.empty() ? ", no levelled station" : ""),
           "three that are not on one line, or two that are not above one another and a station "
           "with levelled: true",
           "measure more control, or remove crs and control to register without"}};
}

struct CheckedControl {
  std::shared_ptr<GeodeticFrame> frame;
  std::vector<ProjectFault> faults;
};

CheckedControl CheckControl(const SurveyProject& project, const WholeParts& whole) {
  CheckedControl made;
  if (project.crs && whole.crs) {
    try {
      made.frame =
          std::make_shared<GeodeticFrame>(project.crs->horizontal, project.crs->vertical, "");
    } catch (const InputError& error) {
      made.faults.push_back(FaultAt(Place::kCrs, error.details()));
    }
  }
  if (!whole.control) return made;
  if (project.control.empty()) {
    if (!project.crs) return made;
    made.faults.push_back({Place::kCrs, 0, 0, "crs without control",
                           "control points that tie the network to it",
                           "give control, or remove crs to register without"});
    return made;
  }
  const auto add = [&](std::vector<ProjectFault> faults) {
    made.faults.insert(made.faults.end(), faults.begin(), faults.end());
    return faults.empty();
  };
  const bool placed = !made.frame || (add(PlaceFaults(project, *made.frame)) &&
                                      add(HeightFaults(project, made.frame.get())));
  // Points that stand nowhere say nothing of a line, but their number counts.
  // Two points may do, which depends on the stations.
  const auto points = std::count_if(project.control.begin(), project.control.end(), IsControl);
  if (whole.stations || points < 2) add(CountFaults(project, placed ? made.frame.get() : nullptr));
  return made;
}

}  // namespace

SurveyedPoint MakeSurveyedPoint(const ControlPoint& point, const GeodeticFrame* frame) {
  SurveyedPoint made;
  made.enu_m = frame == nullptr ? point.crs_m : frame->EnuFromCrs(point.crs_m);
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

std::shared_ptr<const GeodeticFrame> MakeControlFrame(const SurveyProject& project) {
  CheckedControl made = CheckControl(project, {true, true, true});
  if (made.faults.empty()) return made.frame;
  const ProjectFault& fault = made.faults.front();
  throw InputError({project.path, fault.found, fault.expected, fault.remedy});
}

std::vector<ProjectFault> FindControlFaults(const SurveyProject& project, const WholeParts& whole) {
  return CheckControl(project, whole).faults;
}

}  // namespace backsight
