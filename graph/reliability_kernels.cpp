#include "graph/reliability_kernels.h"

#include <algorithm>
#include <cmath>

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/reliability_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kChunk = 16;  // rows that are looked at together
constexpr std::size_t kLanes = 8;   // of the sums
using Wide = hn::CappedTag<float, kChunk>;
using Sums = hn::CappedTag<float, kLanes>;

/// Squared distances from one row to others, in both clouds.
template <class D>
struct Squares {
  hn::Vec<D> rise;  // in the source beyond that in the target
  hn::Vec<D> in_source, in_target;
};

template <class D>
HWY_INLINE Squares<D> SquaresAt(D d, const ColumnView& c, std::size_t a, std::size_t b) {
  const auto ux = hn::Sub(hn::LoadU(d, c.qx + b), hn::Set(d, c.qx[a]));
  const auto uy = hn::Sub(hn::LoadU(d, c.qy + b), hn::Set(d, c.qy[a]));
  const auto uz = hn::Sub(hn::LoadU(d, c.qz + b), hn::Set(d, c.qz[a]));
  const auto vx = hn::Sub(hn::LoadU(d, c.px + b), hn::Set(d, c.px[a]));
  const auto vy = hn::Sub(hn::LoadU(d, c.py + b), hn::Set(d, c.py[a]));
  const auto vz = hn::Sub(hn::LoadU(d, c.pz + b), hn::Set(d, c.pz[a]));
  return {hn::Sub(uz, vz), hn::Add(hn::Add(hn::Mul(ux, ux), hn::Mul(uy, uy)), hn::Mul(uz, uz)),
          hn::Add(hn::Add(hn::Mul(vx, vx), hn::Mul(vy, vy)), hn::Mul(vz, vz))};
}

/// Factors of the test that needs no root: with squared lengths A and B, |sqrt A - sqrt B| < e
/// implies (A - B)^2 <= e^2 (sqrt A + sqrt B)^2 <= 2 e^2 (A + B). One part in a hundred and the
/// second term cover what single precision rounds in lengths up to 2^12 e.
struct RootlessTest {
  explicit RootlessTest(float limit_m) : linear(2.02F * limit_m * limit_m) {}
  float linear;
  static constexpr float kSquare = 4e-10F;
};

/// Rows from b on that may be compatible with row a. Not the same bits on every instruction set,
/// because a product and a sum are rounded together where that is faster; what is left out is
/// compatible on none.
template <class D>
HWY_INLINE hn::Mask<D> MayAgree(D d, const ColumnView& c, std::size_t a, std::size_t b,
                                const RootlessTest& test) {
  const auto difference = [&](const float* column) {
    return hn::Sub(hn::LoadU(d, column + b), hn::Set(d, column[a]));
  };
  const auto ux = difference(c.qx), uy = difference(c.qy), uz = difference(c.qz);
  const auto vx = difference(c.px), vy = difference(c.py), vz = difference(c.pz);
  const auto in_source = hn::MulAdd(ux, ux, hn::MulAdd(uy, uy, hn::Mul(uz, uz)));
  const auto in_target = hn::MulAdd(vx, vx, hn::MulAdd(vy, vy, hn::Mul(vz, vz)));
  const auto sum = hn::Add(in_source, in_target);
  const auto apart = hn::Sub(in_source, in_target);
  const auto bound =
      hn::Mul(sum, hn::MulAdd(sum, hn::Set(d, test.kSquare), hn::Set(d, test.linear)));
  return hn::Le(hn::Mul(apart, apart), bound);
}

/// exp(-y) for 0 <= y <= 2/3, relative error below 3e-7.
template <class D>
HWY_INLINE hn::Vec<D> ExpNegative(D d, hn::Vec<D> y) {
  auto sum = hn::Add(hn::Set(d, -0.0083333333F), hn::Mul(y, hn::Set(d, 0.00130F)));
  sum = hn::Add(hn::Set(d, 0.041666667F), hn::Mul(y, sum));
  sum = hn::Add(hn::Set(d, -0.16666667F), hn::Mul(y, sum));
  sum = hn::Add(hn::Set(d, 0.5F), hn::Mul(y, sum));
  sum = hn::Add(hn::Set(d, -1.0F), hn::Mul(y, sum));
  return hn::Add(hn::Set(d, 1.0F), hn::Mul(y, sum));
}

