#include "tests/support/synthetic_network.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tests/support/matchers.h"

namespace backsight {
namespace {

/// Square root of a random covariance with coupled rotation and translation.
Matrix6d RandomCovarianceRoot(Random& random) {
  Vector6d scale;
  scale << 3e-4, 3e-4, 3e-4, 3e-3, 3e-3, 3e-3;
  Matrix6d root = Matrix6d::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) root(i, j) += 0.15 * random.Normal();
  }
  return scale.asDiagonal() * root;
}

}  // namespace

SyntheticNetwork MakeNetwork(std::uint64_t seed, int stations, double density, double noise) {
  Random random(seed);
  SyntheticNetwork network;
  for (int s = 0; s < stations; ++s) {
    network.survey_from_station.push_back(s == 0 ? RigidTransform{}
                                                 : RandomTransform(random, 30.0));
  }
  const auto pose = [&](int s) { return network.survey_from_station[static_cast<std::size_t>(s)]; };
  for (int i = 0; i < stations; ++i) {
    for (int j = i + 1; j < stations; ++j) {
      if (j != i + 1 && random.Uniform() >= density) continue;
      PoseGraphLink link;
      link.source = i, link.target = j;
      if (random.Uniform() < 0.5) std::swap(link.source, link.target);
      const Matrix6d root = RandomCovarianceRoot(random);
      Vector6d draw;
      for (double& x : draw) x = noise * random.Normal();
      link.target_from_source =
          Retract(pose(link.target).Inverse() * pose(link.source), root * draw);
      const double factor = noise > 0.0 ? noise * noise : 1.0;
      link.information = (factor * root * root.transpose()).inverse();
      link.information = 0.5 * (link.information + link.information.transpose().eval());
      link.confidence = random.Uniform(1.0, 2.0);
      network.links.push_back(link);
    }
  }
  return network;
}

std::vector<char> FalsifyLinks(std::uint64_t seed, double share,
                               std::vector<PoseGraphLink>* links) {
  Random random(seed);
  std::vector<char> is_false(links->size(), 0);
  auto left = std::lround(share * static_cast<double>(links->size()));
  while (left > 0) {
    const std::size_t l = random.Index(links->size());
    PoseGraphLink& link = (*links)[l];
    if (is_false[l] != 0 || std::abs(link.source - link.target) == 1) continue;
    link.target_from_source = RandomTransform(random, 30.0);
    link.confidence = random.Uniform(1.0, 2.0);
    is_false[l] = 1;
    --left;
  }
  return is_false;
}

}  // namespace backsight
