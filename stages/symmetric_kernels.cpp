#include "stages/symmetric_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/symmetric_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, kSymmetricPadding>;
using Doubles = hn::Vec<Tag>;

HWY_INLINE Doubles Constant(double value) { return hn::Set(Tag(), value); }

struct Matrix {
  Doubles xx, xy, xz, yy, yz, zz;
};

struct Vector {
  Doubles x, y, z;
};

struct Roots {
  Doubles low, middle, high;
};

HWY_INLINE Matrix LoadMatrix(const double* const* elements, std::size_t i) {
  const Tag d;
  return {hn::LoadU(d, elements[0] + i), hn::LoadU(d, elements[1] + i),
          hn::LoadU(d, elements[2] + i), hn::LoadU(d, elements[3] + i),
          hn::LoadU(d, elements[4] + i), hn::LoadU(d, elements[5] + i)};
}

HWY_INLINE Doubles Dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE Vector Cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

/// Roots of t^3 - 3 t - 2 r = 0 for r in [-1, 1], which are 2 cos((arccos(r) + 2 k pi) / 3). The
/// greatest of |r| lies in [sqrt(3), 2], apart from the others.
HWY_INLINE Roots CubicRoots(Doubles r) {
  const Doubles three = Constant(3.0);
  const Doubles s = hn::Abs(r);
  const Doubles two_s = hn::Add(s, s);
  // A parabola that is off by less than 1e-3; each step squares the error.
  Doubles t =
      hn::Add(Constant(1.7326), hn::Mul(s, hn::Sub(Constant(0.321), hn::Mul(s, Constant(0.054)))));
  for (int step = 0; step < 3; ++step) {
    const Doubles t2 = hn::Mul(t, t);
    const Doubles value = hn::Sub(hn::Mul(t, hn::Sub(t2, three)), two_s);
    t = hn::Sub(t, hn::Div(value, hn::Mul(three, hn::Sub(t2, Constant(1.0)))));
  }
  // (t^3 - 3 t - 2 s) / (t - t0) = t^2 + t0 t + t0^2 - 3.
  const Doubles two = Constant(2.0);
  const Doubles squared_gap = hn::Mul(three, hn::Mul(hn::Sub(two, t), hn::Add(two, t)));
  const Doubles half_gap = hn::Mul(Constant(0.5), hn::Sqrt(hn::Max(squared_gap, Constant(0.0))));
  const Doubles center = hn::Mul(Constant(-0.5), t);
  const Roots roots{hn::Sub(center, half_gap), hn::Add(center, half_gap), t};
  const auto mirrored = hn::Lt(r, Constant(0.0));
  return {hn::IfThenElse(mirrored, hn::Neg(roots.high), roots.low),
          hn::IfThenElse(mirrored, hn::Neg(roots.middle), roots.middle),
          hn::IfThenElse(mirrored, hn::Neg(roots.low), roots.high)};
}

/// With A = q I + p B, trace B = 0 and |B|^2 = 6: eigenvalues q + p t, where t^3 - 3 t = det B.
HWY_INLINE Roots Eigenvalues(const Matrix& m) {
  const Doubles zero = Constant(0.0);
  const Doubles q = hn::Mul(hn::Add(hn::Add(m.xx, m.yy), m.zz), Constant(1.0 / 3.0));
  const Vector diagonal{hn::Sub(m.xx, q), hn::Sub(m.yy, q), hn::Sub(m.zz, q)};
  const Vector off{m.xy, m.xz, m.yz};
  const Doubles off_squared = Dot(off, off);
  const Doubles p = hn::Sqrt(hn::Mul(
      hn::Add(Dot(diagonal, diagonal), hn::Add(off_squared, off_squared)), Constant(1.0 / 6.0)));
  const Doubles scale = hn::IfThenElseZero(
      hn::Gt(p, zero), hn::Div(Constant(1.0), hn::IfThenElse(hn::Gt(p, zero), p, Constant(1.0))));
  const Doubles xx = hn::Mul(diagonal.x, scale), yy = hn::Mul(diagonal.y, scale);
  const Doubles zz = hn::Mul(diagonal.z, scale), xy = hn::Mul(m.xy, scale);
  const Doubles xz = hn::Mul(m.xz, scale), yz = hn::Mul(m.yz, scale);
  const Doubles determinant = Dot({xx, xy, xz}, Cross({xy, yy, yz}, {xz, yz, zz}));
  const Doubles r =
      hn::Min(hn::Max(hn::Mul(Constant(0.5), determinant), Constant(-1.0)), Constant(1.0));
  const Roots t = CubicRoots(r);
  return {hn::Add(q, hn::Mul(p, t.low)), hn::Add(q, hn::Mul(p, t.middle)),
          hn::Add(q, hn::Mul(p, t.high))};
}

/// `eigenvalues`: columns, ascending.
void AllEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues) {
  const Tag d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Roots roots = Eigenvalues(LoadMatrix(matrices, i));
    hn::StoreU(roots.low, d, eigenvalues[0] + i);
    hn::StoreU(roots.middle, d, eigenvalues[1] + i);
    hn::StoreU(roots.high, d, eigenvalues[2] + i);
  }
}

HWY_INLINE void KeepLonger(const Vector& other, Vector* best, Doubles* best_squared) {
  const Doubles squared = Dot(other, other);
  const auto longer = hn::Gt(squared, *best_squared);
  *best = {hn::IfThenElse(longer, other.x, best->x), hn::IfThenElse(longer, other.y, best->y),
           hn::IfThenElse(longer, other.z, best->z)};
  *best_squared = hn::IfThenElse(longer, squared, *best_squared);
}

/// `directions`: columns of their axes and of their certainty.
void AllLeastDirections(const double* const* matrices, std::size_t count,
                        double* const* directions) {
  const Tag d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Matrix m = LoadMatrix(matrices, i);
    const Doubles low = Eigenvalues(m).low;
    const Vector a{hn::Sub(m.xx, low), m.xy, m.xz};
    const Vector b{m.xy, hn::Sub(m.yy, low), m.yz};
    const Vector c{m.xz, m.yz, hn::Sub(m.zz, low)};
    Vector best = Cross(a, b);
    Doubles best_squared = Dot(best, best);
    KeepLonger(Cross(a, c), &best, &best_squared);
    KeepLonger(Cross(b, c), &best, &best_squared);
    const Doubles length = hn::Sqrt(best_squared);
    const Doubles trace = hn::Add(hn::Add(m.xx, m.yy), m.zz);
    hn::StoreU(hn::Div(best.x, length), d, directions[0] + i);
    hn::StoreU(hn::Div(best.y, length), d, directions[1] + i);
    hn::StoreU(hn::Div(best.z, length), d, directions[2] + i);
    hn::StoreU(hn::Div(length, hn::Mul(trace, trace)), d, directions[3] + i);
  }
}

}  // namespace
}  // namespace backsight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(AllEigenvalues);
HWY_EXPORT(AllLeastDirections);

void FindEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues) {
  HWY_DYNAMIC_DISPATCH(AllEigenvalues)(matrices, count, eigenvalues);
}

void FindLeastDirections(const double* const* matrices, std::size_t count,
                         double* const* directions) {
  HWY_DYNAMIC_DISPATCH(AllLeastDirections)(matrices, count, directions);
}

}  // namespace backsight
#endif
