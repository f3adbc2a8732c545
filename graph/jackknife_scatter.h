#pragma once

#include <Eigen/Core>
#include <span>

#include "core/execution.h"
#include "graph/block_equations.h"

namespace backsight {

/// Scatter of the blocks' pulls on the poses, sum over the blocks of p p^T with p = (I - H C)^-1 g:
/// C p is the step that the poses take where the block is left out. So C scatter C is the
/// jackknife's covariance of the poses (Tukey 1958; for blocks: CR3 in Cameron and Miller 2015, doi
/// 10.3368/jhr.50.2.317), blocks being independent of each other but not within. Where a block
/// holds more than three quarters of a motion it counts as holding that much: what it has wrong
/// there no other block tells, and the step without it may be any. g and H are a block's gradient
/// and exact curvature, that of planes times `slope`; C the inverse of the curvature of all blocks
/// and of whatever else there is, definite but for the fixed first station's zeros. Full size.
/// Byte-identical for any number of threads.
Eigen::MatrixXd JackknifeScatter(const BlockMembers& members, std::span<const RigidTransform> poses,
                                 double slope, const Eigen::MatrixXd& covariance,
                                 const ExecutionContext& context);

}  // namespace backsight
