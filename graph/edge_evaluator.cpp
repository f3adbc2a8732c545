#include "graph/edge_evaluator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "graph/reliability_kernels.h"
#include "graph/turn_kernels.h"

namespace backsight {
namespace {

/// Ids numbered from 0 without gaps.
std::vector<std::uint32_t> Numbered(const std::vector<std::uint32_t>& ids) {
  std::vector<std::uint32_t> distinct = ids;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  std::vector<std::uint32_t> numbers;
  numbers.reserve(ids.size());
  for (const std::uint32_t id : ids) {
    const auto place = std::lower_bound(distinct.begin(), distinct.end(), id);
    numbers.push_back(static_cast<std::uint32_t>(place - distinct.begin()));
  }
  return numbers;
}

/// The minimal rotation that takes unit vector a to unit vector b, a half turn about any normal
/// axis where they are opposite.
Eigen::Matrix3d MinimalRotation(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return Eigen::Quaterniond::FromTwoVectors(a, b).toRotationMatrix();
}

}  // namespace

/// The edge from row i to row j: both end points and unit directions in both clouds.
struct EdgeEvaluator::Edge {
  Edge(const Correspondences& c, std::uint32_t i, std::uint32_t j)
      : source(c.source[i]),
        target(c.target[i]),
        source_axis((c.source[j] - c.source[i]).normalized()),
        target_axis((c.target[j] - c.target[i]).normalized()),
        middle_shift(
            0.5 * ((c.target[j] - c.target[i]) - (c.source[j] - c.source[i]).norm() * target_axis)),
        align(MinimalRotation(source_axis, target_axis)) {}
  Eigen::Vector3d source, target;            // of row i
  Eigen::Vector3d source_axis, target_axis;  // from i to j
  Eigen::Vector3d middle_shift;              // centres the length difference on both ends
  Eigen::Matrix3d align;                     // takes the source's direction to the target's

  /// As the kernel sees it: across the edge, any two directions of the target.
  EdgeFrame Frame() const {
    const auto axis = [](const Eigen::Vector3d& v) { return EdgeFrame::Axis{v.x(), v.y(), v.z()}; };
    const Eigen::Matrix3d back = align.transpose();
    const Eigen::Vector3d u = target_axis.unitOrthogonal();
    const Eigen::Vector3d v = target_axis.cross(u);
    return {axis(source_axis),
            axis(back * u),
            axis(back * v),
            axis(target_axis),
            axis(u),
            axis(v),
            middle_shift.dot(target_axis)};
  }

  /// The motion that lays the edge on its target and turns by `angle` about it.
  RigidTransform Motion(double angle) const {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, target_axis).toRotationMatrix();
    return {turn * align, target + turn * (middle_shift - align * source)};
  }
};

EdgeEvaluator::EdgeEvaluator(const Correspondences& c, const PairColumns& columns, double limit_m,
                             const std::optional<UprightConstraint>& upright)
    : c_(c),
      columns_(columns),
      limit_m_(limit_m),
      upright_(upright),
      keypoint_(Numbered(c.source_id)),
      seen_(c.size(), 0),
      found_(c.size() + PairColumns::kPadding),
      places_(c.size()),
      begins_(c.size()),
      ends_(c.size()),
      stabber_(c.size()) {
  for (auto* columns_of : {&in_source_, &in_target_}) {
    for (std::vector<double>& column : *columns_of) column.resize(c.size() + kTurnPadding);
  }
  arcs_.reserve(c.size());
}

/// The rotations about the edge that satisfy each of the rows found along it (paper Eq. 5 with the
/// alignment that must precede it).
void EdgeEvaluator::CollectArcs(const Edge& edge, std::span<const std::uint32_t> found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector3d s = c_.source[found[i]] - edge.source;
    const Eigen::Vector3d t = c_.target[found[i]] - edge.target;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      in_source_[axis][i] = s[static_cast<Eigen::Index>(axis)];
      in_target_[axis][i] = t[static_cast<Eigen::Index>(axis)];
    }
  }
  const auto begins = [](const std::array<std::vector<double>, 3>& columns) {
    return std::array<const double*, 3>{columns[0].data(), columns[1].data(), columns[2].data()};
  };
  const std::size_t count =
      FindTurns({begins(in_source_), begins(in_target_), found.size()}, edge.Frame(), limit_m_,
                places_.data(), begins_.data(), ends_.data());
  arcs_.clear();
  sectors_.Clear();
  for (std::size_t n = 0; n < count; ++n) {
    arcs_.push_back({begins_[n], ends_[n], keypoint_[found[places_[n]]]});
    sectors_.Add(arcs_.back());
  }
}

/// Distinct key points that this rotation satisfies.
int EdgeEvaluator::CountAt(double turn) {
  BeginCount();
  int distinct = 0;
  for (const TurnArc& arc : arcs_) distinct += IsNewIf(Contains(arc, turn), arc.id);
  return distinct;
}

/// Distinct key points whose arcs touch any of these sectors.
int EdgeEvaluator::DistinctIn(const RotationSectors::Run& run) {
  BeginCount();
  int distinct = 0;
  for (const TurnArc& arc : arcs_) distinct += IsNewIf(run.Touches(arc), arc.id);
  return distinct;
}

/// Of these runs of sectors those whose arcs are of more than `bar` key points.
void EdgeEvaluator::KeepPromising(std::span<const RotationSectors::Run> runs, int bar) {
  promising_.clear();
  most_in_.clear();
  for (const RotationSectors::Run& run : runs) {
    const int most = DistinctIn(run);
    if (most <= bar) continue;
    promising_.push_back(run);
    most_in_.push_back(most);
  }
}

