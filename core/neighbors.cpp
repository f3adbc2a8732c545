#include "core/neighbors.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

namespace backsight {

struct NeighborSearch::Tree {
  explicit Tree(std::span<const Eigen::Vector3d> input) : points(input.begin(), input.end()) {
    index.buildIndex();
  }
  // The names of these three are nanoflann's.
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

  /// All closer than the root of `squared_m2`, in no order.
  std::vector<Neighbor> Closer(const Eigen::Vector3d& query, double squared_m2) const {
    std::vector<std::pair<std::uint32_t, double>> found;
    index.radiusSearch(query.data(), squared_m2, found, nanoflann::SearchParams(0, 0.0F, false));
    std::vector<Neighbor> result;
    result.reserve(found.size());
    for (const auto& [i, squared] : found) result.push_back({i, std::sqrt(squared)});
    return result;
  }

  using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Tree>,
                                                    Tree, 3, std::uint32_t>;
  std::vector<Eigen::Vector3d> points;
  Index index{3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(12)};
};

namespace {

bool Before(const NeighborSearch::Neighbor& a, const NeighborSearch::Neighbor& b) {
  return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.index < b.index;
}

}  // namespace

NeighborSearch::NeighborSearch(std::span<const Eigen::Vector3d> points)
    : tree_(std::make_unique<Tree>(points)) {}
NeighborSearch::~NeighborSearch() = default;
NeighborSearch::NeighborSearch(NeighborSearch&&) noexcept = default;
NeighborSearch& NeighborSearch::operator=(NeighborSearch&&) noexcept = default;

std::vector<NeighborSearch::Neighbor> NeighborSearch::Nearest(const Eigen::Vector3d& query,
                                                              std::size_t k) const {
  k = std::min(k, size());
  if (k == 0) return {};
  // One more than asked for tells whether a tie is cut at the k-th place; which of the tied points
  // nanoflann returns depends on its tree, so then all of them are fetched.
  const std::size_t wanted = std::min(k + 1, size());
  std::vector<std::uint32_t> indices(wanted);
  std::vector<double> squared(wanted);
  tree_->index.knnSearch(query.data(), wanted, indices.data(), squared.data());
  std::vector<Neighbor> result;
  if (wanted > k && squared[k] == squared[k - 1]) {
    result = tree_->Closer(query, std::nextafter(squared[k], HUGE_VAL));
  } else {
    for (std::size_t i = 0; i < k; ++i) result.push_back({indices[i], std::sqrt(squared[i])});
  }
  std::sort(result.begin(), result.end(), Before);
  result.resize(k);
  return result;
}

std::vector<NeighborSearch::Neighbor> NeighborSearch::Within(const Eigen::Vector3d& query,
                                                             double radius_m) const {
  if (size() == 0) return {};
  std::vector<Neighbor> result = tree_->Closer(query, radius_m * radius_m);
  std::sort(result.begin(), result.end(), Before);
  return result;
}

std::size_t NeighborSearch::size() const { return tree_->points.size(); }

}  // namespace backsight
