#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "graph/plane_segmentation.h"
#include "graph/pose_observations.h"

namespace backsight {

/// A plane in the adjustment: cost weight * lambda_1, the smallest eigenvalue of the covariance of
/// all its points at the current poses, i.e. their mean squared distance from the best plane.
struct WeightedPlane {
  std::vector<PlaneObservation> observations;
  double weight = 1.0;  ///< 1/m^2
};

/// The cluster of all points of a plane at these poses, world.
PointCluster JointCluster(const WeightedPlane& plane, std::span<const RigidTransform> poses);

/// Second derivatives of a plane's cost.
enum class PlaneCurvature {
  kGaussNewton,  ///< never negative, as if the normal at hand were the true one
  /// Of the cost itself, in which the normal follows the patches. Where planes all contain a
  /// direction, the errors of their normals seem to hold patches with their centroids upon each
  /// other: Gauss-Newton takes that for knowledge, the cost itself does not.
  kExact,
};

/// All that is minimised. `context` (may be null: one thread) changes the time, not a bit of the
/// result.
struct PlanarProblem {
  std::span<const WeightedPlane> planes;
  PoseObservations observations;
  const ExecutionContext* context = nullptr;
  /// A station whose rows and columns nobody needs: planes leave them zero. -1: none.
  int unneeded_station = -1;
  PlaneCurvature curvature = PlaneCurvature::kGaussNewton;
};

/// One plane's part of the normal equations with the plane itself eliminated. The block of its
/// observations i and j is (i == j ? held_i : 0) - coupling_i * coupling_j^T.
struct PlaneTerms {
  struct Part {
    int station = 0;
    Vector6d gradient;
    Matrix6d held;                         ///< with the plane held
    Eigen::Matrix<double, 6, 3> coupling;  ///< through the plane's offset and its two tilts
  };
  double cost = 0.0;
  std::vector<Part> parts;  ///< one per observation
};

PlaneTerms ComputePlaneTerms(const WeightedPlane& plane, std::span<const RigidTransform> poses,
                             PlaneCurvature curvature = PlaneCurvature::kGaussNewton);

/// lambda_1 of every plane at `poses` (world_from_station), m^2.
std::vector<double> PlaneThicknesses(std::span<const WeightedPlane> planes,
                                     std::span<const RigidTransform> poses,
                                     const ExecutionContext* context = nullptr);

/// Sum of weight * lambda_1 and the other observations' cost.
double PlanarCost(const PlanarProblem& problem, std::span<const RigidTransform> poses);
double PlanarCost(std::span<const WeightedPlane> planes, std::span<const PosePrior> priors,
                  std::span<const RigidTransform> poses);

/// Cost, gradient and matrix of second derivatives (docs/stages/fine_registration.md, after BALM2's
/// elimination of plane parameters, doi 10.1109/TRO.2023.3335670). The planes' part of the matrix
/// is the Schur complement of the point-to-plane normal matrix after elimination of the planes:
/// always positive semi-definite, and it annihilates a common rigid motion (neither holds of the
/// exact curvature). Dense, 36 M^2 doubles for M stations; time O(observations * stations per
/// plane).
NormalEquations AssembleNormalEquations(const PlanarProblem& problem,
                                        std::span<const RigidTransform> poses);
NormalEquations AssembleNormalEquations(std::span<const WeightedPlane> planes,
                                        std::span<const PosePrior> priors,
                                        std::span<const RigidTransform> poses);

/// AssembleNormalEquations for one set of poses after the other; keeps its memory.
class NormalEquationsAssembler {
 public:
  /// What it returns changes with the next call.
  const NormalEquations& Assemble(const PlanarProblem& problem,
                                  std::span<const RigidTransform> poses);

 private:
  struct Place {
    const PlaneTerms* plane;
    const PlaneTerms::Part* part;
  };
  void AddPlanes(const PlanarProblem& problem, std::span<const WeightedPlane> planes,
                 std::span<const RigidTransform> poses);

  std::vector<PlaneTerms> terms_;
  std::vector<std::vector<Place>> of_station_;
  NormalEquations system_;
};

}  // namespace backsight
