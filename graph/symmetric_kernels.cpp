#include "graph/symmetric_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/symmetric_kernels.cpp"
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

/// Unit eigenvector of the eigenvalue that lies apart from both others, two unit vectors across it,
/// and what the matrix does across it: [[uu, uw], [uw, ww]].
struct Split {
  hn::Mask<Tag> is_low;  // of the three eigenvalues it is the smallest, otherwise the greatest
  Doubles apart;
  Vector axis, u, w;
  Doubles mean, half_difference, uw, radius;  // eigenvalues across: mean -+ radius
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

HWY_INLINE Vector Scaled(const Vector& a, Doubles scale) {
  return {hn::Mul(a.x, scale), hn::Mul(a.y, scale), hn::Mul(a.z, scale)};
}

HWY_INLINE Vector Select(hn::Mask<Tag> first, const Vector& a, const Vector& b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.y, b.y),
          hn::IfThenElse(first, a.z, b.z)};
}

HWY_INLINE Vector Times(const Matrix& m, const Vector& a) {
  return {Dot({m.xx, m.xy, m.xz}, a), Dot({m.xy, m.yy, m.yz}, a), Dot({m.xz, m.yz, m.zz}, a)};
}

/// a / |a|, or the x axis where a is 0.
HWY_INLINE Vector Normalized(const Vector& a) {
  const Doubles squared = Dot(a, a);
  const auto is_zero = hn::Eq(squared, Constant(0.0));
  const Doubles length = hn::IfThenElse(is_zero, Constant(1.0), hn::Sqrt(squared));
  const Doubles scale = hn::Div(Constant(1.0), length);
  return {hn::IfThenElse(is_zero, Constant(1.0), hn::Mul(a.x, scale)), hn::Mul(a.y, scale),
          hn::Mul(a.z, scale)};
}

/// The greatest root of t^3 - 3 t - 2 s = 0 for s in [0, 1], which is 2 cos(arccos(s) / 3). It lies
/// in [sqrt(3), 2] and at least sqrt(3) apart from the others.
HWY_INLINE Doubles GreatestRoot(Doubles s) {
  const Doubles three = Constant(3.0);
  const Doubles two_s = hn::Add(s, s);
  // A parabola that is off by less than 1e-3; each step squares the error.
  Doubles t =
      hn::Add(Constant(1.7326), hn::Mul(s, hn::Sub(Constant(0.321), hn::Mul(s, Constant(0.054)))));
  for (int step = 0; step < 3; ++step) {
    const Doubles t2 = hn::Mul(t, t);
    const Doubles value = hn::Sub(hn::Mul(t, hn::Sub(t2, three)), two_s);
    t = hn::Sub(t, hn::Div(value, hn::Mul(three, hn::Sub(t2, Constant(1.0)))));
  }
  return t;
}

/// Null vector of B - t I: orthogonal to its rows. The longest cross product of two is the safest.
HWY_INLINE Vector NullVector(const Matrix& b, Doubles t) {
  const Vector rows[3] = {{hn::Sub(b.xx, t), b.xy, b.xz},
                          {b.xy, hn::Sub(b.yy, t), b.yz},
                          {b.xz, b.yz, hn::Sub(b.zz, t)}};
  Vector best = Cross(rows[0], rows[1]);
  for (const Vector& other : {Cross(rows[0], rows[2]), Cross(rows[1], rows[2])}) {
    best = Select(hn::Gt(Dot(other, other), Dot(best, best)), other, best);
  }
  return Normalized(best);
}

/// With A = q I + p B, trace B = 0 and |B|^2 = 6 the eigenvalues are q + p t where
/// t^3 - 3 t = det B.
HWY_INLINE Split SplitOff(const Matrix& m) {
  const Doubles zero = Constant(0.0), half = Constant(0.5), one = Constant(1.0);
  const Doubles q = hn::Mul(hn::Add(hn::Add(m.xx, m.yy), m.zz), Constant(1.0 / 3.0));
  const Vector diagonal{hn::Sub(m.xx, q), hn::Sub(m.yy, q), hn::Sub(m.zz, q)};
  const Vector off{m.xy, m.xz, m.yz};
  const Doubles off_squared = Dot(off, off);
  const Doubles p = hn::Sqrt(hn::Mul(
      hn::Add(Dot(diagonal, diagonal), hn::Add(off_squared, off_squared)), Constant(1.0 / 6.0)));
  const Doubles scale = hn::Div(one, hn::IfThenElse(hn::Gt(p, zero), p, one));
  const Vector d = Scaled(diagonal, scale);
  const Vector o = Scaled(off, scale);
  const Matrix b{d.x, o.x, o.y, d.y, o.z, d.z};
  const Doubles half_determinant =
      hn::Mul(half, Dot({b.xx, b.xy, b.xz}, Cross({b.xy, b.yy, b.yz}, {b.xz, b.yz, b.zz})));
  Split split;
  split.is_low = hn::Lt(half_determinant, zero);
  const Doubles greatest = GreatestRoot(hn::Min(hn::Abs(half_determinant), one));
  const Doubles t = hn::IfThenElse(split.is_low, hn::Neg(greatest), greatest);
  split.apart = hn::Add(q, hn::Mul(p, t));
  split.axis = NullVector(b, t);
  const Vector& v = split.axis;
  split.u = Normalized(Select(hn::Gt(hn::Abs(v.x), hn::Abs(v.y)), {hn::Neg(v.z), zero, v.x},
                              {zero, v.z, hn::Neg(v.y)}));
  split.w = Cross(v, split.u);
  const Vector along_u = Times(m, split.u);
  const Doubles uu = Dot(split.u, along_u);
  const Doubles ww = Dot(split.w, Times(m, split.w));
  split.uw = Dot(split.w, along_u);
  split.mean = hn::Mul(half, hn::Add(uu, ww));
  split.half_difference = hn::Mul(half, hn::Sub(uu, ww));
  split.radius = hn::Sqrt(
      hn::Add(hn::Mul(split.half_difference, split.half_difference), hn::Mul(split.uw, split.uw)));
  return split;
}

