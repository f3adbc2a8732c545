#pragma once

#include <optional>
#include <vector>

#include "pipeline/pair_pipeline.h"
#include "pipeline/survey_options.h"
#include "stages/network_refinement.h"
#include "stages/network_solution.h"
#include "stages/placement_check.h"

namespace backsight {

/// What became of one candidate motion of a pair.
struct NetworkCandidate {
  int pair = 0;
  int candidate = 0;  ///< index into the pair's candidates
  LinkFate fate = LinkFate::kUsed;
  bool refuted = false;  ///< a bridge whose sides contradict each other: taken out before
  bool loop_controlled = false;
  Matrix6d covariance = Matrix6d::Zero();  ///< of target_from_source at the final poses
  /// How far the motion lies from the final poses, in its own standard deviations as the pose graph
  /// takes them, rms over the six; absent where its stations do not stand in one component.
  std::optional<double> residual_sigmas;
  bool used() const { return fate == LinkFate::kUsed && !refuted; }
};

/// A component of two or more stations after the planar adjustment of all of them.
struct NetworkPart {
  std::vector<int> stations;  ///< ascending; the first is the datum
  int links = 0;              ///< used ones
  NetworkRefinementResult refinement;
};

/// All stations with a place in the network. Indices are those of the stations; frames are the
/// stations' own and the survey frame of each component (the station frame of its first station).
struct Network {
  NetworkResult solution;  ///< the pose graph, instrument frames
  std::vector<NetworkCandidate> candidates;
  /// Per pair: the candidate it is reported by, the used one if any, otherwise its best; -1: none.
  std::vector<int> reported;
  std::vector<int> component;      ///< by size, 0 the largest; -1: connected with nothing
  std::vector<NetworkPart> parts;  ///< by component
  PlacementCheckResult check;
  std::vector<RigidTransform> survey_from_station;
  std::vector<Matrix6d> covariance;  ///< of survey_from_station, Retract's convention
};

/// Chooses the motions that belong together, adjusts poses and planes, and looks from every station
/// at what the others measured.
Network BuildNetwork(const std::vector<Station>& stations, const std::vector<Pair>& pairs,
                     const SurveyOptions& options, const ExecutionContext& context);

}  // namespace backsight
