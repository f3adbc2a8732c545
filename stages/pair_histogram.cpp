#include "stages/pair_histogram.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/pair_histogram.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMostLanes = 16;
using FloatTag = hn::CappedTag<float, kMostLanes>;
using CountTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Counts = hn::Vec<CountTag>;
using Mask = hn::Mask<FloatTag>;

/// Bins are symmetric about the middle one. An angle is |its| bins beyond the middle as there are
/// edges that it has passed.
constexpr std::size_t kEdges = PairHistogram::kBins / 2;
/// cot(k pi / 11)^2 with the sign of the cotangent, k = 1, 3, 5, 7, 9.
constexpr float kAngleEdges[kEdges] = {11.5987056F, 0.750830798F, 0.0206721978F, -0.208560913F,
                                       -2.42123052F};
/// (11 / k)^2.
constexpr float kCosineEdges[kEdges] = {121.0F, 121.0F / 9.0F, 121.0F / 25.0F, 121.0F / 49.0F,
                                        121.0F / 81.0F};

/// Pairs past each edge: those on the positive side in the lower half of a lane, those on the
/// negative side in the upper half.
struct Passed {
  Counts edges[kEdges];
};

/// What a pair adds on either side: nothing if it has no angles.
struct Increments {
  Counts positive, negative;
};

/// Edge k is passed where low < high * edges[k].
HWY_INLINE void CountPassed(Floats low, Floats high, Mask is_negative, const Increments& increments,
                            const float* edges, Passed* passed) {
  const FloatTag df;
  const CountTag di;
  const Counts increment =
      hn::IfThenElse(hn::RebindMask(di, is_negative), increments.negative, increments.positive);
  for (std::size_t k = 0; k < kEdges; ++k) {
    const Mask beyond = hn::Lt(low, hn::Mul(high, hn::Set(df, edges[k])));
    passed->edges[k] =
        hn::Add(passed->edges[k], hn::IfThenElseZero(hn::RebindMask(di, beyond), increment));
  }
}

HWY_INLINE Floats Dot(Floats ax, Floats ay, Floats az, Floats bx, Floats by, Floats bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

/// Adds the pairs of one side to the bins of a block: `passed[k]` of `pairs` are past edge k.
void AddSide(const std::uint32_t* passed, int step, std::uint32_t* middle) {
  for (std::size_t k = 0; k < kEdges; ++k) {
    const std::uint32_t next = k + 1 < kEdges ? passed[k + 1] : 0;
    middle[static_cast<std::ptrdiff_t>(k + 1) * step] += passed[k] - next;
    middle[0] -= passed[k] - next;
  }
}

void AddToBins(const Passed& passed, std::uint32_t pairs, std::uint32_t* bins) {
  const CountTag di;
  std::uint32_t positive[kEdges];
  std::uint32_t negative[kEdges];
  for (std::size_t k = 0; k < kEdges; ++k) {
    const auto sum = static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, passed.edges[k])));
    positive[k] = sum & 0xFFFFU;
    negative[k] = sum >> 16U;
  }
  std::uint32_t* middle = bins + kEdges;
  *middle += pairs;
  AddSide(positive, 1, middle);
  AddSide(negative, -1, middle);
}

/// How many candidates are looked at before the neighbours among them are counted. Below 2^16, lest
/// halves of lanes overflow.
constexpr std::size_t kBatch = 1024;

/// Neighbours, their coordinates relative to the point. Behind them is room for a vector.
struct alignas(64) Neighbors {
  float dx[kBatch + kMostLanes], dy[kBatch + kMostLanes], dz[kBatch + kMostLanes];
  float nx[kBatch + kMostLanes], ny[kBatch + kMostLanes], nz[kBatch + kMostLanes];
};

/// Gathers without a branch, of which every other would be mispredicted. Returns their number;
/// behind them stand points that are in one place with `p`.
HWY_INLINE std::size_t GatherNeighbors(const OrientedPoint& p, const OrientedColumns& others,
                                       float squared_radius, Neighbors* neighbors) {
  const FloatTag d;
  const Floats px = hn::Set(d, p.x), py = hn::Set(d, p.y), pz = hn::Set(d, p.z);
  const Floats radius = hn::Set(d, squared_radius);
  std::size_t count = 0;
  for (std::size_t j = 0; j < others.count; j += hn::Lanes(d)) {
    const Floats dx = hn::Sub(hn::LoadU(d, others.x + j), px);
    const Floats dy = hn::Sub(hn::LoadU(d, others.y + j), py);
    const Floats dz = hn::Sub(hn::LoadU(d, others.z + j), pz);
    const Mask near = hn::Lt(Dot(dx, dy, dz, dx, dy, dz), radius);
    hn::StoreU(hn::Compress(dx, near), d, neighbors->dx + count);
    hn::StoreU(hn::Compress(dy, near), d, neighbors->dy + count);
    hn::StoreU(hn::Compress(dz, near), d, neighbors->dz + count);
    hn::StoreU(hn::Compress(hn::LoadU(d, others.nx + j), near), d, neighbors->nx + count);
    hn::StoreU(hn::Compress(hn::LoadU(d, others.ny + j), near), d, neighbors->ny + count);
    hn::StoreU(hn::Compress(hn::LoadU(d, others.nz + j), near), d, neighbors->nz + count);
    count += hn::CountTrue(d, near);
  }
  const Floats zero = hn::Zero(d);
  hn::StoreU(zero, d, neighbors->dx + count);
  hn::StoreU(zero, d, neighbors->dy + count);
  hn::StoreU(zero, d, neighbors->dz + count);
  return count;
}

