#include "stages/surface_kernels.h"

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/surface_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = 8;  // of the sums
using Tag = hn::CappedTag<double, kLanes>;
using Doubles = hn::Vec<Tag>;

struct Vector {
  Doubles x, y, z;
};
/// Symmetric.
struct Matrix {
  Doubles xx, xy, xz, yy, yz, zz;
};

HWY_INLINE Vector LoadVector(const std::array<const double*, 3>& columns, std::size_t i) {
  const Tag d;
  return {hn::LoadU(d, columns[0] + i), hn::LoadU(d, columns[1] + i), hn::LoadU(d, columns[2] + i)};
}
HWY_INLINE Doubles Dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector Minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Doubles Norm(const Vector& v) { return hn::Sqrt(Dot(v, v)); }

HWY_INLINE Vector Rotated(const KernelMotion& motion, const Vector& v) {
  const Tag d;
  const auto row = [&](std::size_t r) {
    const double* m = motion.rotation.data() + 3 * r;
    return Dot({hn::Set(d, m[0]), hn::Set(d, m[1]), hn::Set(d, m[2])}, v);
  };
  return {row(0), row(1), row(2)};
}
HWY_INLINE Vector Moved(const KernelMotion& motion, const Vector& v) {
  const Tag d;
  const Vector r = Rotated(motion, v);
  return {hn::Add(r.x, hn::Set(d, motion.translation[0])),
          hn::Add(r.y, hn::Set(d, motion.translation[1])),
          hn::Add(r.z, hn::Set(d, motion.translation[2]))};
}

std::size_t Uncertain(const SurfacePairColumns& pairs, const KernelMotion& motion, double reach_m,
                      std::uint32_t* found) {
  const Tag d;
  constexpr double kRounding = 1e-9;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pairs.count; i += hn::Lanes(d)) {
    const Vector moved = Moved(motion, LoadVector(pairs.point, i));
    const Doubles way = Norm(Minus(moved, LoadVector(pairs.asked, i)));
    const Doubles others =
        hn::Sub(hn::Sub(hn::LoadU(d, pairs.others + i), way), hn::Set(d, kRounding));
    const Doubles distance = Norm(Minus(moved, LoadVector(pairs.fixed, i)));
    const Doubles limit = hn::IfThenElse(hn::Eq(distance, distance), distance, hn::Set(d, reach_m));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(hn::Gt(others, limit)), bits);
    for (std::uint32_t set = bits[0]; set != 0; set &= set - 1) {
      const std::size_t at = i + hwy::Num0BitsBelowLS1Bit_Nonzero32(set);
      if (at < pairs.count) found[count++] = static_cast<std::uint32_t>(at);
    }
  }
  return count;
}

/// Inverse of the sum of both points' covariances, 2 a I - (a - c) (n n^T + m m^T).
HWY_INLINE Matrix Weight(const Vector& n, const Vector& m, const SurfacePairRule& rule) {
  const Tag d;
  const Doubles twice = hn::Set(d, 2.0 * rule.along_variance);
  const Doubles less = hn::Set(d, rule.along_variance - rule.across_variance);
  const auto entry = [&](Doubles ni, Doubles nj, Doubles mi, Doubles mj) {
    return hn::Mul(less, hn::Add(hn::Mul(ni, nj), hn::Mul(mi, mj)));
  };
  const Matrix c{
      hn::Sub(twice, entry(n.x, n.x, m.x, m.x)), hn::Neg(entry(n.x, n.y, m.x, m.y)),
      hn::Neg(entry(n.x, n.z, m.x, m.z)),        hn::Sub(twice, entry(n.y, n.y, m.y, m.y)),
      hn::Neg(entry(n.y, n.z, m.y, m.z)),        hn::Sub(twice, entry(n.z, n.z, m.z, m.z))};
  const auto minor = [](Doubles a, Doubles b, Doubles p, Doubles q) {
    return hn::Sub(hn::Mul(a, b), hn::Mul(p, q));
  };
  const Matrix minors{minor(c.yy, c.zz, c.yz, c.yz), minor(c.xz, c.yz, c.xy, c.zz),
                      minor(c.xy, c.yz, c.xz, c.yy), minor(c.xx, c.zz, c.xz, c.xz),
                      minor(c.xy, c.xz, c.xx, c.yz), minor(c.xx, c.yy, c.xy, c.xy)};
  const Doubles scale =
      hn::Div(hn::Set(d, 1.0), Dot({c.xx, c.xy, c.xz}, {minors.xx, minors.xy, minors.xz}));
  return {hn::Mul(minors.xx, scale), hn::Mul(minors.xy, scale), hn::Mul(minors.xz, scale),
          hn::Mul(minors.yy, scale), hn::Mul(minors.yz, scale), hn::Mul(minors.zz, scale)};
}

