#include "core/neighbors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/random.h"

namespace backsight {
namespace {

using Neighbor = NeighborSearch::Neighbor;
using Points = std::vector<Eigen::Vector3d>;

/// All points by distance, ties by index.
std::vector<Neighbor> Sorted(const Points& points, const Eigen::Vector3d& query) {
  std::vector<Neighbor> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    all.push_back({i, (points[i] - query).norm()});
  }
  std::stable_sort(all.begin(), all.end(), [](const Neighbor& a, const Neighbor& b) {
    return a.distance_m < b.distance_m;
  });
  return all;
}

void ExpectEqual(const std::vector<Neighbor>& actual, const std::vector<Neighbor>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].index, expected[i].index) << "place " << i;
    EXPECT_NEAR(actual[i].distance_m, expected[i].distance_m, 1e-12) << "place " << i;
  }
}

void ExpectLikeBruteForce(const Points& points, const Points& queries, double radius_m) {
  const NeighborSearch search(points);
  EXPECT_EQ(search.size(), points.size());
  for (const auto& query : queries) {
    const auto all = Sorted(points, query);
    for (const std::size_t k : {1U, 2U, 3U, 5U, 20U}) {
      const auto end = all.begin() + static_cast<std::ptrdiff_t>(std::min(k, all.size()));
      ExpectEqual(search.Nearest(query, k), {all.begin(), end});
    }
    std::vector<Neighbor> within = all;
    std::erase_if(within, [&](const Neighbor& n) { return n.distance_m >= radius_m; });
    ExpectEqual(search.Within(query, radius_m), within);
  }
}

Points RandomPoints(Random& random, std::size_t n) {
  Points points(n);
  for (auto& p : points) p = {random.Normal(), random.Normal(), random.Normal()};
  return points;
}

TEST(NeighborSearch, EqualsBruteForce) {
  Random random(1);
  for (const std::size_t n : {1U, 11U, 500U, 3000U}) {
    const Points points = RandomPoints(random, n);
    ExpectLikeBruteForce(points, RandomPoints(random, 30), 0.5);
  }
}

TEST(NeighborSearch, TiesGoByIndex) {
  // Integer coordinates: many exactly equal distances, also across the k-th place.
  Random random(2);
  Points grid;
  for (int i = 0; i < 6 * 6 * 6; ++i) grid.emplace_back(i % 6, (i / 6) % 6, i / 36);
  for (std::size_t i = grid.size(); i > 1; --i) std::swap(grid[i - 1], grid[random.Index(i)]);
  grid.insert(grid.end(), grid.begin(), grid.begin() + 40);  // duplicates
  const Points queries = {{2, 3, 2}, {0, 0, 0}, {2.5, 2.5, 2.5}, {-4, 2, 2}, {1, 1.5, 3}};
  ExpectLikeBruteForce(grid, queries, 2.0);
}

TEST(NeighborSearch, RadiusIsExclusive) {
  const Points points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const NeighborSearch search(points);
  EXPECT_EQ(search.Within({0, 0, 0}, 2.0).size(), 2U);
  EXPECT_EQ(search.Within({0, 0, 0}, 2.0 + 1e-9).size(), 3U);
  EXPECT_TRUE(search.Within({0, 5, 0}, 2.0).empty());
}

TEST(NeighborSearch, EmptySetFindsNothing) {
  const NeighborSearch search(Points{});
  EXPECT_EQ(search.size(), 0U);
  EXPECT_TRUE(search.Nearest({0, 0, 0}, 3).empty());
  EXPECT_TRUE(search.Within({0, 0, 0}, 1e6).empty());
}

TEST(NeighborSearch, NoneWantedNoneFound) {
  const NeighborSearch search(Points{{1, 2, 3}});
  EXPECT_TRUE(search.Nearest({0, 0, 0}, 0).empty());
  EXPECT_EQ(search.Nearest({0, 0, 0}, 7).size(), 1U);
}

TEST(NeighborSearch, KeepsItsPoints) {
  Points points = {{0, 0, 0}, {5, 0, 0}};
  NeighborSearch search(points);
  points.clear();
  const NeighborSearch moved = std::move(search);
  EXPECT_EQ(moved.Nearest({4, 0, 0}, 1).at(0).index, 1U);
}

}  // namespace
}  // namespace backsight