HWY_INLINE void CountNeighbors(const OrientedPoint& p, const Neighbors& neighbors,
                               std::size_t count, std::uint32_t* counts) {
  const FloatTag df;
  const CountTag di;
  const Floats zero = hn::Zero(df);
  const Floats pnx = hn::Set(df, p.nx), pny = hn::Set(df, p.ny), pnz = hn::Set(df, p.nz);
  const Counts one = hn::Set(di, 1), one_above = hn::Set(di, 1 << 16);
  const Counts none = hn::Zero(di);
  Passed f1{{none, none, none, none, none}};
  Passed f2 = f1;
  Passed f3 = f1;
  std::size_t pairs = 0;
  for (std::size_t j = 0; j < count; j += hn::Lanes(df)) {
    const Floats dx = hn::Load(df, neighbors.dx + j);
    const Floats dy = hn::Load(df, neighbors.dy + j);
    const Floats dz = hn::Load(df, neighbors.dz + j);
    const Floats nx = hn::Load(df, neighbors.nx + j);
    const Floats ny = hn::Load(df, neighbors.ny + j);
    const Floats nz = hn::Load(df, neighbors.nz + j);
    const Floats squared = Dot(dx, dy, dz, dx, dy, dz);
    const Floats along_p = Dot(dx, dy, dz, pnx, pny, pnz);
    const Floats along_q = Dot(dx, dy, dz, nx, ny, nz);
    const Floats cosine = Dot(pnx, pny, pnz, nx, ny, nz);
    // d (n_p x n_q) is |d x u| v n_t for either choice of source, because both its factors and d
    // change sign together.
    const Floats triple = Dot(dx, dy, dz, hn::Sub(hn::Mul(pny, nz), hn::Mul(pnz, ny)),
                              hn::Sub(hn::Mul(pnz, nx), hn::Mul(pnx, nz)),
                              hn::Sub(hn::Mul(pnx, ny), hn::Mul(pny, nx)));
    const Mask swap = hn::Lt(hn::Abs(along_p), hn::Abs(along_q));
    // u d and n_t d, d running from source to target.
    const Floats source = hn::IfThenElse(swap, hn::Neg(along_q), along_p);
    const Floats target = hn::IfThenElse(swap, hn::Neg(along_p), along_q);
    const Floats source_squared = hn::Mul(source, source);
    const Floats cross_squared = hn::Sub(squared, source_squared);  // |d x u|^2
    const Mask valid = hn::Gt(cross_squared, zero);
    pairs += hn::CountTrue(df, valid);
    const Increments increments{hn::IfThenElseZero(hn::RebindMask(di, valid), one),
                                hn::IfThenElseZero(hn::RebindMask(di, valid), one_above)};
    // w n_t = (n_t d - (u d)(u n_t)) / |d x u|; f1 does not change if both its sides are scaled.
    // An angle in (0, pi) passes an edge where its cotangent falls below that of the edge.
    const Floats y = hn::Sub(target, hn::Mul(source, cosine));
    const Floats x_squared = hn::Mul(hn::Mul(cosine, cosine), cross_squared);
    CountPassed(hn::CopySign(x_squared, cosine), hn::Mul(y, y), hn::Lt(y, zero), increments,
                kAngleEdges, &f1);
    CountPassed(cross_squared, hn::Mul(triple, triple), hn::Lt(triple, zero), increments,
                kCosineEdges, &f2);
    CountPassed(squared, source_squared, hn::Lt(source, zero), increments, kCosineEdges, &f3);
  }
  const auto counted = static_cast<std::uint32_t>(pairs);
  AddToBins(f1, counted, counts);
  AddToBins(f2, counted, counts + PairHistogram::kBins);
  AddToBins(f3, counted, counts + 2 * PairHistogram::kBins);
}

PairHistogram CountAll(const OrientedPoint& point, const OrientedColumns& others,
                       float squared_radius) {
  PairHistogram histogram;
  Neighbors neighbors;
  for (std::size_t begin = 0; begin < others.count; begin += kBatch) {
    const OrientedColumns batch{others.x + begin,
                                others.y + begin,
                                others.z + begin,
                                others.nx + begin,
                                others.ny + begin,
                                others.nz + begin,
                                HWY_MIN(kBatch, others.count - begin)};
    const std::size_t count = GatherNeighbors(point, batch, squared_radius, &neighbors);
    CountNeighbors(point, neighbors, count, histogram.counts);
    histogram.neighbors += static_cast<std::uint32_t>(count);
  }
  return histogram;
}

}  // namespace
}  // namespace backsight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(CountAll);

PairHistogram CountPairs(const OrientedPoint& point, const OrientedColumns& others,
                         float squared_radius) {
  return HWY_DYNAMIC_DISPATCH(CountAll)(point, others, squared_radius);
}

}  // namespace backsight
#endif
