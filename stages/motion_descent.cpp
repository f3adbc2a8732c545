#include "stages/motion_descent.h"

#include <Eigen/Cholesky>

namespace backsight {

Vector6d MotionStep(const MotionEquations& equations, const Matrix6d& prior,
                    const Vector6d& from_start) {
  const Matrix6d matrix = equations.matrix + prior;
  return -matrix.ldlt().solve(equations.gradient + prior * from_start);
}

}  // namespace backsight
