#include "stages/neighborhood_moments.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/neighborhood_moments.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Candidate j is summed in lane j mod kLanes, however many lanes a vector has.
constexpr std::size_t kLanes = 8;
constexpr std::size_t kSums = 9;  // x y z xx xy xz yy yz zz

using DoubleTag = hn::CappedTag<double, kLanes>;
using FloatTag = hn::Rebind<float, DoubleTag>;
using Doubles = hn::Vec<DoubleTag>;
using Floats = hn::Vec<FloatTag>;

struct alignas(64) LaneSums {
  double lanes[kSums][kLanes];
};

/// As float, because a reference in float decides who is a neighbour.
HWY_INLINE Floats SquaredDistances(Floats x, Floats y, Floats z, const Coordinates& center) {
  const FloatTag df;
  const Floats dx = hn::Sub(x, hn::Set(df, center.x));
  const Floats dy = hn::Sub(y, hn::Set(df, center.y));
  const Floats dz = hn::Sub(z, hn::Set(df, center.z));
  return hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
}

/// Sums the lanes of vectors that begin at lane `begin`. Returns the number of neighbours.
HWY_INLINE std::size_t SumLanes(const CandidateColumns& candidates, const Coordinates& center,
                                float squared_radius, std::size_t begin, LaneSums* sums) {
  const DoubleTag dd;
  const FloatTag df;
  const Doubles x0 = hn::Set(dd, static_cast<double>(center.x));
  const Doubles y0 = hn::Set(dd, static_cast<double>(center.y));
  const Doubles z0 = hn::Set(dd, static_cast<double>(center.z));
  const Doubles radius = hn::Set(dd, static_cast<double>(squared_radius));
  Doubles sx = hn::Zero(dd), sy = sx, sz = sx;
  Doubles sxx = sx, sxy = sx, sxz = sx, syy = sx, syz = sx, szz = sx;
  std::size_t count = 0;
  for (std::size_t j = begin; j < candidates.count; j += kLanes) {
    const Floats xf = hn::LoadU(df, candidates.x + j);
    const Floats yf = hn::LoadU(df, candidates.y + j);
    const Floats zf = hn::LoadU(df, candidates.z + j);
    const auto near = hn::Lt(hn::PromoteTo(dd, SquaredDistances(xf, yf, zf, center)), radius);
    if (hn::AllFalse(dd, near)) continue;
    count += hn::CountTrue(dd, near);
    const Doubles x = hn::IfThenElseZero(near, hn::Sub(hn::PromoteTo(dd, xf), x0));
    const Doubles y = hn::IfThenElseZero(near, hn::Sub(hn::PromoteTo(dd, yf), y0));
    const Doubles z = hn::IfThenElseZero(near, hn::Sub(hn::PromoteTo(dd, zf), z0));
    sx = hn::Add(sx, x);
    sy = hn::Add(sy, y);
    sz = hn::Add(sz, z);
    sxx = hn::Add(sxx, hn::Mul(x, x));
    sxy = hn::Add(sxy, hn::Mul(x, y));
    sxz = hn::Add(sxz, hn::Mul(x, z));
    syy = hn::Add(syy, hn::Mul(y, y));
    syz = hn::Add(syz, hn::Mul(y, z));
    szz = hn::Add(szz, hn::Mul(z, z));
  }
  const Doubles all[kSums] = {sx, sy, sz, sxx, sxy, sxz, syy, syz, szz};
  for (std::size_t k = 0; k < kSums; ++k) hn::Store(all[k], dd, &sums->lanes[k][begin]);
  return count;
}

NeighborhoodMoments SumAll(const CandidateColumns& candidates, const Coordinates& center,
                           float squared_radius) {
  LaneSums sums;
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < kLanes; begin += hn::Lanes(DoubleTag())) {
    count += SumLanes(candidates, center, squared_radius, begin, &sums);
  }
  double total[kSums];
  for (std::size_t k = 0; k < kSums; ++k) {
    const double* s = sums.lanes[k];
    total[k] = ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }
  return {total[0], total[1], total[2], total[3], total[4],
          total[5], total[6], total[7], total[8], static_cast<std::uint32_t>(count)};
}

float NearestGreater(const CandidateColumns& candidates, const double* values,
                     const Coordinates& center, double value) {
  const DoubleTag dd;
  const FloatTag df;
  const Doubles bound = hn::Set(dd, value);
  Doubles nearest = hn::Set(dd, static_cast<double>(std::numeric_limits<float>::max()));
  for (std::size_t j = 0; j < candidates.count; j += hn::Lanes(dd)) {
    const auto greater = hn::Gt(hn::LoadU(dd, values + j), bound);
    if (hn::AllFalse(dd, greater)) continue;
    const Floats squared =
        SquaredDistances(hn::LoadU(df, candidates.x + j), hn::LoadU(df, candidates.y + j),
                         hn::LoadU(df, candidates.z + j), center);
    nearest = hn::Min(nearest, hn::IfThenElse(greater, hn::PromoteTo(dd, squared), nearest));
  }
  return static_cast<float>(hn::GetLane(hn::MinOfLanes(dd, nearest)));
}

}  // namespace
}  // namespace backsight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(SumAll);
HWY_EXPORT(NearestGreater);

NeighborhoodMoments SumMoments(const CandidateColumns& candidates, const Coordinates& center,
                               float squared_radius) {
  return HWY_DYNAMIC_DISPATCH(SumAll)(candidates, center, squared_radius);
}

float SquaredDistanceToGreater(const CandidateColumns& candidates, const double* values,
                               const Coordinates& center, double value) {
  return HWY_DYNAMIC_DISPATCH(NearestGreater)(candidates, values, center, value);
}

}  // namespace backsight
#endif
