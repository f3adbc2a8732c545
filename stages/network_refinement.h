#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "graph/pose_graph.h"
#include "stages/held_out_planes.h"
#include "stages/network_precision.h"
#include "stages/station_model.h"

namespace backsight {

struct NetworkRefinementOptions {
  bool enabled = true;
  double root_edge = 8.0;  ///< lattice cells the plane search starts from, voxels
  int max_rounds = 6;      ///< associations; tolerances halve down to a floor
  double max_thickness_m = 0.03;
  double max_thinness = 0.0625;
  int min_planes = 8;              ///< in the network, and for a link to be left to the planes
  double effective_points = 50.0;  ///< cap on the weight of one station's part of a plane
  double held_out_share = 0.1;     ///< of the planes, never adjusted
  int anderson_window = 5;         ///< 0 switches the acceleration off
  bool surfaces = true;            ///< let what no plane covers take part
  double floor_rotation_deg = 0.0;
  double floor_translation_m = 0.0;
};
void VisitOptions(OptionVisitor& visitor, NetworkRefinementOptions& options);

/// One connected component. Instrument frames; the first station is the datum.
struct NetworkRefinementInput {
  std::vector<const StationModel*> stations;
  std::vector<RigidTransform> survey_from_station;  ///< from the pose graph
  std::vector<Matrix6d> covariance;                 ///< of these, Retract's convention
  std::vector<PoseGraphLink> links;                 ///< used ones; indices into `stations`
  /// Empty (curved and small surfaces take no part), or one per station: normals of its leaves.
  std::vector<const std::vector<Eigen::Vector3f>*> normals;
  /// Empty, or one per station: standard deviation of the levelling of its z axis, per axis.
  std::vector<std::optional<double>> level_sigma_rad;
};

/// One association and its adjustment.
struct RefinementRound {
  int planes = 0;  ///< adjusted ones
  int observations = 0;
  int surface_matches = 0;      ///< voxels that no plane covers
  int iterations = 0;           ///< of Levenberg-Marquardt
  int anderson_accepted = 0;    ///< proposals within it
  bool anderson_start = false;  ///< it began at the proposal of the rounds before
  double cost_before = 0.0;
  double cost_after = 0.0;
  double largest_move_m = 0.0;  ///< of a station's surroundings
};

struct NetworkRefinementResult {
  enum class Status {
    kRefined,
    kTooFewPlanes,   ///< the start poses stand
    kKeptPoseGraph,  ///< the start poses stand, `reason` says why
  };
  enum class Reason {
    kNone,
    kCostDidNotFall,
    kStationMovedTooFar,  ///< more than 5 sigma of the pose graph and 4 voxels: `station`
    kHeldOutPlanesWorse,
    kNotFinite,
  };
  Status status = Status::kTooFewPlanes;
  Reason reason = Reason::kNone;
  int station = -1;                                 ///< the one the reason is about
  std::vector<RigidTransform> survey_from_station;  ///< identity for the first
  /// 6M x 6M, left perturbations of survey_from_station in Retract's convention; zero for the
  /// first.
  Eigen::MatrixXd covariance;
  double sigma0_m = 0.0;          ///< patches' own thickness, median over the planes
  double agreement_factor = 1.0;  ///< of the patches' disagreement, formal variance 1
  double variance_factor = 1.0;   ///< of most motions; single ones may have more
  double surface_factor = 1.0;    ///< variance of surfaces' formal errors over that of planes'
  double block_m = 0.0;           ///< edge of the blocks it was found at; 0 where nothing scatters
  int planes = 0;                 ///< last round
  int observations = 0;
  std::vector<int> planes_of_station;  ///< last round
  std::vector<RefinementRound> rounds;
  WeakestMotion weakest;
  std::vector<HeldOutPair> held_out;  ///< ascending station pairs
};

/// Planar adjustment of all stations at once (docs/stages/network_refinement.md). Never throws for
/// lack of planes and never returns NaN. Time: linear in voxels per round, and per
/// Levenberg-Marquardt step linear in observations plus (6 M)^3 / 3. Memory: 16 bytes per voxel
/// that another station sees too, the planes, and a few 6M x 6M matrices. Byte-identical for any
/// number of threads.
NetworkRefinementResult RefineNetwork(const NetworkRefinementInput& input,
                                      const NetworkRefinementOptions& options,
                                      const ExecutionContext& context);

}  // namespace backsight
