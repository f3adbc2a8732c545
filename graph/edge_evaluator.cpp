#include "graph/edge_evaluator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/reliability_kernels.h"

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
        middle_shift(0.5 * ((c.target[j] - c.target[i]) -
                            (c.source[j] - c.source[i]).norm() * target_axis)) {}
  Eigen::Vector3d source, target;            // of row i
  Eigen::Vector3d source_axis, target_axis;  // from i to j
  Eigen::Vector3d middle_shift;              // centres the length difference on both ends

  /// The motion that lays the edge on its target and turns by `angle` about it.
  RigidTransform Motion(double angle) const {
    const Eigen::Matrix3d align = MinimalRotation(source_axis, target_axis);
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
      stabber_(c.size()) {}

/// Necessary condition for a row to agree with the edge under some rotation about it: equal
/// distance from row i and equal signed projection on the edge, both within 2 l.
void EdgeEvaluator::CollectRows(std::uint32_t i, const Edge& edge, int bar) {
  rows_.clear();
  const Eigen::Vector3f q = edge.source_axis.cast<float>();
  const Eigen::Vector3f p = edge.target_axis.cast<float>();
  const std::size_t count = FindAlongEdge(
      View(columns_), {i, q.x(), q.y(), q.z(), p.x(), p.y(), p.z()}, static_cast<float>(limit_m_),
      Slack(columns_), static_cast<std::size_t>(std::max(bar, 0)), found_.data());
  for (const std::uint32_t k : std::span(found_).first(count)) {
    const Eigen::Vector3d s = c_.source[k] - edge.source;
    const Eigen::Vector3d m = c_.target[k] - edge.target;
    if (std::abs(s.norm() - m.norm()) < limit_m_ &&
        std::abs(s.dot(edge.source_axis) - m.dot(edge.target_axis)) < limit_m_ &&
        RiseAlike(s, m, limit_m_, upright_)) {
      rows_.push_back(k);
    }
  }
}

/// Distinct key points of `rows_`.
int EdgeEvaluator::DistinctRows() {
  ++count_;
  int distinct = 0;
  for (const std::uint32_t row : rows_) {
    std::uint32_t& last = seen_[keypoint_[row]];
    distinct += last != count_ ? 1 : 0;
    last = count_;
  }
  return distinct;
}

/// Whether some rotation brings the candidate within the limit.
bool EdgeEvaluator::CanMeet(const Candidate& k) const {
  const double limit2 = limit_m_ * limit_m_;
  const double quick = std::sqrt(k.source_u * k.source_u + k.source_v * k.source_v) -
                       std::sqrt(k.target_u * k.target_u + k.target_v * k.target_v);
  const double rest = quick * quick + k.along * k.along;
  // Far from the limit the digits that hypot adds do not matter, and it takes its time.
  if (std::abs(rest - limit2) > 1e-6 * limit2) return rest <= limit2;
  const double exact = std::hypot(k.source_u, k.source_v) - std::hypot(k.target_u, k.target_v);
  return exact * exact + k.along * k.along <= limit2;
}

/// The rows as the edge sees them; drops those that no rotation satisfies.
void EdgeEvaluator::CollectCandidates(const Edge& edge) {
  const Eigen::Matrix3d align = MinimalRotation(edge.source_axis, edge.target_axis);
  const Eigen::Vector3d& axis = edge.target_axis;
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  candidates_.clear();
  sectors_.Clear();
  for (const std::uint32_t k : rows_) {
    const Eigen::Vector3d m = align * (c_.source[k] - edge.source) + edge.middle_shift;
    const Eigen::Vector3d q = c_.target[k] - edge.target;
    Candidate candidate{k, m.dot(u), m.dot(v), q.dot(u), q.dot(v), q.dot(axis) - m.dot(axis), {}};
    if (!CanMeet(candidate)) continue;
    candidate.sectors = SectorsOf(candidate);
    sectors_.Add(candidate.sectors);
    candidates_.push_back(candidate);
  }
  sectors_.Count();
}

/// Tight reliability of an edge (paper Eq. 5 with the alignment that must precede it): after moving
/// the edge onto its target, each candidate is satisfied for an interval of rotation angles about
/// it; the best stabbing angle gives the hypothesis.
EdgeHypothesis EdgeEvaluator::Tight(const Edge& edge) {
  intervals_.clear();
  for (const Candidate& k : candidates_) {
    const double radius_m = std::hypot(k.source_u, k.source_v);
    const double radius_q = std::hypot(k.target_u, k.target_v);
    // |Rz(angle) m - q|^2 <= limit^2  <=>  cos(angle - (azimuth_q - azimuth_m)) >= kappa
    const double product = 2.0 * radius_m * radius_q;
    const double kappa = product > 1e-12 ? (radius_m * radius_m + radius_q * radius_q +
                                            k.along * k.along - limit_m_ * limit_m_) /
                                               product
                                         : -1.0;
    const std::uint32_t keypoint = keypoint_[k.row];
    if (kappa <= -1.0) {
      intervals_.push_back({0.0, 2.0 * std::numbers::pi, keypoint});
      continue;
    }
    const double half_width = std::acos(std::min(kappa, 1.0));
    const double center = std::atan2(k.target_v, k.target_u) - std::atan2(k.source_v, k.source_u);
    intervals_.push_back({center - half_width, center + half_width, keypoint});
  }

  const StabbingResult stabbed = stabber_.Stab(intervals_);
  EdgeHypothesis hypothesis;
  hypothesis.consensus = stabbed.count;
  hypothesis.target_from_source = edge.Motion(stabbed.angle);
  return hypothesis;
}

/// The sectors of its interval of angles.
RotationSectors::Range EdgeEvaluator::SectorsOf(const Candidate& k) const {
  const double square_m = k.source_u * k.source_u + k.source_v * k.source_v;
  const double square_q = k.target_u * k.target_u + k.target_v * k.target_v;
  const double product = 2.0 * std::sqrt(square_m * square_q);
  const double rest = square_m + square_q + k.along * k.along - limit_m_ * limit_m_;
  if (product < 1e-9 || rest <= -product) return {};
  return RotationSectors::RangeOf(k.target_u * k.source_u + k.target_v * k.source_v,
                                  k.target_v * k.source_u - k.target_u * k.source_v,
                                  rest / product);
}

/// Distinct key points that surely lie within the limit under this rotation.
int EdgeEvaluator::CountAt(double angle) {
  constexpr double kRounding = 1e-9;
  const double limit2 = std::pow(limit_m_ - kRounding, 2);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  ++count_;
  int distinct = 0;
  for (const Candidate& k : candidates_) {
    const double u = c * k.source_u - s * k.source_v - k.target_u;
    const double v = s * k.source_u + c * k.source_v - k.target_v;
    if (u * u + v * v + k.along * k.along > limit2) continue;
    std::uint32_t& last = seen_[keypoint_[k.row]];
    distinct += last != count_ ? 1 : 0;
    last = count_;
  }
  return distinct;
}

/// Drops the candidates in no sector with more than `bar`: what they take part in does not matter.
/// False if none remains.
bool EdgeEvaluator::KeepPromising(int bar) {
  const std::vector<RotationSectors::Run>& runs = sectors_.RunsAbove(bar);
  std::erase_if(candidates_, [&](const Candidate& k) {
    return std::none_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
      return k.sectors.Touches(run.begin, run.end);
    });
  });
  return !candidates_.empty();
}

