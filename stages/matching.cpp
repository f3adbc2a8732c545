#include "stages/matching.h"

#include <Eigen/Core>
#include <algorithm>

#include "core/neighbors.h"
#include "stages/descriptor_distances.h"

namespace backsight {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Descriptors as rows, bins centred, so that float products keep their digits; and zeros, as many
/// as the kernel may read beyond.
Matrix MakeRows(std::span<const FpfhDescriptor> descriptors) {
  constexpr std::size_t kMultiple = 16;
  const std::size_t padded = (descriptors.size() + kMultiple - 1) / kMultiple * kMultiple;
  Matrix rows = Matrix::Zero(static_cast<Eigen::Index>(padded), kDescriptorBins);
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(bin)) =
          descriptors[i][bin] - 100.0F / 11.0F;
    }
  }
  return rows;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, MatchingOptions& options) {
  visitor.Integer("neighbors", options.neighbors, "1", 1, 50,
                  "a match is among the k nearest descriptors of both key points");
}

std::vector<DescriptorMatch> MatchDescriptors(std::span<const FpfhDescriptor> source,
                                              std::span<const FpfhDescriptor> target,
                                              const MatchingOptions& options) {
  if (source.empty() || target.empty()) return {};
  const Matrix a = MakeRows(source);
  const Matrix b = MakeRows(target);
  const Matrix b_columns = b.transpose();
  const Eigen::VectorXf a2 = a.rowwise().squaredNorm();
  const Eigen::VectorXf b2 = b.rowwise().squaredNorm();
  const auto k = static_cast<std::size_t>(options.neighbors);
  std::vector<DescriptorNeighbor> of_source(k * source.size());
  std::vector<DescriptorNeighbor> of_target(k * target.size());
  FindNearestDescriptors(
      {a.data(), a2.data(), source.size()},
      {b_columns.data(), b2.data(), target.size(), static_cast<std::size_t>(b_columns.cols())}, k,
      of_source, of_target);

  std::vector<DescriptorMatch> matches;
  for (std::uint32_t s = 0; s < source.size(); ++s) {
    for (const auto& [distance, t] :
         std::span(of_source).subspan(k * s, std::min(k, target.size()))) {
      const auto back = std::span(of_target).subspan(k * t, std::min(k, source.size()));
      const bool mutual = std::any_of(back.begin(), back.end(),
                                      [&](const DescriptorNeighbor& n) { return n.index == s; });
      if (mutual) matches.push_back({s, t});
    }
  }
  return matches;
}

std::vector<Eigen::Vector3d> KeypointPositions(const StationModel& model,
                                               const StationFeatures& features) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(features.keypoints.size());
  for (const std::uint32_t leaf : features.keypoints) {
    positions.push_back(model.leaves[leaf].cluster.mean);
  }
  return positions;
}

Correspondences MatchStations(const StationModel& source, const StationFeatures& source_features,
                              const StationModel& target, const StationFeatures& target_features,
                              const MatchingOptions& options) {
  const std::vector<Eigen::Vector3d> q = KeypointPositions(source, source_features);
  const std::vector<Eigen::Vector3d> p = KeypointPositions(target, target_features);
  Correspondences c;
  for (const DescriptorMatch& match :
       MatchDescriptors(source_features.descriptors, target_features.descriptors, options)) {
    c.Add(q[match.source], p[match.target], match.source, match.target);
  }
  return c;
}

Correspondences MatchPositions(const std::vector<Eigen::Vector3d>& source,
                               const std::vector<Eigen::Vector3d>& target,
                               const RigidTransform& transform, double radius_m) {
  Correspondences c;
  const NeighborSearch in_source(source);
  const NeighborSearch in_target(target);
  const RigidTransform inverse = transform.Inverse();
  for (std::uint32_t i = 0; i < source.size(); ++i) {
    const auto there = in_target.Nearest(transform * source[i], 1);
    if (there.empty() || there[0].distance_m > radius_m) continue;
    const std::uint32_t j = there[0].index;
    if (in_source.Nearest(inverse * target[j], 1)[0].index == i) c.Add(source[i], target[j], i, j);
  }
  return c;
}

}  // namespace backsight
