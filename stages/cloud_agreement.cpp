#include "stages/cloud_agreement.h"

#include <algorithm>
#include <cmath>

namespace backsight {
namespace {

constexpr int kBlockCells = 5;   // edge of a block, voxels
constexpr int kGroupBlocks = 4;  // edge of a group, blocks
constexpr int kFewestSeenThrough = 4;
constexpr float kLikeNormal = 0.8F;

/// The cube of so many voxels that a leaf lies in.
std::uint64_t CubeKey(std::uint64_t leaf_key, int voxels) {
  const Eigen::Vector3d cell = VoxelLattice::Unpack(leaf_key).cast<double>() / voxels;
  return VoxelLattice::Pack(cell.array().floor().cast<int>());
}

/// How well a point lies on the surfaces in and beside its voxel: whether there is any, and 1 on it
/// falling to 0 at the tolerance.
struct PointFit {
  bool met = false;
  double score = 0.0;
};

PointFit FitPoint(const Surface& reference, const CloudIndex& index, const Eigen::Vector3d& point,
                  const Eigen::Vector3f& normal, double tolerance_m) {
  PointFit fit;
  index.voxels.VisitAround(point, [&](std::uint32_t leaf) {
    const Eigen::Vector3f& n = reference.normals[leaf];
    const float cosine = n.dot(normal);
    // Back to back are the two sides of a wall, not one surface.
    if (cosine < 0.0F) return;
    fit.met = true;
    if (!(cosine > kLikeNormal)) return;
    const double distance =
        n.cast<double>().dot(point - reference.model.leaves.Mean(leaf)) / tolerance_m;
    fit.score = std::max(fit.score, 1.0 - distance * distance);
  });
  return fit;
}

/// What the leaves of one block say.
struct BlockCounts {
  double score = 0.0;
  int met = 0;
  int agrees = 0;
  int through = 0;

  bool SeenThrough() const { return through >= kFewestSeenThrough && through > agrees; }
  bool Agrees() const { return !SeenThrough() && agrees >= kFewestSeenThrough; }
};

/// A leaf that meets no surface, in the reference's frame.
struct LooseLeaf {
  Eigen::Vector3d point;
  Eigen::Vector3f normal;
};

/// A moved cloud against a reference, block by block.
class Comparison {
 public:
  Comparison(const Surface& moved, const CloudSample& sample, const Surface& reference,
             const CloudIndex& index, const RigidTransform& reference_from_moved,
             double tolerance_m)
      : moved_(moved),
        sample_(sample),
        reference_(reference),
        index_(index),
        motion_(reference_from_moved),
        rotation_(reference_from_moved.rotation.cast<float>()),
        tolerance_m_(tolerance_m) {}

  /// How the block fits the surfaces.
  BlockCounts Fit(std::size_t block) {
    BlockCounts counts;
    loose_.clear();
    for (std::uint32_t k = sample_.begins[block]; k < sample_.begins[block + 1]; ++k) {
      const LooseLeaf leaf{motion_ * sample_.points[k],
                           rotation_ * moved_.normals[sample_.leaves[k]]};
      const PointFit fit = FitPoint(reference_, index_, leaf.point, leaf.normal, tolerance_m_);
      counts.score += fit.score;
      counts.met += fit.met ? 1 : 0;
      if (!fit.met) loose_.push_back(leaf);
    }
    return counts;
  }

  /// And what the scanner says of the leaves of the block fitted last. Looks no longer than it
  /// takes to know whether the block agrees or, if it was seen through, at how many of its leaves.
  void Look(BlockCounts* counts) const {
    counts->agrees = counts->met;
    auto left = static_cast<int>(loose_.size());
    for (const LooseLeaf& leaf : loose_) {
      const bool may_be_seen_through =
          counts->through + left >= kFewestSeenThrough && counts->through + left > counts->agrees;
      const bool agrees_or_never_will =
          counts->agrees >= kFewestSeenThrough || counts->agrees + left < kFewestSeenThrough;
      if (!may_be_seen_through && agrees_or_never_will) return;
      const Sight sight = LookAt(reference_.model, leaf.point, leaf.normal);
      counts->agrees += sight == Sight::kAgrees ? 1 : 0;
      counts->through += sight == Sight::kSeenThrough ? 1 : 0;
      --left;
    }
  }

