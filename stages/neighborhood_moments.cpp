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

/// How many candidates are looked at before the neighbours among them are summed.
constexpr std::size_t kBatch = 1024;
/// The j-th neighbour of a batch is summed in lane j mod kLanes, however many lanes a vector has.
constexpr std::size_t kLanes = 8;
constexpr std::size_t kSums = 9;  // x y z xx xy xz yy yz zz

/// Distances are compared many at a time.
constexpr std::size_t kMostFloats = 16;
using WideTag = hn::CappedTag<float, kMostFloats>;

using DoubleTag = hn::CappedTag<double, kLanes>;
using FloatTag = hn::Rebind<float, DoubleTag>;
using Doubles = hn::Vec<DoubleTag>;

/// Neighbours; behind them is room for a vector.
struct alignas(64) Neighbors {
  float x[kBatch + kMostFloats], y[kBatch + kMostFloats], z[kBatch + kMostFloats];
};

struct alignas(64) LaneSums {
  double lanes[kSums][kLanes] = {};
};

/// As float, because a reference in float decides who is a neighbour.
template <class Tag>
HWY_INLINE hn::Vec<Tag> SquaredDistances(Tag d, hn::Vec<Tag> x, hn::Vec<Tag> y, hn::Vec<Tag> z,
                                         const Coordinates& center) {
  const auto dx = hn::Sub(x, hn::Set(d, center.x));
  const auto dy = hn::Sub(y, hn::Set(d, center.y));
  const auto dz = hn::Sub(z, hn::Set(d, center.z));
  return hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
}

/// Gathers without a branch, of which every other would be mispredicted. Returns their number;
/// behind them stand points that are in one place with the centre.
HWY_INLINE std::size_t GatherNeighbors(const CandidateColumns& candidates, std::size_t begin,
                                       std::size_t end, const Coordinates& center,
                                       float squared_radius, Neighbors* neighbors) {
  const WideTag d;
  const auto radius = hn::Set(d, squared_radius);
  std::size_t count = 0;
  for (std::size_t j = begin; j < end; j += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, candidates.x + j);
    const auto y = hn::LoadU(d, candidates.y + j);
    const auto z = hn::LoadU(d, candidates.z + j);
    const auto near = hn::Lt(SquaredDistances(d, x, y, z, center), radius);
    hn::StoreU(hn::Compress(x, near), d, neighbors->x + count);
    hn::StoreU(hn::Compress(y, near), d, neighbors->y + count);
    hn::StoreU(hn::Compress(z, near), d, neighbors->z + count);
    count += hn::CountTrue(d, near);
  }
  for (std::size_t j = count; j < count + kLanes; j += hn::Lanes(d)) {
    hn::StoreU(hn::Set(d, center.x), d, neighbors->x + j);
    hn::StoreU(hn::Set(d, center.y), d, neighbors->y + j);
    hn::StoreU(hn::Set(d, center.z), d, neighbors->z + j);
  }
  return count;
}

/// Adds to the lanes of vectors that begin at lane `begin`.
HWY_INLINE void AddToLanes(const Neighbors& neighbors, std::size_t count, const Coordinates& center,
                           std::size_t begin, LaneSums* sums) {
  const DoubleTag dd;
  const FloatTag df;
  const Doubles x0 = hn::Set(dd, static_cast<double>(center.x));
  const Doubles y0 = hn::Set(dd, static_cast<double>(center.y));
  const Doubles z0 = hn::Set(dd, static_cast<double>(center.z));
  Doubles s[kSums];
  for (std::size_t k = 0; k < kSums; ++k) s[k] = hn::Load(dd, &sums->lanes[k][begin]);
  for (std::size_t j = begin; j < count; j += kLanes) {
    const Doubles x = hn::Sub(hn::PromoteTo(dd, hn::LoadU(df, neighbors.x + j)), x0);
    const Doubles y = hn::Sub(hn::PromoteTo(dd, hn::LoadU(df, neighbors.y + j)), y0);
    const Doubles z = hn::Sub(hn::PromoteTo(dd, hn::LoadU(df, neighbors.z + j)), z0);
    s[0] = hn::Add(s[0], x);
    s[1] = hn::Add(s[1], y);
    s[2] = hn::Add(s[2], z);
    s[3] = hn::Add(s[3], hn::Mul(x, x));
    s[4] = hn::Add(s[4], hn::Mul(x, y));
    s[5] = hn::Add(s[5], hn::Mul(x, z));
    s[6] = hn::Add(s[6], hn::Mul(y, y));
    s[7] = hn::Add(s[7], hn::Mul(y, z));
    s[8] = hn::Add(s[8], hn::Mul(z, z));
  }
  for (std::size_t k = 0; k < kSums; ++k) hn::Store(s[k], dd, &sums->lanes[k][begin]);
}

NeighborhoodMoments SumAll(const CandidateColumns& candidates, const Coordinates& center,
                           float squared_radius) {
  Neighbors neighbors;
  LaneSums sums;
  std::size_t all = 0;
  for (std::size_t begin = 0; begin < candidates.count; begin += kBatch) {
    const std::size_t end = HWY_MIN(begin + kBatch, candidates.count);
    const std::size_t count =
        GatherNeighbors(candidates, begin, end, center, squared_radius, &neighbors);
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(DoubleTag())) {
      AddToLanes(neighbors, count, center, lane, &sums);
    }
    all += count;
  }
  double total[kSums];
  for (std::size_t k = 0; k < kSums; ++k) {
    const double* s = sums.lanes[k];
    total[k] = ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }
  return {total[0], total[1], total[2], total[3], total[4],
          total[5], total[6], total[7], total[8], static_cast<std::uint32_t>(all)};
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
    const auto squared =
        SquaredDistances(df, hn::LoadU(df, candidates.x + j), hn::LoadU(df, candidates.y + j),
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
