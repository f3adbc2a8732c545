#include "stages/matching.h"

#include <Eigen/Core>
#include <algorithm>

#include "core/neighbors.h"

namespace backsight {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Descriptors as rows, bins centred, so that float products keep their digits.
Matrix MakeRows(std::span<const FpfhDescriptor> descriptors) {
  Matrix rows(static_cast<Eigen::Index>(descriptors.size()), 33);
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    for (std::size_t bin = 0; bin < 33; ++bin) {
      rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(bin)) =
          descriptors[i][bin] - 100.0F / 11.0F;
    }
  }
  return rows;
}

/// The k smallest (distance, index) seen, in ascending order.
class Nearest {
 public:
  explicit Nearest(std::size_t k) : k_(k) {}
  void Offer(float distance, std::uint32_t index) {
    if (list_.size() == k_ && !(distance < list_.back().first)) return;
    const std::pair<float, std::uint32_t> entry(distance, index);
    list_.insert(std::upper_bound(list_.begin(), list_.end(), entry), entry);
    if (list_.size() > k_) list_.pop_back();
  }
  const std::vector<std::pair<float, std::uint32_t>>& list() const { return list_; }

 private:
  std::size_t k_;
  std::vector<std::pair<float, std::uint32_t>> list_;
};

}  // namespace

void VisitOptions(OptionVisitor& visitor, MatchingOptions& options) {
  visitor.Integer("neighbors", options.neighbors, "1", 1, 50,
                  "a match is among the k nearest descriptors of both key points");
}

std::vector<DescriptorMatch> MatchDescriptors(std::span<const FpfhDescriptor> source,
                                              std::span<const FpfhDescriptor> target,
                                              const MatchingOptions& options) {
  const Matrix a = MakeRows(source);
  const Matrix b = MakeRows(target);
  const Eigen::VectorXf a2 = a.rowwise().squaredNorm();
  const Eigen::VectorXf b2 = b.rowwise().squaredNorm();
  const auto k = static_cast<std::size_t>(options.neighbors);
  std::vector<Nearest> of_source(source.size(), Nearest(k));
  std::vector<Nearest> of_target(target.size(), Nearest(k));
  constexpr Eigen::Index kBlock = 256;
  Matrix products;
  for (Eigen::Index begin = 0; begin < a.rows(); begin += kBlock) {
    const Eigen::Index rows = std::min(kBlock, a.rows() - begin);
    products.noalias() = a.middleRows(begin, rows) * b.transpose();
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto s = static_cast<std::uint32_t>(begin + i);
      for (Eigen::Index j = 0; j < b.rows(); ++j) {
        const float squared = a2[begin + i] + b2[j] - 2.0F * products(i, j);
        of_source[s].Offer(squared, static_cast<std::uint32_t>(j));
        of_target[static_cast<std::size_t>(j)].Offer(squared, s);
      }
    }
  }

  std::vector<DescriptorMatch> matches;
  for (std::uint32_t s = 0; s < source.size(); ++s) {
    for (const auto& [distance, t] : of_source[s].list()) {
      const auto& back = of_target[t].list();
      const bool mutual = std::any_of(back.begin(), back.end(),
                                      [&](const auto& entry) { return entry.second == s; });
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