 private:
  const Surface& moved_;
  const CloudSample& sample_;
  const Surface& reference_;
  const CloudIndex& index_;
  RigidTransform motion_;
  Eigen::Matrix3f rotation_;
  double tolerance_m_;
  std::vector<LooseLeaf> loose_;
};

struct GroupSums {
  double part = 0.0;
  double whole = 0.0;
};

/// Ratio of sums, its variance from the groups' residuals (the delta method for cluster samples).
RatioEstimate EstimateRatio(const std::vector<GroupSums>& groups) {
  GroupSums sum;
  for (const GroupSums& group : groups) {
    sum.part += group.part;
    sum.whole += group.whole;
  }
  RatioEstimate ratio;
  if (sum.whole == 0.0) return ratio;
  ratio.value = sum.part / sum.whole;
  double squared = 0.0;
  for (const GroupSums& group : groups) {
    const double residual = group.part - ratio.value * group.whole;
    squared += residual * residual;
  }
  ratio.sigma = std::sqrt(squared) / sum.whole;
  return ratio;
}

}  // namespace

CloudSample SampleCloud(const StationModel& model, std::size_t leaves) {
  struct Place {
    std::uint64_t group, block;
    std::uint32_t leaf;
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> order;
  order.reserve(model.leaves.size());
  for (std::size_t i = 0; i < model.leaves.size(); ++i) {
    const std::uint64_t key = model.leaves.Key(i);
    order.push_back({CubeKey(key, kBlockCells * kGroupBlocks), CubeKey(key, kBlockCells),
                     static_cast<std::uint32_t>(i)});
  }
  std::sort(order.begin(), order.end());
  const std::size_t stride =
      std::max<std::size_t>(1, model.leaves.size() / std::max<std::size_t>(leaves, 1));
  CloudSample sample;
  std::uint64_t last_group = 0;
  std::size_t block = 0;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && order[end].block == order[begin].block) ++end;
    if (block++ % stride == 0) {
      const bool same = !sample.groups.empty() && last_group == order[begin].group;
      const std::uint32_t last = sample.groups.empty() ? 0U : sample.groups.back() + 1U;
      sample.groups.push_back(same ? sample.groups.back() : last);
      last_group = order[begin].group;
      sample.begins.push_back(static_cast<std::uint32_t>(sample.leaves.size()));
      for (std::size_t i = begin; i < end; ++i) sample.leaves.push_back(order[i].leaf);
    }
    begin = end;
  }
  sample.begins.push_back(static_cast<std::uint32_t>(sample.leaves.size()));
  sample.points.reserve(sample.leaves.size());
  for (const std::uint32_t leaf : sample.leaves) {
    sample.points.push_back(model.leaves.Mean(leaf));
  }
  return sample;
}

CloudIndex::CloudIndex(const StationModel& model)
    : voxels(model.leaves.means()),
      sieve(SampleCloud(model, 1500)),
      sample(SampleCloud(model, 20000)) {}

Sight LookAt(const StationModel& viewer, const Eigen::Vector3d& point,
             const Eigen::Vector3f& normal, const SightTolerance& tolerance) {
  return LookAt(viewer, viewer.range_image.Around(point), point, normal, tolerance);
}

Sight LookAt(const StationModel& viewer, const RangeImage::Window& window,
             const Eigen::Vector3d& point, const Eigen::Vector3f& normal,
             const SightTolerance& tolerance) {
  if (window.farthest_m == 0.0F) return Sight::kNotInView;
  const double range = point.norm();
  const double spread = tolerance.pixels * range * viewer.range_image.PixelAngle();
  constexpr double kLeastSine = 0.05;
  constexpr double kMost = 1.0;  // m
  const bool is_surface = normal.allFinite();
  const double sine = is_surface
                          ? std::max(std::abs(normal.cast<double>().dot(point)) / range, kLeastSine)
                          : kLeastSine;
  const double varies = tolerance.voxels * viewer.resolution_m() + spread / sine;
  const double slack = std::min(varies, kMost);
  if (window.gap_m <= slack) return Sight::kAgrees;
  // On ground seen at a grazing angle the next beams lie metres apart: none need be near the point.
  const double clearly = is_surface ? varies : slack;
  if (range < window.nearest_m - clearly) return Sight::kSeenThrough;
  return range > window.farthest_m + slack ? Sight::kHidden : Sight::kUnclear;
}

double ScoreClouds(const Surface& moved, const CloudSample& sample, const Surface& reference,
                   const CloudIndex& reference_index, const RigidTransform& reference_from_moved,
                   double tolerance_m) {
  Comparison comparison(moved, sample, reference, reference_index, reference_from_moved,
                        tolerance_m);
  double score = 0.0;
  for (std::size_t b = 0; b < sample.blocks(); ++b) score += comparison.Fit(b).score;
  return score / std::max<double>(1.0, static_cast<double>(sample.leaves.size()));
}

CloudAgreement CompareClouds(const Surface& moved, const CloudSample& sample,
                             const Surface& reference, const CloudIndex& reference_index,
                             const RigidTransform& reference_from_moved, double tolerance_m) {
  CloudAgreement result;
  Comparison comparison(moved, sample, reference, reference_index, reference_from_moved,
                        tolerance_m);
  const std::size_t groups = sample.groups.empty() ? 0 : sample.groups.back() + 1;
  std::vector<GroupSums> conflict(groups);
  std::vector<GroupSums> quality(groups);
  std::size_t met = 0;
  double score = 0.0;
  for (std::size_t b = 0; b < sample.blocks(); ++b) {
    BlockCounts counts = comparison.Fit(b);
    if (reference.scanner_credible) comparison.Look(&counts);
    GroupSums& in_view = conflict[sample.groups[b]];
    in_view.part += counts.SeenThrough() ? 1.0 : 0.0;
    in_view.whole += counts.SeenThrough() || counts.Agrees() ? 1.0 : 0.0;
    GroupSums& on_surface = quality[sample.groups[b]];
    on_surface.part += counts.score - (counts.SeenThrough() ? counts.through : 0);
    on_surface.whole += counts.met + (counts.SeenThrough() ? counts.through : 0);
    met += static_cast<std::size_t>(counts.met);
    score += counts.score;
  }
  const double tried = std::max<double>(1.0, static_cast<double>(sample.leaves.size()));
  result.overlap = static_cast<double>(met) / tried;
  result.score = score / tried;
  for (const GroupSums& group : conflict) result.blocks_in_view += static_cast<int>(group.whole);
  result.conflict = EstimateRatio(conflict);
  // Few blocks of which none was seen through are little evidence: the next one could be.
  result.conflict.sigma = std::hypot(result.conflict.sigma, 1.0 / (1.0 + result.blocks_in_view));
  result.quality = EstimateRatio(quality);
  return result;
}

}  // namespace backsight
