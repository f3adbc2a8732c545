#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/plane_rules.h"

namespace backsight {

/// One plane's points as one station saw them: their cluster in that station's frame.
struct PlaneObservation {
  int station = 0;  ///< index into the poses
  PointCluster cluster;
};

/// Decides which stations see one plane in a cell and agree on it. Keeps its memory from cell to
/// cell.
class PlaneJudge {
 public:
  /// Both must outlive it.
  PlaneJudge(const PlaneSearchOptions& options, std::span<const RigidTransform> poses)
      : options_(options), poses_(poses) {}

  /// A new cell, which no station has anything in yet.
  void Clear() { stations_.clear(), locals_.clear(); }
  /// What a station has in it, in its own frame.
  void Add(std::uint32_t station, const PointCluster& local) {
    stations_.push_back(station), locals_.push_back(local);
  }
  std::size_t size() const { return stations_.size(); }

  /// Whether at least two see one plane and agree on it; `observations` are theirs, then.
  bool Judge(std::vector<PlaneObservation>* observations);

 private:
  void Erase(std::size_t i);
  void KeepPlanar();
  double Disagreement(std::size_t i, const PointCluster& joint, const PlaneFit& fit) const;

  const PlaneSearchOptions& options_;
  std::span<const RigidTransform> poses_;
  std::vector<std::uint32_t> stations_;
  std::vector<PointCluster> locals_;
  std::vector<PointCluster> world_;
  std::vector<PlaneFit> fits_;
};

}  // namespace backsight
