#include "stages/iss_keypoints.h"

#include <algorithm>
#include <array>
#include <span>

#include "graph/symmetric_eigen.h"
#include "stages/neighborhood_moments.h"

namespace backsight {
namespace {

constexpr std::array kTries = {1.0, 0.75, 0.5, 0.375};  // of the largest suppression radius

/// Saliencies of the cells of one run after another.
class SaliencyComputer {
 public:
  SaliencyComputer(const LeafGrid& grid, const IssParameters& parameters)
      : grid_(grid), parameters_(parameters), search_(grid, parameters.salient_radius_m) {}

  void Compute(LeafGrid::Range cells, std::vector<double>* saliencies) {
    const std::uint32_t first = grid_.Cell(cells.begin).begin;
    scatters_.Resize(grid_.Cell(cells.end - 1).end - first);
    counts_.resize(scatters_.count);
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search_.EnterCell(cell);
      const LeafGrid::Range places = grid_.Cell(cell);
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        const NeighborhoodMoments m =
            SumMoments(search_.Candidates(), grid_.At(place), search_.squared_radius());
        scatters_.Set(place - first, {m.xx, m.xy, m.xz, m.yy, m.yz, m.zz});
        counts_[place - first] = static_cast<int>(m.count);
      }
    }
    FindEigenvalues(scatters_, &eigenvalues_);
    for (std::size_t i = 0; i < scatters_.count; ++i) (*saliencies)[first + i] = Saliency(i);
  }

 private:
  double Saliency(std::size_t i) const {
    const auto& [low, middle, high] = eigenvalues_;
    const bool salient = counts_[i] >= parameters_.min_neighbors && low[i] > 0.0 &&
                         middle[i] / high[i] < parameters_.gamma_21 &&
                         low[i] / middle[i] < parameters_.gamma_32;
    return salient ? low[i] : 0.0;
  }

  const LeafGrid& grid_;
  const IssParameters& parameters_;
  BallSearch search_;
  SymmetricColumns scatters_;
  std::vector<int> counts_;
  EigenvalueColumns eigenvalues_;
};

/// Saliencies by place, padded by 0.
std::vector<double> Saliencies(const LeafGrid& grid, const IssParameters& parameters,
                               const ExecutionContext& context) {
  std::vector<double> saliencies(grid.size() + LeafGrid::kPadding, 0.0);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    SaliencyComputer(grid, parameters).Compute(cells, &saliencies);
  });
  return saliencies;
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
                      const std::vector<double>& saliencies, double radius_m) {
  const auto squared_radius = static_cast<float>(radius_m * radius_m);
  for (std::uint32_t other = cell.begin; other < cell.end; ++other) {
    if (saliencies[other] <= saliencies[place]) continue;
    const float dx = grid.Axis(0)[other] - grid.Axis(0)[place];
    const float dy = grid.Axis(1)[other] - grid.Axis(1)[place];
    const float dz = grid.Axis(2)[other] - grid.Axis(2)[place];
    if (dx * dx + dy * dy + dz * dz < squared_radius) return true;
  }
  return false;
}

/// TriesPassed by point.
std::vector<std::uint8_t> Suppress(const LeafGrid& grid, const std::vector<double>& saliencies,
                                   const IssParameters& parameters,
                                   const ExecutionContext& context) {
  const double smallest_radius_m = kTries.back() * parameters.non_max_radius_m;
  std::vector<std::uint8_t> passed(grid.size(), 0);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, parameters.non_max_radius_m);
    std::vector<double> others;
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      const LeafGrid::Range places = grid.Cell(cell);
      bool entered = false;
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        if (saliencies[place] == 0.0 ||
            SuppressedInCell(grid, places, place, saliencies, smallest_radius_m)) {
          continue;
        }
        if (!entered) {
          search.EnterCell(cell);
          search.Gather(saliencies, 0.0, &others);
          entered = true;
        }
        const float isolation = SquaredDistanceToGreater(search.Candidates(), others.data(),
                                                         grid.At(place), saliencies[place]);
        if (isolation < static_cast<float>(smallest_radius_m * smallest_radius_m)) continue;
        passed[grid.LeafAt(place)] =
            TriesPassed(search.SquaredDistances(place), isolation, parameters);
      }
    }
  });
  return passed;
}

}  // namespace

std::vector<std::uint32_t> FindIssKeypoints(const LeafGrid& grid, const IssParameters& parameters,
                                            const ExecutionContext& context) {
  const auto saliencies = Saliencies(grid, parameters, context);
  context.CheckStop();
  const auto passed = Suppress(grid, saliencies, parameters, context);
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
