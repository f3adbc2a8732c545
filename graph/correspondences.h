#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace backsight {

/// Putative point correspondences, row a: source point q_a (to be moved) and target point p_a, each
/// in its own station frame, metres. A key point may take part in several rows; its id tells so.
struct Correspondences {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
  std::vector<std::uint32_t> source_id;
  std::vector<std::uint32_t> target_id;

  std::size_t size() const { return source.size(); }
  void Add(const Eigen::Vector3d& q, const Eigen::Vector3d& p, std::uint32_t q_id,
           std::uint32_t p_id) {
    source.push_back(q), target.push_back(p), source_id.push_back(q_id), target_id.push_back(p_id);
  }
  Correspondences Subset(std::span<const std::uint32_t> rows) const {
    Correspondences subset;
    for (const std::uint32_t a : rows) {
      subset.Add(source[a], target[a], source_id[a], target_id[a]);
    }
    return subset;
  }
};

}  // namespace backsight
