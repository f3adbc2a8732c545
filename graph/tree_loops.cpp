#include "graph/tree_loops.h"

#include <Eigen/Cholesky>
#include <limits>

#include "graph/cycle_consistency.h"

namespace backsight {
namespace {

/// A forest hung up at the first station of each tree, with the errors summed from there.
struct HungForest {
  std::vector<int> parent;
  std::vector<int> depth;
  std::vector<Matrix6d> covariance;  ///< of the pose's xi in the survey frame

  HungForest(int stations, std::span<const PoseGraphLink> links, const SpanningForest& forest)
      : parent(static_cast<std::size_t>(stations), -1),
        depth(static_cast<std::size_t>(stations), -1),
        covariance(static_cast<std::size_t>(stations), Matrix6d::Zero()) {
    std::vector<std::vector<int>> own(static_cast<std::size_t>(stations));
    for (const int l : forest.tree_links) {
      const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
      own[static_cast<std::size_t>(link.source)].push_back(l);
      own[static_cast<std::size_t>(link.target)].push_back(l);
    }
    std::vector<int> open;
    for (int root = 0; root < stations; ++root) {
      if (depth[static_cast<std::size_t>(root)] >= 0) continue;
      depth[static_cast<std::size_t>(root)] = 0;
      open.push_back(root);
      while (!open.empty()) {
        const auto here = static_cast<std::size_t>(open.back());
        open.pop_back();
        for (const int l : own[here]) {
          const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
          const int next = link.source == static_cast<int>(here) ? link.target : link.source;
          const auto n = static_cast<std::size_t>(next);
          if (depth[n] >= 0) continue;
          depth[n] = depth[here] + 1;
          parent[n] = static_cast<int>(here);
          const Matrix6d adjoint =
              Adjoint(forest.survey_from_station[static_cast<std::size_t>(link.target)]);
          covariance[n] =
              covariance[here] + adjoint * CovarianceOf(link.information) * adjoint.transpose();
          open.push_back(next);
        }
      }
    }
  }

  int Meet(int a, int b) const {
    while (a != b) {
      int& deeper =
          depth[static_cast<std::size_t>(a)] >= depth[static_cast<std::size_t>(b)] ? a : b;
      deeper = parent[static_cast<std::size_t>(deeper)];
    }
    return a;
  }
};

}  // namespace

std::vector<double> TreeLoopErrors(int stations, std::span<const PoseGraphLink> links,
                                   const SpanningForest& forest) {
  const HungForest tree(stations, links, forest);
  std::vector<double> errors;
  for (const PoseGraphLink& link : links) {
    const auto source = static_cast<std::size_t>(link.source);
    const auto target = static_cast<std::size_t>(link.target);
    if (forest.component[source] != forest.component[target]) {
      errors.push_back(std::numeric_limits<double>::infinity());
      continue;
    }
    const auto meet = static_cast<std::size_t>(tree.Meet(link.source, link.target));
    const RigidTransform& survey_from_target = forest.survey_from_station[target];
    const Matrix6d path =
        tree.covariance[source] + tree.covariance[target] - 2.0 * tree.covariance[meet];
    const Matrix6d adjoint = Adjoint(survey_from_target.Inverse());
    const Matrix6d covariance =
        CovarianceOf(link.information) + adjoint * path * adjoint.transpose();
    const Vector6d residual =
        LinkResidual(link, forest.survey_from_station[source], survey_from_target);
    errors.push_back(residual.dot(covariance.ldlt().solve(residual)));
  }
  for (const int l : forest.tree_links) errors[static_cast<std::size_t>(l)] = 0.0;
  return errors;
}

std::vector<Matrix6d> TreeCovariances(int stations, std::span<const PoseGraphLink> links,
                                      const SpanningForest& forest) {
  return HungForest(stations, links, forest).covariance;
}

}  // namespace backsight
