#pragma once

#include <span>
#include <vector>

#include "core/option_visitor.h"
#include "graph/pose_graph.h"

namespace backsight {

struct NetworkOptions {
  bool robust = true;
  double floor_rotation_deg = 0.003;  ///< systematic error of any link, per axis
  double floor_translation_m = 0.001;
};
void VisitOptions(OptionVisitor& visitor, NetworkOptions& options);

/// An accepted pair as it enters the network. Instrument frames.
struct NetworkLink {
  int source = 0;
  int target = 0;
  RigidTransform target_from_source;
  Matrix6d information = Matrix6d::Zero();  ///< formal, from the registration
  double confidence = 0.0;                  ///< planes times overlap; chooses the spanning tree
};

struct NetworkResult {
  PoseGraphResult poses;
  /// Square root of the links' variance factor: by how much they disagree beyond their formal
  /// errors; at least 1. It is in the covariances.
  double sigma_factor = 1.0;
  int redundancy = 0;                 ///< observations minus unknowns, used links
  std::vector<bool> loop_controlled;  ///< per link: lies on a loop of used links
  std::vector<Vector6d> residuals;    ///< per link, LinkResidual
};

/// Fuses the accepted pairs to one pose per station (survey frame of each component: the instrument
/// frame of its first station). The links' scale of error is estimated from their own disagreement
/// before false ones are sought, so that neither dense nor thin scans mistake noise for falsehood.
NetworkResult SolveNetwork(int stations, std::span<const NetworkLink> links,
                           const NetworkOptions& options);

}  // namespace backsight
