#include "graph/turn_measure.h"

#include <numbers>

namespace backsight {

double AngleOf(double turn) {
  if (turn >= kFullTurn) return 2.0 * std::numbers::pi;
  const double y = turn < 1.0 ? turn : turn < 3.0 ? 2.0 - turn : turn - kFullTurn;
  const double x = turn < 1.0 || turn > 3.0 ? 1.0 - std::abs(y) : std::abs(y) - 1.0;
  const double angle = std::atan2(y, x);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

}  // namespace backsight
