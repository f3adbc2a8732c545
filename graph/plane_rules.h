#pragma once

#include <algorithm>
#include <cmath>

#include "core/point_cluster.h"
#include "graph/plane_fit.h"

namespace backsight {

/// Adaptive octree plane search on clusters (docs/stages/fine_registration.md; the paper leaves its
/// details open). A lattice cell is split until what each station has in it is one thin plane and
/// the stations agree on it.
struct PlaneSearchOptions {
  double root_edge_m = 0.8;        ///< edge of the lattice cells the search starts from
  int max_depth = 3;               ///< how often a cell may be split
  double min_points = 15.0;        ///< raw points a station needs in a cell
  int min_clusters = 8;            ///< or voxels, where the scan is thinner than that
  double max_thinness = 1.0 / 16;  ///< smallest over middle eigenvalue of the covariance
  double min_width = 0.02;         ///< middle over largest eigenvalue: a plane, not a line
  double max_thickness_m = 0.03;   ///< standard deviation across the plane, per station
  double max_angle_rad = 0.175;    ///< between a station's normal and the joint one
  double max_offset_m = 0.1;       ///< of a station's centroid from the joint plane
};

/// What the stations' patches may differ by in the `round`-th search, from 0: half as much as in
/// the one before, down to what noise may do.
inline void NarrowTolerances(double resolution_m, int round, PlaneSearchOptions* options) {
  const double tolerance = std::pow(0.5, round);
  options->max_angle_rad = std::max(0.175 * tolerance, 0.05);
  options->max_offset_m = std::max(resolution_m * tolerance, 0.03);
}

/// Whether a station has enough in a cell: points, or voxels.
inline bool HasEnough(double points, int clusters, const PlaneSearchOptions& options) {
  return points >= options.min_points || clusters >= options.min_clusters;
}

/// Whether what one station has in a cell is one thin plane.
inline bool IsPlanar(const PlaneFit& fit, const PlaneSearchOptions& options) {
  const Eigen::Vector3d& e = fit.eigenvalues;
  return e[0] < options.max_thinness * e[1] && e[1] > options.min_width * e[2] &&
         std::sqrt(std::max(e[0], 0.0)) < options.max_thickness_m;
}

}  // namespace backsight
