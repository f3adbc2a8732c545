#include "stages/normals.h"

#include <limits>

#include "graph/symmetric_eigen.h"
#include "stages/neighborhood_moments.h"

namespace backsight {
namespace {

std::array<double, 6> ScatterAboutMean(const NeighborhoodMoments& m) {
  const double per_point = 1.0 / m.count;
  return {m.xx - m.x * m.x * per_point, m.xy - m.x * m.y * per_point, m.xz - m.x * m.z * per_point,
          m.yy - m.y * m.y * per_point, m.yz - m.y * m.z * per_point, m.zz - m.z * m.z * per_point};
}

/// Normals of the cells of one run after another.
class NormalEstimator {
 public:
  NormalEstimator(const LeafGrid& grid, double radius_m) : grid_(grid), search_(grid, radius_m) {}

  void Estimate(LeafGrid::Range cells, std::vector<Eigen::Vector3f>* normals) {
    const std::uint32_t first = grid_.Cell(cells.begin).begin;
    scatters_.Resize(grid_.Cell(cells.end - 1).end - first);
    counts_.resize(scatters_.count);
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search_.EnterCell(cell);
      const LeafGrid::Range places = grid_.Cell(cell);
      for (std::uint32_t place = places.begin; place < places.end; ++place) {
        const NeighborhoodMoments moments =
            SumMoments(search_.Candidates(), grid_.At(place), search_.squared_radius());
        scatters_.Set(place - first, ScatterAboutMean(moments));
        counts_[place - first] = moments.count;
      }
    }
    const std::vector<Eigen::Vector3d> directions = LeastDirections(scatters_);
    for (std::uint32_t i = 0; i < scatters_.count; ++i) {
      if (counts_[i] >= 3) (*normals)[grid_.LeafAt(first + i)] = directions[i].cast<float>();
    }
  }

 private:
  const LeafGrid& grid_;
  BallSearch search_;
  SymmetricColumns scatters_;
  std::vector<std::uint32_t> counts_;
};

}  // namespace

std::vector<Eigen::Vector3f> EstimateNormals(const LeafGrid& grid, double radius_m,
                                             const ExecutionContext& context) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::vector<Eigen::Vector3f> normals(grid.size(), Eigen::Vector3f::Constant(kNaN));
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    NormalEstimator(grid, radius_m).Estimate(cells, &normals);
  });
  return normals;
}

}  // namespace backsight
