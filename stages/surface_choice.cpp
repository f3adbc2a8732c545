#include "stages/surface_choice.h"

#include <Eigen/LU>
#include <algorithm>

namespace backsight {
namespace {

/// Sum of n n^T, and a little in every direction: what hardly any normal has is noise.
Eigen::Matrix3d Scatter(std::span<const Eigen::Vector3f> normals,
                        const std::vector<std::uint32_t>& defined) {
  constexpr double kNoise = 0.01;  // of the normals
  Eigen::Matrix3d sum = kNoise * static_cast<double>(defined.size()) * Eigen::Matrix3d::Identity();
  for (const std::uint32_t i : defined) {
    const Eigen::Vector3d n = normals[i].cast<double>();
    sum += n * n.transpose();
  }
  return sum;
}

/// The factor c for which the sum of min(1, c leverage) is `most`, or a little less.
double ScaleFor(const std::vector<float>& leverages, std::size_t most) {
  double scale = 0.0;
  for (int round = 0; round < 5; ++round) {
    std::size_t certain = 0;
    double others = 0.0;
    for (const float leverage : leverages) {
      if (scale * leverage < 1.0) {
        others += leverage;
      } else {
        ++certain;
      }
    }
    if (certain >= most || !(others > 0.0)) break;
    scale = static_cast<double>(most - certain) / others;
  }
  return scale;
}

}  // namespace

std::vector<std::uint32_t> ChooseSurfaces(std::span<const Eigen::Vector3f> normals,
                                          std::size_t most) {
  std::vector<std::uint32_t> defined;
  defined.reserve(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i].allFinite()) defined.push_back(static_cast<std::uint32_t>(i));
  }
  if (defined.size() <= most) return defined;

  const Eigen::Matrix3f inverse = Scatter(normals, defined).inverse().cast<float>();
  std::vector<float> leverages;
  leverages.reserve(defined.size());
  for (const std::uint32_t i : defined) leverages.push_back(normals[i].dot(inverse * normals[i]));

  const double scale = ScaleFor(leverages, most);
  std::vector<std::uint32_t> chosen;
  chosen.reserve(most);
  double due = 0.0;
  for (std::size_t k = 0; k < defined.size(); ++k) {
    due += std::min(1.0, scale * leverages[k]);
    if (due < 1.0) continue;
    due -= 1.0;
    chosen.push_back(defined[k]);
  }
  return chosen;
}

}  // namespace backsight