/// Eigenvector of the smaller eigenvalue across: orthogonal to the longer row of
/// [[h + r, uw], [uw, r - h]]; u where both eigenvalues are equal.
HWY_INLINE Vector LowAcross(const Split& s) {
  const auto first = hn::Gt(s.half_difference, Constant(0.0));
  const Doubles longer = hn::Add(s.radius, hn::Abs(s.half_difference));
  const auto equal = hn::Eq(longer, Constant(0.0));
  const Doubles along_u =
      hn::IfThenElse(equal, Constant(1.0), hn::IfThenElse(first, hn::Neg(s.uw), longer));
  const Doubles along_w = hn::IfThenElse(first, longer, hn::Neg(s.uw));
  return Normalized({hn::Add(hn::Mul(along_u, s.u.x), hn::Mul(along_w, s.w.x)),
                     hn::Add(hn::Mul(along_u, s.u.y), hn::Mul(along_w, s.w.y)),
                     hn::Add(hn::Mul(along_u, s.u.z), hn::Mul(along_w, s.w.z))});
}

/// Columns, ascending.
HWY_INLINE void StoreEigenvalues(const Split& s, std::size_t i, double* const* eigenvalues) {
  const Tag d;
  const Doubles low = hn::Sub(s.mean, s.radius);
  const Doubles high = hn::Add(s.mean, s.radius);
  hn::StoreU(hn::IfThenElse(s.is_low, s.apart, low), d, eigenvalues[0] + i);
  hn::StoreU(hn::IfThenElse(s.is_low, low, high), d, eigenvalues[1] + i);
  hn::StoreU(hn::IfThenElse(s.is_low, high, s.apart), d, eigenvalues[2] + i);
}

/// Columns of x, y and z.
HWY_INLINE void StoreLeastDirections(const Split& s, std::size_t i, double* const* directions) {
  const Tag d;
  const Vector direction = Select(s.is_low, s.axis, LowAcross(s));
  hn::StoreU(direction.x, d, directions[0] + i);
  hn::StoreU(direction.y, d, directions[1] + i);
  hn::StoreU(direction.z, d, directions[2] + i);
}

void AllEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(Tag())) {
    StoreEigenvalues(SplitOff(LoadMatrix(matrices, i)), i, eigenvalues);
  }
}

void AllLeastDirections(const double* const* matrices, std::size_t count,
                        double* const* directions) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(Tag())) {
    StoreLeastDirections(SplitOff(LoadMatrix(matrices, i)), i, directions);
  }
}

void Both(const double* const* matrices, std::size_t count, double* const* eigenvalues,
          double* const* directions) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(Tag())) {
    const Split s = SplitOff(LoadMatrix(matrices, i));
    StoreEigenvalues(s, i, eigenvalues);
    StoreLeastDirections(s, i, directions);
  }
}

}  // namespace
}  // namespace backsight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(AllEigenvalues);
HWY_EXPORT(AllLeastDirections);
HWY_EXPORT(Both);

void FindEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues) {
  HWY_DYNAMIC_DISPATCH(AllEigenvalues)(matrices, count, eigenvalues);
}

void FindLeastDirections(const double* const* matrices, std::size_t count,
                         double* const* directions) {
  HWY_DYNAMIC_DISPATCH(AllLeastDirections)(matrices, count, directions);
}

void FindEigenvaluesAndDirections(const double* const* matrices, std::size_t count,
                                  double* const* eigenvalues, double* const* directions) {
  HWY_DYNAMIC_DISPATCH(Both)(matrices, count, eigenvalues, directions);
}

}  // namespace backsight
#endif