template <class D>
HWY_INLINE hn::Vec<D> Weights(D d, const Squares<D>& s, const CompatibilityRule& rule) {
  const auto zero = hn::Zero(d);
  const auto length = hn::Sqrt(s.in_source);
  const auto x = hn::Abs(hn::Sub(length, hn::Sqrt(s.in_target)));
  const auto rise = hn::Add(hn::Set(d, rule.height_m), hn::Mul(hn::Set(d, rule.slope), length));
  const auto apart = hn::And(hn::Gt(s.in_source, zero), hn::Gt(s.in_target, zero));
  const auto level = hn::Lt(hn::Abs(s.rise), rise);
  const auto compatible = hn::And(hn::And(hn::Lt(x, hn::Set(d, rule.limit_m)), apart), level);
  const auto weight = ExpNegative(d, hn::Mul(hn::Mul(x, x), hn::Set(d, rule.inverse_6l2)));
  return hn::IfThenElseZero(compatible, weight);
}

/// Appends the rows from `b` on whose lane is set, without branches; writes whole vectors.
template <class D>
HWY_INLINE std::size_t Append(D d, hn::Mask<D> mask, std::size_t b, std::size_t count,
                              std::uint32_t* found) {
  const hn::Rebind<std::uint32_t, D> in_rows;
  // From 0, so that compilers make it once.
  const auto rows = hn::Add(hn::Iota(in_rows, 0U), hn::Set(in_rows, static_cast<std::uint32_t>(b)));
  hn::StoreU(hn::Compress(rows, hn::RebindMask(in_rows, mask)), in_rows, found + count);
  return count + hn::CountTrue(d, mask);
}

/// A test by products alone. With e the limit and A, B the squared lengths, |sqrt A - sqrt B| < e
/// implies |A - B| <= e (2 sqrt A + e). A and A - B are summed from squares and products of
/// coordinates, |u|^2 = |b|^2 + |a|^2 - 2 a.b, so that A is wrong by some 22 roundings of the
/// largest square, below r, and A - B by some 48, below 2 r. As (x + y)^2 <= (1 + t) x^2 + (1 + 1 /
/// t) y^2, twice with t = 0.05, what is computed has (A - B)^2 <= 4.41 e^2 (A + r) + 22.05 e^4 + 21
/// (2 r)^2.
struct ProductTest {
  ProductTest(float limit_m, float largest_square) {
    // Lengths that are compared later are rounded, too.
    const float e = limit_m + 4e-6F * std::sqrt(largest_square);
    const float r = 4e-6F * largest_square;
    linear = 4.42F * e * e;
    constant = linear * r + 22.1F * e * e * e * e + 85.0F * r * r;
  }
  float linear, constant;
};

/// Lists the rows b in [begin, end), `begin` a multiple of kChunk, that may be compatible with row
/// a, ascending, without branches: nobody could foretell them. Returns their number. Not the same
/// on every instruction set, because a product and a sum are rounded together where that is faster;
/// what is left out is compatible on none.
HWY_INLINE std::size_t ListNear(const ColumnView& columns, float limit_m, std::size_t a,
                                std::size_t begin, std::size_t end,
                                std::uint32_t* HWY_RESTRICT found) {
  const ColumnView c = columns;  // cannot be what is written to
  const Wide d;
  const ProductTest test(limit_m, c.largest_square);
  const auto qx = hn::Set(d, -2.0F * c.qx[a]), px = hn::Set(d, 2.0F * c.px[a]);
  const auto qy = hn::Set(d, -2.0F * c.qy[a]), py = hn::Set(d, 2.0F * c.py[a]);
  const auto qz = hn::Set(d, -2.0F * c.qz[a]), pz = hn::Set(d, 2.0F * c.pz[a]);
  const auto q_squared = hn::Set(d, c.q_squared[a]), p_squared = hn::Set(d, c.p_squared[a]);
  std::size_t count = 0;
  for (std::size_t b = begin; b < end; b += hn::Lanes(d)) {
    const auto times = [&](const float* column, auto factor, auto sum) {
      return hn::MulAdd(hn::LoadU(d, column + b), factor, sum);
    };
    const auto squares = hn::Add(hn::LoadU(d, c.q_squared + b), q_squared);
    const auto in_source = times(c.qx, qx, times(c.qy, qy, times(c.qz, qz, squares)));
    const auto rest = hn::Sub(in_source, hn::Add(hn::LoadU(d, c.p_squared + b), p_squared));
    const auto apart = times(c.px, px, times(c.py, py, times(c.pz, pz, rest)));
    const auto bound = hn::MulAdd(in_source, hn::Set(d, test.linear), hn::Set(d, test.constant));
    auto may = hn::Le(hn::Mul(apart, apart), bound);
    if (b + hn::Lanes(d) > end) may = hn::And(may, hn::FirstN(d, end - b));
    count = Append(d, may, b, count, found);
  }
  return count;
}

