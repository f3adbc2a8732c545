#include "pipeline/pair_clouds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace backsight {
namespace {

std::optional<double> LevelSigma(const StationSpec& a, const StationSpec& b) {
  if (!a.levelled || !b.levelled) return std::nullopt;
  return std::hypot(a.level_sigma_deg, b.level_sigma_deg) * std::numbers::pi / 180.0;
}

// Clouds that do not meet cannot contradict each other either: worse than any rough fit.
constexpr double kLeastAgreement = 0.02;
constexpr double kNowhere = -10.0;

}  // namespace

PairClouds::PairClouds(const Station& s, const Station& t)
    : source(s.surface()),
      target(t.surface()),
      source_index(*s.index),
      target_index(*t.index),
      source_prepared(s.prepared),
      target_prepared(t.prepared),
      level_sigma_rad(LevelSigma(s.spec, t.spec)) {}

double PairClouds::Score(const CloudSample& of_source, const CloudSample& of_target,
                         double lenience, const RigidTransform& target_from_source) const {
  constexpr double kConflictWeight = 8.0;
  const double tolerance_m = 2.0 * target.model.resolution_m();
  const CloudAgreement there =
      CompareClouds(source, of_source, target, target_index, target_from_source, tolerance_m);
  const CloudAgreement back = CompareClouds(target, of_target, source, source_index,
                                            target_from_source.Inverse(), tolerance_m);
  const double fit = there.score + back.score;
  if (fit < 2.0 * kLeastAgreement) return kNowhere;
  const auto conflict = [&](const RatioEstimate& c) {
    return std::max(0.0, c.value - lenience * c.sigma);
  };
  return 0.5 * (fit - kConflictWeight * (conflict(there.conflict) + conflict(back.conflict)));
}

double PairClouds::ScoreBound(const CloudSample& of_source, const CloudSample& of_target,
                              const RigidTransform& target_from_source) const {
  const double tolerance_m = 2.0 * target.model.resolution_m();
  const double fit =
      ScoreClouds(source, of_source, target, target_index, target_from_source, tolerance_m) +
      ScoreClouds(target, of_target, source, source_index, target_from_source.Inverse(),
                  tolerance_m);
  return fit < 2.0 * kLeastAgreement ? kNowhere : 0.5 * fit;
}

}  // namespace backsight
