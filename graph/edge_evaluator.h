#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/correspondences.h"
#include "graph/interval_stabbing.h"
#include "graph/pair_columns.h"
#include "graph/rotation_sectors.h"

namespace backsight {

struct EdgeHypothesis {
  RigidTransform target_from_source;
  int consensus = 0;  ///< distinct source key points within 2 l of their target
};

/// Hypotheses that are so close count as one: their rotations, and where they take the centroid.
struct HypothesisNearness {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of the source's nodes
  double angle_rad = 0.0;
  double distance_m = 0.0;

  /// `slack_rad`: how far the one may turn beyond what it is, about an axis `lever_m` from where it
  /// takes the centroid.
  bool IsNear(const RigidTransform& a, const RigidTransform& b, double slack_rad = 0.0,
              double lever_m = 0.0) const {
    return (a * centroid - b * centroid).norm() + lever_m * slack_rad < distance_m &&
           RotationAngle(a.rotation, b.rotation) + slack_rad < angle_rad;
  }
};

/// What is known already: an edge does not matter if all it can say is near one of these that
/// gathers as many.
struct KnownHypotheses {
  std::span<const EdgeHypothesis> hypotheses;  ///< descending consensus
  HypothesisNearness nearness;
};

/// Reliability of edges (paper section III-C) where only those matter that gather more key points
/// than a bar. Bounds from cheap to dear come first: rows that may lie alike with respect to the
/// edge, those that some rotation about the edge can satisfy, and the most that one sector of
/// rotations holds. What the fullest sector's middle gathers, in turn, rules out all sectors that
/// hold less, and so do the key points of all arcs that touch a run of sectors. Rotations are told
/// apart without trigonometry (graph/turn_measure.h). Keeps its memory from edge to edge. Time O(K)
/// per edge that a bound rejects, O(K + n log n) for n rows that pass and O(n) for each of the runs
/// of sectors that may still win, whose sectors are held against each known hypothesis.
class EdgeEvaluator {
 public:
  /// `c` and `columns` (of `c`) must outlive it. `limit_m`: 2 l.
  EdgeEvaluator(const Correspondences& c, const PairColumns& columns, double limit_m,
                const std::optional<UprightConstraint>& upright);

  /// The best motion about the edge from row i to row j; none where it provably gathers no more
  /// than `bar` key points, or is near a known one that gathers no fewer. What it returns may be so
  /// either.
  std::optional<EdgeHypothesis> Evaluate(std::uint32_t i, std::uint32_t j, int bar,
                                         const KnownHypotheses& known = {});

 private:
  struct Edge;
  void CollectArcs(const Edge& edge, std::span<const std::uint32_t> found);
  int CountAt(double turn);
  int DistinctIn(const RotationSectors::Run& run);
  void KeepPromising(std::span<const RotationSectors::Run> runs, int bar);
  bool IsKnown(const Edge& edge, const RotationSectors::Run& run, int most,
               const KnownHypotheses& known) const;
  bool AllKnown(const Edge& edge, const KnownHypotheses& known) const;
  std::optional<EdgeHypothesis> Tight(const Edge& edge, int bar, const KnownHypotheses& known);
  bool LiesAlike(const Edge& edge, std::uint32_t row) const;
  std::optional<EdgeHypothesis> Upright(const Edge& edge, int bar,
                                        std::span<const std::uint32_t> found);
  /// 1 if the key point is met, and for the first time since BeginCount; without branches.
  int IsNewIf(bool met, std::uint32_t keypoint) {
    const std::uint32_t seen = seen_[keypoint];
    seen_[keypoint] = met ? count_ : seen;
    return static_cast<int>(met) & static_cast<int>(seen != count_);
  }
  void BeginCount() { ++count_; }

  const Correspondences& c_;
  const PairColumns& columns_;
  double limit_m_;
  std::optional<UprightConstraint> upright_;
  std::vector<std::uint32_t> keypoint_;  // of each row: its source id, numbered without gaps
  std::vector<std::uint32_t> seen_;      // per key point: the last count that met it
  std::uint32_t count_ = 0;
  std::vector<std::uint32_t> found_;              // rows from the kernel
  std::array<std::vector<double>, 3> in_source_;  // their offsets from the edge's first row
  std::array<std::vector<double>, 3> in_target_;  // likewise
  std::vector<std::uint32_t> places_;             // of those with an arc
  std::vector<double> begins_, ends_;             // of the arcs
  std::vector<TurnArc> arcs_;                     // rotations that satisfy a row
  RotationSectors sectors_;                       // of the arcs
  std::vector<RotationSectors::Run> promising_;   // runs of sectors that may hold more than the bar
  std::vector<int> most_in_;                      // key points whose arcs touch each
  IntervalStabber stabber_;
};

/// How far the columns' single precision may move a length, or a projection, metres.
inline float Slack(const PairColumns& columns) { return columns.extent_m * 0x1p-18F; }

}  // namespace backsight