/// Whether a run of sectors that holds at most `most` key points lies near a known hypothesis that
/// gathers no fewer.
bool EdgeEvaluator::IsKnown(const Edge& edge, const RotationSectors::Run& run, int most,
                            const KnownHypotheses& known) const {
  constexpr double kRounding = 1e-6;
  if (known.hypotheses.front().consensus < most) return false;
  const double begin = run.begin_angle();
  const double end = run.end_angle();
  const double half = 0.5 * (end - begin) + kRounding;
  if (half >= known.nearness.angle_rad) return false;
  const RigidTransform middle = edge.Motion(0.5 * (begin + end));
  const Eigen::Vector3d arm = middle * known.nearness.centroid - edge.target;
  const double lever_m = arm.cross(edge.target_axis).norm() + kRounding;
  return std::any_of(known.hypotheses.begin(), known.hypotheses.end(),
                     [&](const EdgeHypothesis& h) {
                       return h.consensus >= most &&
                              known.nearness.IsNear(h.target_from_source, middle, half, lever_m);
                     });
}

/// Whether every promising run, or else every sector of it, is known.
bool EdgeEvaluator::AllKnown(const Edge& edge, const KnownHypotheses& known) const {
  if (known.hypotheses.empty()) return false;
  for (std::size_t i = 0; i < promising_.size(); ++i) {
    const RotationSectors::Run& run = promising_[i];
    if (IsKnown(edge, run, most_in_[i], known)) continue;
    for (std::size_t sector = run.begin; sector < run.end; ++sector) {
      const int most = std::min(sectors_.ArcsIn(sector), most_in_[i]);
      if (!IsKnown(edge, {sector, sector + 1}, most, known)) return false;
    }
  }
  return true;
}

/// Tight reliability: the rotation that most arcs hold gives the hypothesis.
std::optional<EdgeHypothesis> EdgeEvaluator::Tight(const Edge& edge, int bar,
                                                   const KnownHypotheses& known) {
  if (sectors_.Count() <= bar) return std::nullopt;
  // The best rotation gathers no fewer than that in the middle of the fullest sectors.
  bar = std::max(bar, CountAt(sectors_.PeakTurn()) - 1);
  KeepPromising(sectors_.RunsAbove(bar), bar);
  if (promising_.empty() || AllKnown(edge, known)) return std::nullopt;
  const StabbingResult stabbed = stabber_.Stab(arcs_, promising_);
  return EdgeHypothesis{edge.Motion(stabbed.angle), stabbed.count};
}

/// Whether a row has the same distance from the edge's first row, projection on the edge and rise
/// in both clouds.
bool EdgeEvaluator::LiesAlike(const Edge& edge, std::uint32_t row) const {
  const Eigen::Vector3d s = c_.source[row] - edge.source;
  const Eigen::Vector3d t = c_.target[row] - edge.target;
  return std::abs(s.norm() - t.norm()) < limit_m_ &&
         std::abs(s.dot(edge.source_axis) - t.dot(edge.target_axis)) < limit_m_ &&
         RiseAlike(s, t, limit_m_, upright_);
}

/// The same for levelled instruments: the edge's bearings give the one angle that is left. Edges
/// steeper than 60 deg have no sure bearing and give no consensus.
std::optional<EdgeHypothesis> EdgeEvaluator::Upright(const Edge& edge, int bar,
                                                     std::span<const std::uint32_t> found) {
  constexpr double kFlat = 0.5;
  const Eigen::Vector2d in_source = edge.source_axis.head<2>();
  const Eigen::Vector2d in_target = edge.target_axis.head<2>();
  if (std::min(in_source.norm(), in_target.norm()) < kFlat) return std::nullopt;
  const double turn =
      std::atan2(in_target.y(), in_target.x()) - std::atan2(in_source.y(), in_source.x());
  RigidTransform motion;
  motion.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  motion.translation = edge.target + edge.middle_shift - motion.rotation * edge.source;
  BeginCount();
  int distinct = 0;
  for (const std::uint32_t k : found) {
    if (LiesAlike(edge, k) && (motion * c_.source[k] - c_.target[k]).norm() < limit_m_ &&
        IsNewIf(true, keypoint_[k]) != 0) {
      ++distinct;
    }
  }
  if (distinct <= bar) return std::nullopt;
  return EdgeHypothesis{motion, distinct};
}

std::optional<EdgeHypothesis> EdgeEvaluator::Evaluate(std::uint32_t i, std::uint32_t j, int bar,
                                                      const KnownHypotheses& known) {
  const Edge edge(c_, i, j);
  const Eigen::Vector3f q = edge.source_axis.cast<float>();
  const Eigen::Vector3f p = edge.target_axis.cast<float>();
  const std::size_t count = FindAlongEdge(
      View(columns_), {i, q.x(), q.y(), q.z(), p.x(), p.y(), p.z()}, static_cast<float>(limit_m_),
      Slack(columns_), static_cast<std::size_t>(std::max(bar, 0)), found_.data());
  const auto found = std::span<const std::uint32_t>(found_).first(count);
  if (upright_) return Upright(edge, bar, found);
  CollectArcs(edge, found);
  if (static_cast<int>(arcs_.size()) <= bar) return std::nullopt;
  return Tight(edge, bar, known);
}

}  // namespace backsight
