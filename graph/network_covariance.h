#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// Joint covariance of all poses, 6 rows per station in Retract's convention: the inverse of the
/// Gauss-Newton matrix of the links with positive weight, in the datum of `fixed` stations (theirs
/// are zero; between components it is zero too). Every component must hold a fixed station. Memory
/// (6 stations)^2 doubles, time O(stations^3): about 10 s and 72 MB for 500 stations.
Eigen::MatrixXd JointCovariance(std::span<const PoseGraphLink> links,
                                const std::vector<double>& weights, const std::vector<char>& fixed,
                                std::span<const RigidTransform> poses);

/// A joint covariance after all poses were moved by `to_frame` from the left.
Eigen::MatrixXd InFrame(const RigidTransform& to_frame, const Eigen::MatrixXd& joint);

/// Covariance of target_from_source between any two stations of one component, from the joint one:
/// a change of the poses by xi_s and xi_t changes it by Ad(target_from_survey) (xi_s - xi_t).
Matrix6d RelativeCovariance(const Eigen::MatrixXd& joint, int source, int target,
                            const RigidTransform& survey_from_target);

/// What the network knows least: the direction of largest variance of all station positions and
/// turns, the turns scaled by `lever` so that both are lengths.
struct WeakestDirection {
  double sigma_m = 0.0;      ///< standard deviation along the unit direction over all stations
  int station = -1;          ///< that it moves most; -1: nothing is free
  double station_m = 0.0;    ///< sigma of this station's position under it
  double station_deg = 0.0;  ///< sigma of this station's rotation under it
  double lever_m = 1.0;      ///< the median length of the links
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< survey frame, along which that station moves
};

/// By power iteration on the joint covariance, carried to the stations' own positions. Time
/// O(iterations * stations^2).
WeakestDirection FindWeakestDirection(const Eigen::MatrixXd& joint,
                                      std::span<const PoseGraphLink> links,
                                      std::span<const RigidTransform> poses);

}  // namespace backsight
