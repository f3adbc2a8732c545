#include "stages/station_priors.h"

#include <cmath>
#include <numbers>

namespace backsight {
namespace {

constexpr double kSigmas = 5.0;

}  // namespace

bool ArePriorsTooFar(const StationPrior& a, const StationPrior& b, double useful_range_m) {
  const double distance_m =
      (a.survey_from_station.translation - b.survey_from_station.translation).norm();
  return distance_m > 1.5 * useful_range_m + kSigmas * std::hypot(a.sigma_m, b.sigma_m);
}

bool ContradictsPriors(const StationPrior& source, const StationPrior& target,
                       const RigidTransform& target_from_source, double resolution_m) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  const RigidTransform expected = source.survey_from_station;
  const RigidTransform found = target.survey_from_station * target_from_source;
  const double sigma_rad = kRadians * std::hypot(source.sigma_deg, target.sigma_deg);
  if (RotationAngle(found.rotation, expected.rotation) > kSigmas * sigma_rad) return true;
  const double lever_m = target_from_source.translation.norm() * kRadians * target.sigma_deg;
  const double sigma_m = std::hypot(source.sigma_m, target.sigma_m, lever_m);
  return (found.translation - expected.translation).norm() > kSigmas * sigma_m + resolution_m;
}

}  // namespace backsight
