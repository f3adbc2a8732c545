#include "tests/support/synthetic_network.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "graph/network_covariance.h"
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

/// A link between stations i and j, either way round, off by a draw from its covariance.
PoseGraphLink MeasureLink(Random& random, const SyntheticNetwork& network, int i, int j,
                          double noise) {
  PoseGraphLink link;
  link.source = i, link.target = j;
  if (random.Uniform() < 0.5) std::swap(link.source, link.target);
  const Matrix6d root = RandomCovarianceRoot(random);
  Vector6d draw;
  for (double& x : draw) x = noise * random.Normal();
  const auto pose = [&](int s) { return network.survey_from_station[static_cast<std::size_t>(s)]; };
  link.target_from_source = Retract(pose(link.target).Inverse() * pose(link.source), root * draw);
  const double factor = noise > 0.0 ? noise * noise : 1.0;
  link.information = (factor * root * root.transpose()).inverse();
  link.information = 0.5 * (link.information + link.information.transpose().eval());
  link.confidence = random.Uniform(1.0, 2.0);
  return link;
}

RigidTransform AboutVertical(double angle, const Eigen::Vector3d& centre) {
  const Eigen::Matrix3d turn = ExpSo3({0.0, 0.0, angle});
  return {turn, centre - turn * centre};
}

/// As if station 0 were the datum.
void MoveToFirst(SyntheticNetwork* network) {
  const RigidTransform first = network->survey_from_station.front().Inverse();
  for (RigidTransform& pose : network->survey_from_station) pose = first * pose;
}

}  // namespace

SyntheticNetwork MakeNetwork(std::uint64_t seed, int stations, double density, double noise) {
  Random random(seed);
  SyntheticNetwork network;
  for (int s = 0; s < stations; ++s) {
    network.survey_from_station.push_back(s == 0 ? RigidTransform{}
                                                 : RandomTransform(random, 30.0));
  }
  for (int i = 0; i < stations; ++i) {
    for (int j = i + 1; j < stations; ++j) {
      if (j != i + 1 && random.Uniform() >= density) continue;
      network.links.push_back(MeasureLink(random, network, i, j, noise));
    }
  }
  return network;
}

SyntheticNetwork MakeTown(std::uint64_t seed, int stations, int links_per_station, double noise) {
  Random random(seed);
  SyntheticNetwork network;
  const int columns = std::max(2, static_cast<int>(std::sqrt(static_cast<double>(stations))));
  for (int s = 0; s < stations; ++s) {
    const Eigen::Vector3d place(20.0 * (s % columns) + random.Uniform(-4.0, 4.0),
                                20.0 * (s / columns) + random.Uniform(-4.0, 4.0),
                                random.Uniform(-1.0, 1.0));
    const Eigen::Vector3d tilt(0.01 * random.Normal(), 0.01 * random.Normal(), 0.0);
    const double heading = random.Uniform(-3.1, 3.1);
    network.survey_from_station.push_back({ExpSo3(tilt) * ExpSo3({0.0, 0.0, heading}), place});
  }
  MoveToFirst(&network);
  std::vector<std::pair<double, std::pair<int, int>>> pairs;
  for (int i = 0; i < stations; ++i) {
    for (int j = i + 1; j < stations; ++j) {
      const double distance =
          (network.survey_from_station[static_cast<std::size_t>(i)].translation -
           network.survey_from_station[static_cast<std::size_t>(j)].translation)
              .norm();
      pairs.push_back({distance, {i, j}});
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.resize(std::min(pairs.size(), static_cast<std::size_t>(stations * links_per_station / 2)));
  for (const auto& [distance, ends] : pairs) {
    network.links.push_back(MeasureLink(random, network, ends.first, ends.second, noise));
  }
  return network;
}

PoseGraphLink Displaced(const PoseGraphLink& link, const SyntheticNetwork& network,
                        const RigidTransform& displacement) {
  PoseGraphLink displaced = link;
  const RigidTransform& source = network.survey_from_station[static_cast<std::size_t>(link.source)];
  displaced.target_from_source = link.target_from_source * source.Inverse() * displacement * source;
  return displaced;
}

SyntheticNetwork MakeHall(std::uint64_t seed, int stations, double lead, double score_noise) {
  SyntheticNetwork network = MakeNetwork(seed, stations, 1.0, 1.0);
  Random random(seed + 1000);
  const RigidTransform half_turn = AboutVertical(3.14159265358979323846, {3.0, -2.0, 0.0});
  std::vector<PoseGraphLink> links;
  for (std::size_t l = 0; l < network.links.size(); ++l) {
    PoseGraphLink link = network.links[l];
    link.pair = static_cast<int>(l);
    PoseGraphLink turned = Displaced(link, network, half_turn);
    link.score = 0.6 + lead + score_noise * random.Normal();
    turned.score = 0.6 + score_noise * random.Normal();
    links.push_back(link);
    links.push_back(turned);
  }
  network.links = std::move(links);
  return network;
}

std::vector<char> ReplaceByRandom(std::uint64_t seed, double share,
                                  std::vector<PoseGraphLink>* links) {
  Random random(seed);
  std::vector<char> is_false(links->size(), 0);
  std::map<int, int> true_links;
  for (const PoseGraphLink& link : *links) ++true_links[link.source], ++true_links[link.target];
  auto left = std::lround(share * static_cast<double>(links->size()));
  while (left > 0) {
    const std::size_t l = random.Index(links->size());
    PoseGraphLink& link = (*links)[l];
    int& of_source = true_links[link.source];
    int& of_target = true_links[link.target];
    if (is_false[l] != 0 || of_source <= 2 || of_target <= 2) continue;
    --of_source, --of_target;
    link.target_from_source = RandomTransform(random, 30.0);
    link.confidence = random.Uniform(1.0, 2.0);
    is_false[l] = 1;
    --left;
  }
  return is_false;
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

PoseGraphResult SolveWithCovariance(int stations, const std::vector<PoseGraphLink>& links) {
  PoseGraphResult graph = SolvePoseGraph(stations, links, {}, {.robust = false});
  const Eigen::MatrixXd joint = JointCovariance(
      links, graph.weights, FirstOfEachComponent(graph.component), graph.survey_from_station);
  for (int s = 0; s < stations; ++s) graph.covariance.push_back(joint.block<6, 6>(6 * s, 6 * s));
  return graph;
}

}  // namespace backsight
