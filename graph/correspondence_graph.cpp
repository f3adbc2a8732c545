#include "graph/correspondence_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace backsight {
namespace {

/// Re-centred float coordinates, one array per axis, so that the inner loop vectorises.
struct PointArrays {
  explicit PointArrays(const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const auto& p : points) center += p / static_cast<double>(points.size());
    for (const auto& p : points) {
      x.push_back(static_cast<float>(p.x() - center.x()));
      y.push_back(static_cast<float>(p.y() - center.y()));
      z.push_back(static_cast<float>(p.z() - center.z()));
    }
  }
  std::vector<float> x, y, z;
};

/// exp(-y) for 0 <= y <= 2/3, relative error below 3e-7; a polynomial, so that it vectorises.
inline float ExpNegative(float y) {
  return 1.0F +
         y * (-1.0F + y * (0.5F + y * (-0.16666667F +
                                       y * (0.041666667F + y * (-0.0083333333F + y * 0.00130F)))));
}

/// When two rows are compatible: their lengths differ by less than `limit`, and their height
/// differences by less than `height` plus `slope` times the length.
struct Compatibility {
  float limit = 0.0F;
  float height = 0.0F;
  float slope = 0.0F;
};

/// Sum of compatibility weights of row a with all rows.
float RowReliability(const PointArrays& q, const PointArrays& p, std::size_t a,
                     const Compatibility& rule, float inverse_6l2) {
  const float qx = q.x[a], qy = q.y[a], qz = q.z[a];
  const float px = p.x[a], py = p.y[a], pz = p.z[a];
  const std::size_t n = q.x.size();
  float sum = 0.0F;
  // Fixed blocks of partial sums: the same additions in the same order on every machine.
  constexpr std::size_t kLanes = 8;
  float lanes[kLanes] = {};
  const auto weight = [&](std::size_t b) {
    const float ux = q.x[b] - qx, uy = q.y[b] - qy, uz = q.z[b] - qz;
    const float vx = p.x[b] - px, vy = p.y[b] - py, vz = p.z[b] - pz;
    const float squared_q = ux * ux + uy * uy + uz * uz;
    const float squared_p = vx * vx + vy * vy + vz * vz;
    const float length = std::sqrt(squared_q);
    const float x = std::abs(length - std::sqrt(squared_p));
    const bool level = std::abs(uz - vz) < rule.height + rule.slope * length;
    const bool compatible = (x < rule.limit) & (squared_q > 0.0F) & (squared_p > 0.0F) & level;
    return compatible ? ExpNegative(x * x * inverse_6l2) : 0.0F;
  };
  std::size_t b = 0;
  for (; b + kLanes <= n; b += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += weight(b + lane);
  }
  for (const float lane : lanes) sum += lane;
  for (; b < n; ++b) sum += weight(b);
  return sum;
}

}  // namespace

ReliableNodes SelectReliableNodes(const Correspondences& c, const NodeReliabilityOptions& options,
                                  const ExecutionContext& context) {
  ReliableNodes result;
  if (c.size() == 0) return result;
  const PointArrays q(c.source);
  const PointArrays p(c.target);
  const auto l = static_cast<float>(options.resolution_m);
  Compatibility rule{2.0F * l, std::numeric_limits<float>::infinity(), 0.0F};
  if (options.upright) {
    rule.height = 2.0F * l;
    rule.slope = static_cast<float>(options.upright->max_tilt_rad);
  }
  result.reliability.resize(c.size());
  context.ParallelFor(
      c.size(),
      [&](std::size_t a) {
        result.reliability[a] = RowReliability(q, p, a, rule, 1.0F / (6.0F * l * l));
      },
      64);

  result.rows.resize(c.size());
  std::iota(result.rows.begin(), result.rows.end(), 0U);
  std::stable_sort(result.rows.begin(), result.rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return result.reliability[a] > result.reliability[b];
  });
  result.rows.resize(std::min(result.rows.size(), static_cast<std::size_t>(options.keep)));
  return result;
}

}  // namespace backsight
