#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace backsight {

/// At most `most` of the normals that are defined, ascending and spread over their order: all if
/// they are no more, otherwise each with a chance that grows with its leverage n^T N^-1 n, N the sum
/// of all n n^T. So directions that few of them have keep most of them, while walls and ground,
/// of which there is plenty, are thinned (after Rusinkiewicz and Levoy 2001,
/// doi 10.1109/IM.2001.924423). Turning all normals changes nothing. O(n).
std::vector<std::uint32_t> ChooseSurfaces(std::span<const Eigen::Vector3f> normals,
                                          std::size_t most);

}  // namespace backsight
