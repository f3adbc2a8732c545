#pragma once

#include "stages/simulation/ray_caster.h"

namespace backsight {

/// What the receiver makes of one beam.
struct Echo {
  double range_m = 0.0;  ///< along the beam's axis; 0: nothing
  double cos_incidence = 0.0;
  /// Sum over the footprint of weight * reflectance * cos(incidence) / range^2, 1/m^2.
  double signal = 0.0;
  MaterialId material = 0;  ///< of the strongest part
};

/// Blends the hits of a beam's sub-rays, the first of which is the axis, to one echo. Hits whose
/// ranges follow each other closer than `mixing_m` form one echo with their energy-weighted mean
/// range; the echo with the most energy wins. Hits in one plane give that plane's exact range.
Echo BlendEchoes(const RayBundle& rays, const RayHits& hits, const RayCaster& caster,
                 double mixing_m);

}  // namespace backsight
