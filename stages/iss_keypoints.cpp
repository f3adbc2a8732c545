#include "stages/iss_keypoints.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <span>

namespace backsight {
namespace {

constexpr std::array kTries = {1.0, 0.75, 0.5, 0.375};  // of the largest suppression radius

/// Scatter about (x0, y0, z0). In double, because saliencies of neighbours are compared and the
/// smallest eigenvalue is a small part of the sums.
Eigen::Matrix3d ScatterAbout(float x0, float y0, float z0, const BallSearch& search,
                             std::span<const std::uint32_t> neighbors) {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  for (const std::uint32_t j : neighbors) {
    const double x = static_cast<double>(search.Axis(0)[j]) - x0;
    const double y = static_cast<double>(search.Axis(1)[j]) - y0;
    const double z = static_cast<double>(search.Axis(2)[j]) - z0;
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
  }
  Eigen::Matrix3d scatter;
  scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return scatter;
}

double Saliency(const Eigen::Matrix3d& scatter, const IssParameters& parameters) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& e = solver.eigenvalues();  // ascending
  const bool salient =
      e[0] > 0.0 && e[1] / e[2] < parameters.gamma_21 && e[0] / e[1] < parameters.gamma_32;
  return salient ? e[0] : 0.0;
}

/// Saliencies by place.
std::vector<double> Saliencies(const LeafGrid& grid, const IssParameters& parameters,
                               const ExecutionContext& context) {
  std::vector<double> saliencies(grid.size(), 0.0);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, parameters.salient_radius_m);
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search.EnterCell(cell);
      const LeafGrid::Range places = grid.Cell(cell);
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        const auto neighbors = search.Around(place);
        if (static_cast<int>(neighbors.size()) < parameters.min_neighbors) continue;
        saliencies[place] = Saliency(ScatterAbout(grid.Axis(0)[place], grid.Axis(1)[place],
                                                  grid.Axis(2)[place], search, neighbors),
                                     parameters);
      }
    }
  });
  return saliencies;
}

/// Positions in ascending order of value; equal values share one, 0 stays 0. Integers compare four
/// at a time where doubles compare two.
std::vector<std::int32_t> Ranks(const std::vector<double>& values) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    if (values[i] > 0.0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return values[a] < values[b]; });
  std::vector<std::int32_t> ranks(values.size() + LeafGrid::kPadding, 0);
  std::int32_t rank = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || values[order[k - 1]] < values[order[k]]) ++rank;
    ranks[order[k]] = rank;
  }
  return ranks;
}

/// Squared distance to the nearest candidate of higher rank; infinite if there is none.
float SquaredIsolation(std::span<const float> squared, const std::vector<std::int32_t>& ranks,
                       std::int32_t rank) {
  // Distances that are not negative order like their bits, and integer minima are vectorised.
  auto nearest = std::bit_cast<std::int32_t>(std::numeric_limits<float>::infinity());
  for (std::size_t j = 0; j < squared.size(); ++j) {
    const auto bits = std::bit_cast<std::int32_t>(squared[j]);
    const std::int32_t candidate =
        ranks[j] > rank ? bits : std::numeric_limits<std::int32_t>::max();
    nearest = std::min(nearest, candidate);
  }
  return std::bit_cast<float>(nearest);
}

/// Bit t: the point is a key point in try t. One pass serves all tries: a point stands in those
/// whose radius does not reach the nearest more salient point.
std::uint8_t TriesPassed(std::span<const float> squared, float squared_isolation,
                         const IssParameters& parameters) {
  std::uint8_t passed = 0;
  for (std::size_t t = 0; t < kTries.size(); ++t) {
    const double radius_m = kTries[t] * parameters.non_max_radius_m;
    const auto squared_radius = static_cast<float>(radius_m * radius_m);
    if (squared_isolation < squared_radius) continue;
    const auto neighbors =
        std::count_if(squared.begin(), squared.end(), [&](float d) { return d < squared_radius; });
    if (neighbors >= parameters.min_neighbors) passed |= static_cast<std::uint8_t>(1U << t);
  }
  return passed;
}

/// True if a point of the same cell suppresses this one in every try. Most points fall here,
/// without a look at all their neighbours.
bool SuppressedInCell(const LeafGrid& grid, LeafGrid::Range cell, std::uint32_t place,
                      const std::vector<std::int32_t>& ranks, double radius_m) {
  const auto squared_radius = static_cast<float>(radius_m * radius_m);
  for (std::uint32_t other = cell.begin; other < cell.end; ++other) {
    if (ranks[other] <= ranks[place]) continue;
    const float dx = grid.Axis(0)[other] - grid.Axis(0)[place];
    const float dy = grid.Axis(1)[other] - grid.Axis(1)[place];
    const float dz = grid.Axis(2)[other] - grid.Axis(2)[place];
    if (dx * dx + dy * dy + dz * dz < squared_radius) return true;
  }
  return false;
}

/// TriesPassed by point.
std::vector<std::uint8_t> Suppress(const LeafGrid& grid, const std::vector<std::int32_t>& ranks,
                                   const IssParameters& parameters,
                                   const ExecutionContext& context) {
  const double smallest_radius_m = kTries.back() * parameters.non_max_radius_m;
  std::vector<std::uint8_t> passed(grid.size(), 0);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, parameters.non_max_radius_m);
    std::vector<std::int32_t> candidate_ranks;
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search.EnterCell(cell);
      search.Gather(ranks, 0, &candidate_ranks);
      const LeafGrid::Range places = grid.Cell(cell);
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        if (ranks[place] == 0 || SuppressedInCell(grid, places, place, ranks, smallest_radius_m)) {
          continue;
        }
        const auto squared = search.SquaredDistances(place);
        const float isolation = SquaredIsolation(squared, candidate_ranks, ranks[place]);
        passed[grid.LeafAt(place)] = TriesPassed(squared, isolation, parameters);
      }
    }
  });
  return passed;
}

}  // namespace

std::vector<std::uint32_t> FindIssKeypoints(const LeafGrid& grid, const IssParameters& parameters,
                                            const ExecutionContext& context) {
  const auto ranks = Ranks(Saliencies(grid, parameters, context));
  context.CheckStop();
  const auto passed = Suppress(grid, ranks, parameters, context);
  std::vector<std::uint32_t> keypoints;
  for (std::size_t t = 0; t < kTries.size(); ++t) {
    keypoints.clear();
    for (std::uint32_t i = 0; i < passed.size(); ++i) {
      if ((passed[i] >> t & 1U) != 0) keypoints.push_back(i);
    }
    if (static_cast<int>(keypoints.size()) >= parameters.keypoints) break;
  }
  return keypoints;
}

}  // namespace backsight
