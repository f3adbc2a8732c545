#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/rigid_transform.h"
#include "core/voxel_index.h"
#include "stages/surface.h"

namespace backsight {

/// Voxels of a cloud that stand for all of it: whole blocks (cubes of 5 voxels of the station's own
/// lattice), gathered in groups (cubes of 4 blocks). Blocks decide together, so that single leaves
/// do not; groups are about as large as objects, and what is seen of one object is one observation.
struct CloudSample {
  std::vector<std::uint32_t> leaves;    ///< leaf indices, block after block
  std::vector<std::uint32_t> begins;    ///< of each block in `leaves`, and the end of the last
  std::vector<std::uint32_t> groups;    ///< of each block, ascending from 0
  std::vector<Eigen::Vector3d> points;  ///< means of the leaves, in their order

  std::size_t blocks() const { return groups.size(); }
};

/// Whole blocks, evenly chosen, of about `leaves` voxels altogether. O(n log n) for n voxels.
CloudSample SampleCloud(const StationModel& model, std::size_t leaves);

/// What comparisons of a station's cloud with others need, made once per station. Memory: about 16
/// bytes per voxel.
struct CloudIndex {
  explicit CloudIndex(const StationModel& model);

  VoxelIndex voxels;   ///< the leaves by position
  CloudSample sieve;   ///< about 1,500 voxels: for many hypotheses
  CloudSample sample;  ///< about 20,000: for the few that remain
};

/// What the viewer's scanner says of a piece of surface that another scan measured.
enum class Sight {
  kNotInView,    ///< it measured nothing in that direction
  kHidden,       ///< all it measured there lies in front
  kAgrees,       ///< it measured something at that range
  kSeenThrough,  ///< all it measured there lies clearly behind
  kUnclear,      ///< in front and behind: an edge; or behind by what a grazing surface varies
};

/// Ranges that differ by less are of one surface.
struct SightTolerance {
  double voxels = 3.0;  ///< in l of the viewer
  /// And what a surface at the point's incidence varies over so many pixels; the default is the
  /// reach of a window of three by three.
  double pixels = 1.5;
};

/// `point` and `normal` in the viewer's frame; the normal may be NaN. Compares the point's range
/// with those in three by three pixels; the tolerance is at most 1 m, except that a surface counts
/// as seen through only beyond all that it varies at its incidence.
Sight LookAt(const StationModel& viewer, const Eigen::Vector3d& point,
             const Eigen::Vector3f& normal, const SightTolerance& tolerance = {});
/// The same where the window about the point is known.
Sight LookAt(const StationModel& viewer, const RangeImage::Window& window,
             const Eigen::Vector3d& point, const Eigen::Vector3f& normal,
             const SightTolerance& tolerance);

/// A ratio of sums over groups, with the standard deviation that the groups' scatter gives it.
struct RatioEstimate {
  double value = 0.0;
  double sigma = 0.0;
};

/// Fewer blocks in a scanner's view say nothing of what it saw through.
inline constexpr int kFewestBlocksInView = 50;

/// How a moved cloud fits what another station measured.
struct CloudAgreement {
  /// Share of the voxels that fall into or beside an occupied voxel that does not face away.
  double overlap = 0.0;
  double score = 0.0;  ///< share that lies on a surface of like normal, each by its distance
  /// Of the blocks in view, the share that was seen through. 0 where the scanner is not credible.
  RatioEstimate conflict;
  int blocks_in_view = 0;
  /// Of the voxels that meet a surface or were seen through: score minus seen through, per voxel.
  RatioEstimate quality;
};

/// The score of CompareClouds alone, in about a third of the time.
double ScoreClouds(const Surface& moved, const CloudSample& sample, const Surface& reference,
                   const CloudIndex& reference_index, const RigidTransform& reference_from_moved,
                   double tolerance_m);

/// `tolerance_m`: distance from the surface at which a voxel's score reaches 0. A block is seen
/// through where more of its voxels are than agree, and at least four. About 1 us per voxel.
CloudAgreement CompareClouds(const Surface& moved, const CloudSample& sample,
                             const Surface& reference, const CloudIndex& reference_index,
                             const RigidTransform& reference_from_moved, double tolerance_m);

}  // namespace backsight