/// m x v, by the transpose of -[m]x.
HWY_INLINE Vector Turned(const Vector& m, const Vector& v) {
  return {hn::Sub(hn::Mul(m.y, v.z), hn::Mul(m.z, v.y)),
          hn::Sub(hn::Mul(m.z, v.x), hn::Mul(m.x, v.z)),
          hn::Sub(hn::Mul(m.x, v.y), hn::Mul(m.y, v.x))};
}

void SumPairs(const SurfacePairColumns& pairs, const KernelMotion& motion,
              const SurfacePairRule& rule, double* HWY_RESTRICT sums) {
  const Tag d;
  for (std::size_t i = 0; i < pairs.count; i += hn::Lanes(d)) {
    const Vector moved = Moved(motion, LoadVector(pairs.point, i));
    const Vector residual = Minus(moved, LoadVector(pairs.fixed, i));
    const Vector n = Rotated(motion, LoadVector(pairs.normal, i));
    const Vector m = LoadVector(pairs.fixed_normal, i);
    const auto matches = hn::And(hn::Le(Norm(residual), hn::Set(d, rule.reach_m)),
                                 hn::Ge(Dot(n, m), hn::Set(d, rule.least_cosine)));
    if (hn::AllFalse(d, matches)) continue;
    const Matrix w = Weight(n, m, rule);
    const Vector wx{w.xx, w.xy, w.xz}, wy{w.xy, w.yy, w.yz}, wz{w.xz, w.yz, w.zz};
    // Rows of W (-[m]x) are m x rows of W, and what is left of it likewise.
    const Vector kx = Turned(moved, wx), ky = Turned(moved, wy), kz = Turned(moved, wz);
    const Vector c0 = Turned(moved, {kx.x, ky.x, kz.x});
    const Vector c1 = Turned(moved, {kx.y, ky.y, kz.y});
    const Vector c2 = Turned(moved, {kx.z, ky.z, kz.z});
    const Vector pull{Dot(wx, residual), Dot(wy, residual), Dot(wz, residual)};
    const Vector turn = Turned(moved, pull);
    double* HWY_RESTRICT sum = sums + i % kLanes;
    const auto add = [&](Doubles term) {
      hn::StoreU(hn::Add(hn::LoadU(d, sum), hn::IfThenElseZero(matches, term)), d, sum);
      sum += kLanes;
    };
    add(c0.x);
    add(c0.y), add(c1.y);
    add(c0.z), add(c1.z), add(c2.z);
    add(kx.x), add(kx.y), add(kx.z), add(w.xx);
    add(ky.x), add(ky.y), add(ky.z), add(w.xy), add(w.yy);
    add(kz.x), add(kz.y), add(kz.z), add(w.xz), add(w.yz), add(w.zz);
    add(turn.x), add(turn.y), add(turn.z);
    add(pull.x), add(pull.y), add(pull.z);
    add(hn::Set(d, 1.0));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Uncertain);
HWY_EXPORT(SumPairs);

std::size_t FindUncertain(const SurfacePairColumns& pairs, const KernelMotion& motion,
                          double reach_m, std::uint32_t* found) {
  return HWY_DYNAMIC_DISPATCH(Uncertain)(pairs, motion, reach_m, found);
}

SurfacePairSums SumSurfacePairs(const SurfacePairColumns& pairs, const KernelMotion& motion,
                                const SurfacePairRule& rule) {
  constexpr std::size_t kTerms = 28;
  constexpr std::size_t kLanes = 8;
  std::array<double, kTerms * kLanes> lanes{};
  HWY_DYNAMIC_DISPATCH(SumPairs)(pairs, motion, rule, lanes.data());
  std::array<double, kTerms> terms{};
  for (std::size_t term = 0; term < kTerms; ++term) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) terms[term] += lanes[term * kLanes + lane];
  }
  SurfacePairSums sums;
  for (std::size_t k = 0; k < 21; ++k) sums.matrix[k] = terms[k];
  for (std::size_t k = 0; k < 6; ++k) sums.gradient[k] = terms[21 + k];
  sums.matches = terms[27];
  return sums;
}

}  // namespace backsight
#endif