/// Distinct key points of the candidates that touch any of these sectors.
int EdgeEvaluator::DistinctIn(const RotationSectors::Run& run) {
  ++count_;
  int distinct = 0;
  for (const Candidate& k : candidates_) {
    if (!k.sectors.Touches(run.begin, run.end)) continue;
    std::uint32_t& seen = seen_[keypoint_[k.row]];
    distinct += seen != count_ ? 1 : 0;
    seen = count_;
  }
  return distinct;
}

/// Whether every run of sectors with more than `bar` lies near a known hypothesis that gathers no
/// fewer than the run can.
bool EdgeEvaluator::IsKnown(const Edge& edge, int bar, const KnownHypotheses& known) {
  constexpr double kRounding = 1e-6;
  if (known.hypotheses.empty()) return false;
  const std::vector<RotationSectors::Run>& runs = sectors_.RunsAbove(bar);
  return std::all_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
    const double begin = RotationSectors::BeginOf(run.begin);
    const double end = RotationSectors::BeginOf(run.end);
    const double half = 0.5 * (end - begin) + kRounding;
    if (half >= known.nearness.angle_rad) return false;
    const RigidTransform middle = edge.Motion(0.5 * (begin + end));
    const Eigen::Vector3d arm = middle * known.nearness.centroid - edge.target;
    const double lever_m = arm.cross(edge.target_axis).norm() + kRounding;
    const int most = DistinctIn(run);
    return std::any_of(known.hypotheses.begin(), known.hypotheses.end(),
                       [&](const EdgeHypothesis& h) {
                         return h.consensus >= most &&
                                known.nearness.IsNear(h.target_from_source, middle, half, lever_m);
                       });
  });
}

/// The same for levelled instruments: the edge's bearings give the one angle that is left. Edges
/// steeper than 60 deg have no sure bearing and give no consensus.
EdgeHypothesis EdgeEvaluator::Upright(const Edge& edge) {
  EdgeHypothesis hypothesis;
  constexpr double kFlat = 0.5;
  const Eigen::Vector2d in_source = edge.source_axis.head<2>();
  const Eigen::Vector2d in_target = edge.target_axis.head<2>();
  if (std::min(in_source.norm(), in_target.norm()) < kFlat) return hypothesis;
  const double turn =
      std::atan2(in_target.y(), in_target.x()) - std::atan2(in_source.y(), in_source.x());
  RigidTransform& motion = hypothesis.target_from_source;
  motion.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  motion.translation = edge.target + edge.middle_shift - motion.rotation * edge.source;
  std::erase_if(rows_, [&](std::uint32_t k) {
    return !((motion * c_.source[k] - c_.target[k]).norm() < limit_m_);
  });
  hypothesis.consensus = DistinctRows();
  return hypothesis;
}

std::optional<EdgeHypothesis> EdgeEvaluator::Evaluate(std::uint32_t i, std::uint32_t j, int bar,
                                                      const KnownHypotheses& known) {
  const Edge edge(c_, i, j);
  CollectRows(i, edge, bar);
  if (static_cast<int>(rows_.size()) <= bar || DistinctRows() <= bar) return std::nullopt;
  if (upright_) return Upright(edge);
  CollectCandidates(edge);
  // The best rotation gathers no fewer than that in the middle of the fullest sectors.
  bar = std::max(bar, CountAt(sectors_.PeakAngle()) - 1);
  if (!KeepPromising(bar) || IsKnown(edge, bar, known)) return std::nullopt;
  return Tight(edge);
}

}  // namespace backsight
