#include "stages/surface_links.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/voxel_grid.h"

namespace backsight {
namespace {

constexpr double kReach = 2.0;                       // voxels, between matched means
const double kLargestAngleCosine = std::sqrt(0.75);  // 30 deg between matched normals
constexpr std::size_t kFewestMatches = 100;

/// Normal equations of the relative pose, Retract's convention, target frame.
struct Sums {
  Vector6d gradient = Vector6d::Zero();
  Matrix6d matrix = Matrix6d::Zero();
  Matrix6d known = Matrix6d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double count = 0.0;
};

}  // namespace

struct SurfaceMatcher::Match {
  Eigen::Vector3d moved, fixed;  // target frame
  Eigen::Vector3d moved_normal, fixed_normal;
};

struct SurfaceMatcher::LinkResult {
  PoseGraphLink link;
  std::vector<LinkScore> scores;
  int matches = 0;  // 0: observes nothing
};

SurfaceMatcher::SurfaceMatcher(std::span<const StationModel* const> stations,
                               std::span<const std::vector<Eigen::Vector3f>* const> normals,
                               const std::function<bool(std::size_t, std::size_t)>& covered,
                               const ExecutionContext& context)
    : voxels_(stations.size()) {
  for (const StationModel* model : stations) l_ = std::max(l_, model->resolution_m());
  context.ParallelFor(stations.size(), [&](std::size_t s) {
    Voxels& voxels = voxels_[s];
    const VoxelLeaves& leaves = stations[s]->leaves;
    std::vector<std::uint32_t> free;
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      if ((*normals[s])[i].allFinite() && !covered(s, i)) free.push_back(i);
    }
    voxels.means = VoxelPoints(leaves.lattice());
    voxels.means.Reserve(free.size());
    voxels.normals.reserve(free.size());
    for (const std::uint32_t i : free) {
      voxels.means.Add(leaves.Key(i), leaves.Mean(i));
      voxels.normals.push_back((*normals[s])[i]);
    }
    voxels.index = std::make_unique<VoxelIndex>(voxels.means);
  });
}

std::vector<SurfaceMatcher::Match> SurfaceMatcher::FindMatches(
    const PoseGraphLink& link, const RigidTransform& target_from_source, std::size_t sample) const {
  const Voxels& source = voxels_[static_cast<std::size_t>(link.source)];
  const Voxels& target = voxels_[static_cast<std::size_t>(link.target)];
  const std::size_t stride = std::max<std::size_t>(1, source.means.size() / sample);
  std::vector<Match> matches;
  for (std::size_t i = 0; i < source.means.size(); i += stride) {
    const Eigen::Vector3d moved = target_from_source * source.means[i];
    const auto nearest = target.index->Nearest(target.means, moved, kReach * l_);
    if (!nearest) continue;
    const Eigen::Vector3d moved_normal =
        target_from_source.rotation * source.normals[i].cast<double>();
    const Eigen::Vector3d fixed_normal = target.normals[nearest->voxel].cast<double>();
    if (moved_normal.dot(fixed_normal) < kLargestAngleCosine) continue;
    matches.push_back({moved, target.means[nearest->voxel], moved_normal, fixed_normal});
  }
  return matches;
}

SurfaceMatcher::LinkResult SurfaceMatcher::ObserveLink(const PoseGraphLink& link,
                                                       std::span<const RigidTransform> poses,
                                                       double block_m, double information_factor,
                                                       std::size_t sample) const {
  LinkResult result;
  const RigidTransform& survey_from_target = poses[static_cast<std::size_t>(link.target)];
  const RigidTransform target_from_source =
      survey_from_target.Inverse() * poses[static_cast<std::size_t>(link.source)];
  const std::vector<Match> matches = FindMatches(link, target_from_source, sample);
  if (matches.size() < kFewestMatches) return result;

  std::vector<double> across;
  across.reserve(matches.size());
  for (const Match& m : matches) {
    across.push_back(
        std::abs((m.moved - m.fixed).dot((m.moved_normal + m.fixed_normal).normalized())));
  }
  const auto middle = across.begin() + static_cast<std::ptrdiff_t>(across.size() / 2);
  std::nth_element(across.begin(), middle, across.end());
  constexpr double kSigmaFromMedian = 1.4826;
  constexpr double kFloor = 0.001;  // m: no voxel is better
  const double sigma = std::max(kSigmaFromMedian * *middle / std::sqrt(2.0), kFloor);
  const double across_variance = sigma * sigma;
  const double along_variance = std::max(l_ * l_, across_variance);

  const VoxelLattice lattice{.edge_m = block_m};
  std::map<std::uint64_t, Sums> blocks;
  for (const Match& m : matches) {
    const Eigen::Matrix3d covariance =
        2.0 * along_variance * Eigen::Matrix3d::Identity() -
        (along_variance - across_variance) * (m.moved_normal * m.moved_normal.transpose() +
                                              m.fixed_normal * m.fixed_normal.transpose());
    const Eigen::Matrix3d weight = information_factor * covariance.inverse();
    const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(m.moved);
    const Eigen::Matrix<double, 6, 3> weighted = jacobian.transpose() * weight;
    const Eigen::Vector3d in_survey = survey_from_target * m.fixed;
    Sums& sums = blocks[lattice.Key(in_survey)];
    sums.matrix += weighted * jacobian;
    const Eigen::Vector3d normal = (m.moved_normal + m.fixed_normal).normalized();
    const Vector6d turned = jacobian.transpose() * normal;
    sums.known += normal.dot(weight * normal) * turned * turned.transpose();
    sums.gradient += weighted * (m.moved - m.fixed);
    sums.center += in_survey;
    sums.count += 1.0;
  }

  const Matrix6d adjoint = Adjoint(survey_from_target.Inverse());
  Sums total;
  for (const auto& [key, sums] : blocks) {
    total.matrix += sums.matrix;
    total.gradient += sums.gradient;
    result.scores.push_back({link.source, link.target, adjoint.transpose() * sums.gradient,
                             adjoint.transpose() * sums.matrix * adjoint,
                             adjoint.transpose() * sums.known * adjoint, sums.center / sums.count});
  }
  const Vector6d step = -total.matrix.ldlt().solve(total.gradient);
  if (!step.allFinite()) return {};
  result.link = link;
  result.link.target_from_source = Retract(target_from_source, step);
  result.link.information = total.matrix;
  result.matches = static_cast<int>(matches.size());
  return result;
}

SurfaceObservations SurfaceMatcher::Observe(std::span<const PoseGraphLink> links,
                                            std::span<const RigidTransform> poses, double block_m,
                                            double information_factor,
                                            const ExecutionContext& context) const {
  constexpr std::size_t kAllMatches = 2'000'000;
  constexpr std::size_t kSample = 20'000;
  const std::size_t sample =
      std::min(kSample, kAllMatches / std::max<std::size_t>(1, links.size()));
  std::vector<LinkResult> results(links.size());
  context.ParallelFor(links.size(), [&](std::size_t k) {
    results[k] = ObserveLink(links[k], poses, block_m, information_factor, sample);
  });
  SurfaceObservations observations;
  for (LinkResult& result : results) {
    if (result.matches == 0) continue;
    observations.matches += result.matches;
    observations.links.push_back(result.link);
    observations.scores.insert(observations.scores.end(), result.scores.begin(),
                               result.scores.end());
  }
  return observations;
}

}  // namespace backsight
