#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace backsight {

/// Rows as offsets from an edge's first row, one column per coordinate, readable kTurnPadding
/// entries beyond `count`.
struct OffsetColumns {
  std::array<const double*, 3> source;
  std::array<const double*, 3> target;
  std::size_t count;
};
inline constexpr std::size_t kTurnPadding = 8;

/// An edge that was moved onto its target: its direction in both clouds, and two across it, such
/// that the source's come to lie on the target's.
struct EdgeFrame {
  using Axis = std::array<double, 3>;
  Axis source_along, source_u, source_v;
  Axis target_along, target_u, target_v;
  double shift_m;  ///< of the source along the edge, which centres the length difference
};

/// For every row that lies alike with respect to the edge and that some rotation about it brings
/// within `limit_m` of its target, its place in the columns and the arc of these rotations
/// (TurnArc). Lie alike: distance from the edge's first row, and signed projection on the edge,
/// differ by less than the limit. Ascending; outputs have room for `count`. Returns their number.
/// The same bits on every instruction set.
std::size_t FindTurns(const OffsetColumns& rows, const EdgeFrame& edge, double limit_m,
                      std::uint32_t* places, double* begins, double* ends);

}  // namespace backsight
