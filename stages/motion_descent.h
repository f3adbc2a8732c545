#pragma once

#include "core/rigid_transform.h"

namespace backsight {

/// Normal equations of pairs of points under a motion, xi about the target's origin.
struct MotionEquations {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  int matches = 0;  ///< pairs
};

struct MotionDescent {
  RigidTransform target_from_source;  ///< the start where too few pairs matched
  int matches = 0;                    ///< pairs in the last iteration
  bool has_enough = true;             ///< at least 100 in every iteration
};

/// The step that the equations ask for, given where it starts; not finite where they are singular.
Vector6d MotionStep(const MotionEquations& equations, const Matrix6d& prior,
                    const Vector6d& from_start);

/// Gauss-Newton steps from `start` on the pairs' cost and 0.5 r^T prior r, r = LocalDifference(T,
/// start), until they are below 1e-6 rad and m or `max_iterations` were made.
/// `equations_at(motion)` returns the MotionEquations of the pairs that match under a motion.
template <class EquationsAt>
MotionDescent Descend(const RigidTransform& start, const Matrix6d& prior, int max_iterations,
                      EquationsAt equations_at) {
  constexpr int kFewestMatches = 100;
  constexpr double kSmallestStep = 1e-6;  // rad and m
  MotionDescent descent{start};
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const RigidTransform& motion = descent.target_from_source;
    const MotionEquations equations = equations_at(motion);
    descent.matches = equations.matches;
    if (equations.matches < kFewestMatches) return {start, equations.matches, false};
    const Vector6d step = MotionStep(equations, prior, LocalDifference(motion, start));
    if (!step.allFinite()) break;
    descent.target_from_source = Retract(motion, step);
    if (step.norm() < kSmallestStep) break;
  }
  return descent;
}

}  // namespace backsight
