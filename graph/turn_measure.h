#pragma once

#include <cmath>
#include <cstdint>

namespace backsight {

/// Angles of rotation in a measure that needs no arc tangent and keeps their order: a direction's
/// place on the diamond |x| + |y| = 1, from 0 to 4 in a full turn, at most 1 per radian.
inline constexpr double kFullTurn = 4.0;

/// Of the direction (x, y), not both 0: in [0, kFullTurn].
inline double TurnOf(double x, double y) {
  const double p = y / (std::abs(x) + std::abs(y));
  if (x < 0.0) return 2.0 - p;
  return p < 0.0 ? kFullTurn + p : p;
}

/// Radians, in [0, 2 pi], of a turn in [0, kFullTurn].
double AngleOf(double turn);

/// The turns from `begin`, in [0, kFullTurn), to `end`, no less and no more than a full turn on:
/// all under which key point `id` is satisfied.
struct TurnArc {
  double begin = 0.0;
  double end = 0.0;
  std::uint32_t id = 0;
};

/// Whether a turn in [0, kFullTurn] lies in the arc, ends included.
inline bool Contains(const TurnArc& arc, double turn) {
  const int after_begin = turn >= arc.begin ? 1 : 0;
  const int before_end = turn <= arc.end ? 1 : 0;
  const int once_more = turn + kFullTurn <= arc.end ? 1 : 0;
  return ((after_begin & before_end) | once_more) != 0;  // without branches
}

}  // namespace backsight
