#include "stages/pair_bins.h"

#include <cmath>
#include <numbers>

namespace backsight {
namespace {

// Everything here is written without branches on data, for the compiler to vectorise.

/// Arc tangent of y / x in the right quadrant; 0 for (0, 0). Abramowitz and Stegun 4.4.49, absolute
/// error 1e-5.
inline float ArcTangent(float y, float x) {
  constexpr auto kPi = std::numbers::pi_v<float>;
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float low = ax < ay ? ax : ay;
  const float high = ax < ay ? ay : ax;
  constexpr float kTiny = 1e-30F;  // keeps 0 / 0 from happening
  const float t = low / (high > kTiny ? high : kTiny);
  const float t2 = t * t;
  const float series =
      t *
      (0.9998660F + t2 * (-0.3302995F + t2 * (0.1801410F + t2 * (-0.0851330F + t2 * 0.0208351F))));
  const float octant = ay > ax ? 0.5F * kPi - series : series;
  const float half = x < 0.0F ? kPi - octant : octant;
  return y < 0.0F ? -half : half;
}

/// `scaled` in [0, 11] to its bin; what rounding pushed out belongs to the outermost.
inline std::int32_t Bin(float scaled) {
  constexpr auto kLast = static_cast<float>(PairBins::kBins - 1);
  const float low = scaled > 0.0F ? scaled : 0.0F;
  return static_cast<std::int32_t>(low < kLast ? low : kLast);
}

}  // namespace

void ComputePairBins(const OrientedPoint& point, const OrientedBlock& others, std::size_t count,
                     PairBins* bins) {
  constexpr float kHalfBins = 0.5F * static_cast<float>(PairBins::kBins);
  constexpr float kBinsPerRadian = kHalfBins / std::numbers::pi_v<float>;
  const OrientedPoint p = point;
  for (std::size_t k = 0; k < count; ++k) {
    const float dx = others.x[k] - p.x;
    const float dy = others.y[k] - p.y;
    const float dz = others.z[k] - p.z;
    const float mx = others.nx[k];
    const float my = others.ny[k];
    const float mz = others.nz[k];
    const float squared = dx * dx + dy * dy + dz * dz;
    const float along_p = dx * p.nx + dy * p.ny + dz * p.nz;
    const float along_q = dx * mx + dy * my + dz * mz;
    const float cosine = p.nx * mx + p.ny * my + p.nz * mz;
    // d (n_p x n_q) is |d x u| v n_t for either choice of source, because both its factors and d
    // change sign together.
    const float triple =
        dx * (p.ny * mz - p.nz * my) + dy * (p.nz * mx - p.nx * mz) + dz * (p.nx * my - p.ny * mx);
    const bool swap = std::abs(along_p) < std::abs(along_q);
    const float source = swap ? -along_q : along_p;         // u d, d running from source to target
    const float target = swap ? -along_p : along_q;         // n_t d
    const float cross_squared = squared - source * source;  // |d x u|^2
    const bool valid = cross_squared > 0.0F;
    const float cross = std::sqrt(valid ? cross_squared : 1.0F);
    // w n_t = (n_t d - (u d)(u n_t)) / |d x u|; f1 does not change if both its sides are scaled.
    const float f1 = ArcTangent(target - source * cosine, cosine * cross);
    const float f2 = triple / cross;
    const float f3 = source / std::sqrt(valid ? squared : 1.0F);
    bins->f1[k] = valid ? Bin(f1 * kBinsPerRadian + kHalfBins) : PairBins::kNoBin;
    bins->f2[k] = valid ? Bin(f2 * kHalfBins + kHalfBins) : PairBins::kNoBin;
    bins->f3[k] = valid ? Bin(f3 * kHalfBins + kHalfBins) : PairBins::kNoBin;
  }
}

}  // namespace backsight