/// Rows that may be compatible with one row, with the squares of their distances from it.
struct NearRows {
  static constexpr std::size_t kMost = 2048;
  HWY_ALIGN std::uint32_t row[kMost + kChunk];
  HWY_ALIGN float rise[kMost + kChunk];  // in the source beyond that in the target
  HWY_ALIGN float in_source[kMost + kChunk];
  HWY_ALIGN float in_target[kMost + kChunk];
  HWY_ALIGN float weight[kMost + kChunk];
};

/// Weights of the rows b in [begin, end), at most kMost, that may be compatible with row a; returns
/// their number.
HWY_INLINE std::size_t WeighNear(const ColumnView& c, const CompatibilityRule& rule, std::size_t a,
                                 std::size_t begin, std::size_t end, NearRows* near) {
  const std::size_t count = ListNear(c, rule.limit_m, a, begin, end, near->row);
  const hn::CappedTag<float, 1> one;
  for (std::size_t i = 0; i < count; ++i) {
    const auto squares = SquaresAt(one, c, a, near->row[i]);
    near->rise[i] = hn::GetLane(squares.rise);
    near->in_source[i] = hn::GetLane(squares.in_source);
    near->in_target[i] = hn::GetLane(squares.in_target);
  }
  const Wide d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Squares<Wide> s{hn::Load(d, near->rise + i), hn::Load(d, near->in_source + i),
                          hn::Load(d, near->in_target + i)};
    hn::Store(Weights(d, s, rule), d, near->weight + i);
  }
  return count;
}

/// Calls `body(weight, b)` for the rows b in [begin, whole) that may be compatible with row a,
/// ascending; `begin` is a multiple of kChunk.
template <class Body>
HWY_INLINE void ForWeights(const ColumnView& c, const CompatibilityRule& rule, std::size_t a,
                           std::size_t begin, std::size_t whole, NearRows* near, Body body) {
  for (std::size_t b = begin; b < whole; b += NearRows::kMost) {
    const std::size_t count = WeighNear(c, rule, a, b, std::min(b + NearRows::kMost, whole), near);
    for (std::size_t i = 0; i < count; ++i) body(near->weight[i], near->row[i]);
  }
}

/// What row a has in common with the rows from `whole`, the last multiple of kLanes, on.
HWY_INLINE void StoreLast(const ColumnView& c, const CompatibilityRule& rule, std::size_t a,
                          std::size_t whole, float* last) {
  const Sums d;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
    hn::Store(Weights(d, SquaresAt(d, c, a, whole + i), rule), d, last + i);
  }
}

float SumReliability(const ColumnView& c, const CompatibilityRule& rule, std::size_t a,
                     NearRows* near) {
  HWY_ALIGN float lanes[kLanes] = {};
  HWY_ALIGN float last[kLanes];
  const std::size_t whole = c.rows - c.rows % kLanes;
  ForWeights(c, rule, a, 0, whole, near,
             [&](float weight, std::uint32_t b) { lanes[b % kLanes] += weight; });
  StoreLast(c, rule, a, whole, last);
  float sum = 0.0F;
  for (const float lane : lanes) sum += lane;
  for (std::size_t b = whole; b < c.rows; ++b) sum += last[b - whole];
  return sum;
}

void SumReliabilities(const ColumnView& c, const CompatibilityRule& rule, std::size_t begin,
                      float* out, std::size_t count) {
  NearRows near{};
  for (std::size_t i = 0; i < count; ++i) out[i] = SumReliability(c, rule, begin + i, &near);
}

/// Adds what the rows after `a`, but for those from `whole` on, have in common with it: to `lanes`
/// by their own number, and to their own sums in the lane of `a`, whose columns begin at `of_rows`.
HWY_INLINE void AddLater(const ColumnView& c, const CompatibilityRule& rule, std::size_t a,
                         std::size_t whole, NearRows* near, float* lanes, float* of_rows) {
  const std::size_t begin = (a + 1) / kChunk * kChunk;
  ForWeights(c, rule, a, begin, whole, near, [&](float weight, std::uint32_t b) {
    const float later = b > a ? weight : 0.0F;
    lanes[b % kLanes] += later;
    of_rows[b] += later;
  });
}

