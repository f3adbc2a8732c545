#pragma once

#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "graph/plane_tree.h"
#include "stages/cloud_agreement.h"
#include "stages/station_model.h"
#include "stages/surface.h"

namespace backsight {

struct FineOptions {
  int activation = 0;         ///< 0 overlap, 1 micro
  double root_edge = 8.0;     ///< lattice cells the plane search starts from, voxels
  double micro_radius = 5.0;  ///< micro: cells within this distance of C3, voxels
  int rounds = 3;             ///< associations, each with half the tolerances of the last
  double max_thickness_m = 0.03;
  double max_thinness = 0.0625;
  int min_planes = 8;
  double effective_points = 50.0;  ///< cap on a cluster's weight
  int anderson_window = 5;
  bool surfaces = true;  ///< let surfaces that no plane covers take part at the end
};
void VisitOptions(OptionVisitor& visitor, FineOptions& options);

struct FineResult {
  enum class Status {
    kRefined,            ///< planes determine all six degrees of freedom
    kRefinedOnSurfaces,  ///< planes are too few; pairs of voxels determine them
    kWeak,               ///< refined, but one direction to no better than 5 mm
    kTooFewPlanes,       ///< neither planes nor surfaces suffice: coarse transform returned
    kDiverged,           ///< left the coarse result by more than it can be wrong: coarse returned
  };
  Status status = Status::kTooFewPlanes;
  RigidTransform target_from_source;        ///< T_f
  Matrix6d information = Matrix6d::Zero();  ///< Retract's convention
  int planes = 0;
  double rms_m = 0.0;            ///< point to plane, over all adjusted planes; 0 without
  double weakest_sigma_m = 0.0;  ///< of the least determined direction, balanced; 100 m at most
  Vector6d weakest_direction = Vector6d::Zero();  ///< unit, rotation scaled by the lever arm
  double eigenvalue_ratio = 0.0;  ///< smallest to largest, of the balanced information
  int surface_matches = 0;        ///< pairs of voxels, where planes were too few
  int iterations = 0;
  int anderson_accepted = 0;
};

struct FineInput {
  Surface source;
  Surface target;
  const CloudIndex& target_index;                 ///< of the target's model
  RigidTransform target_from_source;              ///< T_c
  Matrix6d information = Matrix6d::Zero();        ///< of T_c
  std::vector<Eigen::Vector3d> structure_points;  ///< target points of C3, for activation micro
  /// What the target has in the cells that planes are sought in (MakePlaneTree); null: it is made
  /// for this pair alone. Activation micro does not look at it.
  const PlaneTree* target_planes = nullptr;
  /// The source's voxels that stand for its surfaces (ChooseSurfaces of kRefinedSurfaces); null:
  /// they are chosen for this pair alone.
  const std::vector<std::uint32_t>* source_surfaces = nullptr;
};

/// What pairs need of their target alone, made once for all of them: its dominant directions, and
/// what it has in the cells of a lattice along them. Some 10 ms; memory 64 bytes per cell with
/// points enough: some 8 bytes per voxel of thinned scans, up to some 80 where every voxel holds
/// dozens of points.
PlaneTree MakePlaneTree(const Surface& target, const FineOptions& options);

/// Planar adjustment of one pair (paper section III-E on voxel clusters): finds planes seen by both
/// stations, adjusts, associates anew, and lets all surfaces take part at last. Where planes are
/// too few, pairs of voxels determine the motion. Instrument frames. Never NaN: where neither
/// suffices the coarse transform stands and the status says so.
FineResult RefinePair(const FineInput& input, const FineOptions& options,
                      const ExecutionContext& context);

}  // namespace backsight
