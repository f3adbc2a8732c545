#include "graph/turn_kernels.h"

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/turn_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, kTurnPadding>;
using Doubles = hn::Vec<Tag>;

struct Vector {
  Doubles x, y, z;
};

HWY_INLINE Doubles Constant(double value) { return hn::Set(Tag(), value); }

HWY_INLINE Vector LoadVector(const std::array<const double*, 3>& columns, std::size_t i) {
  const Tag d;
  return {hn::LoadU(d, columns[0] + i), hn::LoadU(d, columns[1] + i), hn::LoadU(d, columns[2] + i)};
}

HWY_INLINE Doubles Along(const Vector& v, const EdgeFrame::Axis& axis) {
  return hn::Add(hn::Add(hn::Mul(v.x, Constant(axis[0])), hn::Mul(v.y, Constant(axis[1]))),
                 hn::Mul(v.z, Constant(axis[2])));
}

HWY_INLINE Doubles SquaredLength(const Vector& v) {
  return hn::Add(hn::Add(hn::Mul(v.x, v.x), hn::Mul(v.y, v.y)), hn::Mul(v.z, v.z));
}

/// TurnOf of directions.
HWY_INLINE Doubles Turn(Doubles x, Doubles y) {
  const Doubles zero = hn::Zero(Tag());
  const Doubles full = Constant(4.0);
  const Doubles p = hn::Div(y, hn::Add(hn::Abs(x), hn::Abs(y)));
  const Doubles right = hn::IfThenElse(hn::Lt(p, zero), hn::Add(full, p), p);
  return hn::IfThenElse(hn::Lt(x, zero), hn::Sub(Constant(2.0), p), right);
}

struct Arc {
  hn::Mask<Tag> some;  // whether there is one
  Doubles begin, end;
};

/// Of the rotations that bring (mu, mv) within the limit of (qu, qv), `along` apart across: with c
/// the cosine of the angle less (azimuth_q - azimuth_m), |Rz(angle) m - q|^2 <= limit^2  <=>
/// c |2 m q| >= rest. Turns do not depend on their direction's length, so nothing is divided by
/// |2 m q|, which needs a root.
HWY_INLINE Arc ArcOf(Doubles mu, Doubles mv, Doubles qu, Doubles qv, Doubles along,
                     double limit_m) {
  const Doubles zero = hn::Zero(Tag()), full = Constant(4.0);
  const Doubles m2 = hn::Add(hn::Mul(mu, mu), hn::Mul(mv, mv));
  const Doubles q2 = hn::Add(hn::Mul(qu, qu), hn::Mul(qv, qv));
  const Doubles product2 = hn::Mul(Constant(4.0), hn::Mul(m2, q2));  // |2 m q|^2
  const Doubles rest =
      hn::Sub(hn::Add(hn::Add(m2, q2), hn::Mul(along, along)), Constant(limit_m * limit_m));
  const Doubles squares = hn::Sub(product2, hn::Mul(rest, rest));
  const auto negative = hn::Le(rest, zero);
  const auto all =
      hn::And(hn::Or(hn::Lt(product2, Constant(1e-24)), hn::Le(squares, zero)), negative);
  const auto some = hn::Or(hn::Ge(squares, zero), negative);
  const Doubles sine = hn::Sqrt(hn::Max(squares, zero));  // times |2 m q|, as is the cosine, rest
  // The middle's direction, turned back and on by half the width.
  const Doubles x = hn::Add(hn::Mul(qu, mu), hn::Mul(qv, mv));
  const Doubles y = hn::Sub(hn::Mul(qv, mu), hn::Mul(qu, mv));
  const Doubles xk = hn::Mul(x, rest), yk = hn::Mul(y, rest);
  const Doubles xs = hn::Mul(x, sine), ys = hn::Mul(y, sine);
  Doubles begin = Turn(hn::Add(xk, ys), hn::Sub(yk, xs));
  begin = hn::IfThenElse(hn::Ge(begin, full), zero, begin);
  Doubles end = Turn(hn::Sub(xk, ys), hn::Add(yk, xs));
  end = hn::IfThenElse(hn::Lt(end, begin), hn::Add(end, full), end);
  return {some, hn::IfThenElse(all, zero, begin), hn::IfThenElse(all, full, end)};
}

/// Whether lengths of these squares differ by less than the limit: |sqrt a - sqrt b| < e  <=>
/// a + b - e^2 < 2 sqrt(a b).
HWY_INLINE hn::Mask<Tag> AreOneLength(Doubles a, Doubles b, double limit_m) {
  const Doubles rest = hn::Sub(hn::Add(a, b), Constant(limit_m * limit_m));
  const Doubles product2 = hn::Mul(Constant(4.0), hn::Mul(a, b));
  return hn::Or(hn::Lt(rest, hn::Zero(Tag())), hn::Lt(hn::Mul(rest, rest), product2));
}

std::size_t Turns(const OffsetColumns& columns, const EdgeFrame& edge, double limit_m,
                  std::uint32_t* HWY_RESTRICT places, double* HWY_RESTRICT begins,
                  double* HWY_RESTRICT ends) {
  const OffsetColumns rows = columns;  // cannot be what is written to
  const EdgeFrame e = edge;
  const Tag d;
  const Doubles limit = Constant(limit_m);
  HWY_ALIGN double begin[kTurnPadding];
  HWY_ALIGN double end[kTurnPadding];
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.count; i += hn::Lanes(d)) {
    const Vector s = LoadVector(rows.source, i);
    const Vector t = LoadVector(rows.target, i);
    const Doubles in_source = Along(s, e.source_along);
    const Doubles in_target = Along(t, e.target_along);
    const auto alike = hn::And(AreOneLength(SquaredLength(s), SquaredLength(t), limit_m),
                               hn::Lt(hn::Abs(hn::Sub(in_source, in_target)), limit));
    const Doubles along = hn::Sub(in_target, hn::Add(in_source, Constant(e.shift_m)));
    const Arc arc = ArcOf(Along(s, e.source_u), Along(s, e.source_v), Along(t, e.target_u),
                          Along(t, e.target_v), along, limit_m);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::And(alike, arc.some), bits);
    if (bits[0] == 0) continue;
    hn::Store(arc.begin, d, begin);
    hn::Store(arc.end, d, end);
    for (std::uint32_t set = bits[0]; set != 0; set &= set - 1) {
      const std::size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero32(set);
      if (i + lane >= rows.count) break;
      places[count] = static_cast<std::uint32_t>(i + lane);
      begins[count] = begin[lane];
      ends[count] = end[lane];
      ++count;
    }
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Turns);

std::size_t FindTurns(const OffsetColumns& rows, const EdgeFrame& edge, double limit_m,
                      std::uint32_t* places, double* begins, double* ends) {
  return HWY_DYNAMIC_DISPATCH(Turns)(rows, edge, limit_m, places, begins, ends);
}

}  // namespace backsight
#endif