/// `sums`: kLanes columns of `stride`, zeros. Rows ascend, so every lane of every row is summed in
/// the order of SumReliability.
void SumAllReliabilities(const ColumnView& c, const CompatibilityRule& rule, std::size_t stride,
                         float* HWY_RESTRICT sums, float* HWY_RESTRICT out) {
  NearRows near{};
  const std::size_t whole = c.rows - c.rows % kLanes;
  for (std::size_t a = 0; a < c.rows; ++a) {
    HWY_ALIGN float lanes[kLanes];
    HWY_ALIGN float last[kLanes];
    float* of_rows = sums + a % kLanes * stride;
    for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = sums[k * stride + a];
    if (a < whole) AddLater(c, rule, a, whole, &near, lanes, of_rows);
    StoreLast(c, rule, a, whole, last);
    if (a < whole) {
      for (std::size_t k = 0; k < kLanes; ++k) of_rows[whole + k] += last[k];
    }
    float sum = 0.0F;
    for (const float lane : lanes) sum += lane;
    for (std::size_t b = whole; b < c.rows; ++b) sum += last[b - whole];
    out[a] = sum;
  }
}

std::size_t FindSameLength(const ColumnView& columns, std::size_t a, std::size_t begin,
                           float limit_m, std::uint32_t* HWY_RESTRICT found) {
  const ColumnView c = columns;  // cannot be what is written to
  const Wide d;
  const RootlessTest test(limit_m);
  std::size_t count = 0;
  for (std::size_t b = begin; b < c.rows; b += hn::Lanes(d)) {
    count = Append(d, MayAgree(d, c, a, b, test), b, count, found);
  }
  return count;
}

std::size_t FindAlongEdge(const ColumnView& columns, const EdgeAxes& edge, float limit_m,
                          std::size_t bar, std::uint32_t* HWY_RESTRICT found) {
  const ColumnView c = columns;  // cannot be what is written to
  const EdgeAxes e = edge;
  const Wide d;
  const RootlessTest test(limit_m);
  const std::size_t a = e.row;
  const float here = (c.px[a] * e.px + c.py[a] * e.py + c.pz[a] * e.pz) -
                     (c.qx[a] * e.qx + c.qy[a] * e.qy + c.qz[a] * e.qz);
  std::size_t count = 0;
  for (std::size_t b = 0; b < c.rows; b += hn::Lanes(d)) {
    if (count + (c.rows - b) <= bar) return 0;
    const auto times = [&](const float* column, float axis, auto sum) {
      return hn::MulAdd(hn::LoadU(d, column + b), hn::Set(d, axis), sum);
    };
    const auto p = times(c.px, e.px, times(c.py, e.py, times(c.pz, e.pz, hn::Set(d, -here))));
    const auto along = times(c.qx, -e.qx, times(c.qy, -e.qy, times(c.qz, -e.qz, p)));
    const auto beside = hn::Lt(hn::Abs(along), hn::Set(d, limit_m));
    count = Append(d, hn::And(beside, MayAgree(d, c, a, b, test)), b, count, found);
  }
  return count <= bar ? 0 : count;
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <vector>

namespace backsight {

HWY_EXPORT(SumReliabilities);
HWY_EXPORT(SumAllReliabilities);
HWY_EXPORT(FindSameLength);
HWY_EXPORT(FindAlongEdge);

void SumReliabilities(const ColumnView& columns, const CompatibilityRule& rule, std::size_t begin,
                      std::span<float> out) {
  HWY_DYNAMIC_DISPATCH(SumReliabilities)(columns, rule, begin, out.data(), out.size());
}

void SumAllReliabilities(const ColumnView& columns, const CompatibilityRule& rule,
                         std::span<float> out) {
  constexpr std::size_t kLanes = 8;
  constexpr std::size_t kBeyond = 16;
  const std::size_t stride = columns.rows + kBeyond;
  std::vector<float> sums(kLanes * stride, 0.0F);
  HWY_DYNAMIC_DISPATCH(SumAllReliabilities)(columns, rule, stride, sums.data(), out.data());
}

std::size_t FindSameLength(const ColumnView& columns, std::size_t a, std::size_t begin,
                           float limit_m, float slack_m, std::uint32_t* found) {
  return HWY_DYNAMIC_DISPATCH(FindSameLength)(columns, a, begin, limit_m + slack_m, found);
}

std::size_t FindAlongEdge(const ColumnView& columns, const EdgeAxes& edge, float limit_m,
                          float slack_m, std::size_t bar, std::uint32_t* found) {
  return HWY_DYNAMIC_DISPATCH(FindAlongEdge)(columns, edge, limit_m + slack_m, bar, found);
}

}  // namespace backsight
#endif
