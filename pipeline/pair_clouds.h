#pragma once

#include <optional>

#include "pipeline/station_pipeline.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"

namespace backsight {

/// Both stations of a pair as the stages want them, and how well motions lay their clouds on each
/// other. Refers to the stations, which must outlive it.
struct PairClouds {
  PairClouds(const Station& s, const Station& t);

  /// Agreement less eight times the conflict, mean of both directions: a motion under which one
  /// block in eight is seen through is worthless however much of it agrees. `lenience`: how many
  /// of its standard deviations the conflict is taken lower, on samples too small to be sure.
  /// Clouds that do not meet have -10.
  double Score(const CloudSample& of_source, const CloudSample& of_target, double lenience,
               const RigidTransform& target_from_source) const;

  /// No less than Score, which conflicts only lower.
  double ScoreBound(const CloudSample& of_source, const CloudSample& of_target,
                    const RigidTransform& target_from_source) const;

  Surface source;
  Surface target;
  const CloudIndex& source_index;
  const CloudIndex& target_index;
  const PreparedStation& source_prepared;
  const PreparedStation& target_prepared;
  /// Standard deviation of both levellings together; none unless both stations are levelled.
  std::optional<double> level_sigma_rad;
};

}  // namespace backsight
