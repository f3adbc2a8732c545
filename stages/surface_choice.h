#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace backsight {

/// At most `most` of the normals that are defined, ascending and spread over their order: all if
/// they are no more, otherwise shares that grow with the leverage n^T N^-1 n, N the sum of all n
/// n^T and a hundredth of their number along every axis, so that noise of one plane is not
/// favoured. So directions that few of them have keep most of them, while walls and ground, of
/// which there is plenty, are thinned (after Rusinkiewicz and Levoy 2001,
/// doi 10.1109/IM.2001.924423). Turning all normals changes nothing. O(n).
std::vector<std::uint32_t> ChooseSurfaces(std::span<const Eigen::Vector3f> normals,
                                          std::size_t most);

}  // namespace backsight
