#pragma once

#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/matching.h"

namespace backsight {

/// PCL's way from descriptors and clouds to motions, one thread; what the benchmarks compare with.

/// Mutual k nearest neighbours with KdTreeFLANN, both trees built anew; order as MatchDescriptors.
std::vector<DescriptorMatch> PclMatches(std::span<const FpfhDescriptor> source,
                                        std::span<const FpfhDescriptor> target, int neighbors);

/// SampleConsensusPrerejective on key points: target from source.
RigidTransform PclPrerejective(std::span<const Eigen::Vector3d> source,
                               std::span<const FpfhDescriptor> source_descriptors,
                               std::span<const Eigen::Vector3d> target,
                               std::span<const FpfhDescriptor> target_descriptors,
                               double resolution_m);

/// Generalised ICP from `start`; correspondences within `reach_m`.
RigidTransform PclGicp(std::span<const Eigen::Vector3d> source,
                       std::span<const Eigen::Vector3d> target, const RigidTransform& start,
                       double reach_m);

/// Point-to-plane ICP (linear least squares) from `start` with the target's normals.
RigidTransform PclPointToPlane(std::span<const Eigen::Vector3d> source,
                               std::span<const Eigen::Vector3d> target,
                               std::span<const Eigen::Vector3f> target_normals,
                               const RigidTransform& start, double reach_m);

}  // namespace backsight
