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
  std::vector<std::uint32_t> indices(k);
  std::vector<double> squared(k);
  if (k > 0) tree_->index.knnSearch(query.data(), k, indices.data(), squared.data());
  std::vector<Neighbor> result(k);
  for (std::size_t i = 0; i < k; ++i) result[i] = {indices[i], std::sqrt(squared[i])};
  std::sort(result.begin(), result.end(), Before);
  return result;
}

std::vector<NeighborSearch::Neighbor> NeighborSearch::Within(const Eigen::Vector3d& query,
                                                             double radius_m) const {
  std::vector<std::pair<std::uint32_t, double>> found;
  if (size() > 0) {
    tree_->index.radiusSearch(query.data(), radius_m * radius_m, found,
                              nanoflann::SearchParams(0, 0.0F, false));
  }
  std::vector<Neighbor> result;
  result.reserve(found.size());
  for (const auto& [index, squared] : found) result.push_back({index, std::sqrt(squared)});
  std::sort(result.begin(), result.end(), Before);
  return result;
}

std::size_t NeighborSearch::size() const { return tree_->points.size(); }

}  // namespace backsight
