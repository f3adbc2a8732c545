#include "stages/simulation/tree_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace backsight {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

Eigen::Vector3d RandomDirection(Random& random) {
  return random.Rotation() * Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d RandomPlanDirection(Random& random) {
  const double heading = random.Uniform(0.0, kTwoPi);
  return {std::cos(heading), std::sin(heading), 0.0};
}

/// The stem: where its axis passes and how thick it is, by height above the ground.
class Stem {
 public:
  Stem(const Tree& tree, Random& random) : height_(tree.height_m) {
    base_radius_ = std::clamp(tree.height_m * random.Uniform(0.011, 0.019), 0.07, 0.4);
    lean_ = random.Uniform(0.0, 0.05) * RandomPlanDirection(random);
    bend_ = 0.012 * tree.height_m * RandomPlanDirection(random);
    bend_waves_ = random.Uniform(0.8, 2.2);
    for (Lobe& lobe : lobes_) {
      lobe.share = random.Uniform(0.02, 0.07);
      lobe.phase = random.Uniform(0.0, kTwoPi);
      lobe.twist = random.Uniform(-0.5, 0.5);
    }
    roots_ = 3.0 + static_cast<double>(random.Index(3));
    root_phase_ = random.Uniform(0.0, kTwoPi);
  }

  Eigen::Vector3d Axis(double z) const {
    const double wave = std::sin(kTwoPi * bend_waves_ * std::max(0.0, z) / height_);
    return z * lean_ + wave * bend_ + Eigen::Vector3d(0.0, 0.0, z);
  }

  double Radius(double z) const {
    return base_radius_ * std::max(0.08, 1.0 - 0.92 * std::max(0.0, z) / height_);
  }

  /// Radius in one direction: an irregular section that turns with height, and roots at the foot.
  double Radius(double z, double angle) const {
    double factor = 1.0;
    for (std::size_t i = 0; i < lobes_.size(); ++i) {
      const double turns = static_cast<double>(i) + 2.0;
      factor += lobes_[i].share * std::cos(turns * angle + lobes_[i].phase + lobes_[i].twist * z);
    }
    const double flare = std::exp(-std::max(0.0, z) / 0.35);
    factor += flare * (0.35 + 0.3 * std::cos(roots_ * angle + root_phase_));
    return Radius(z) * factor;
  }

 private:
  struct Lobe {
    double share = 0.0;
    double phase = 0.0;
    double twist = 0.0;  // radians per metre of height
  };
  double height_ = 0.0;
  double base_radius_ = 0.0;
  Eigen::Vector3d lean_;
  Eigen::Vector3d bend_;
  double bend_waves_ = 0.0;
  std::array<Lobe, 4> lobes_{};
  double roots_ = 0.0;
  double root_phase_ = 0.0;
};

void AddStem(const Stem& stem, double top, const Eigen::Vector3d& foot, MaterialId bark,
             TriangleMesh& mesh) {
  constexpr int kSides = 20;
  std::vector<double> heights = {-0.3, 0.0, 0.12, 0.3, 0.6};
  while (heights.back() < top) heights.push_back(std::min(top, heights.back() + 0.5));
  const auto at = [&](double z, int side) -> Eigen::Vector3d {
    const double angle = kTwoPi * side / kSides;
    return foot + stem.Axis(z) +
           stem.Radius(z, angle) * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  };
  for (std::size_t i = 0; i + 1 < heights.size(); ++i) {
    for (int side = 0; side < kSides; ++side) {
      AddQuad(at(heights[i], side), at(heights[i], side + 1), at(heights[i + 1], side + 1),
              at(heights[i + 1], side), bark, mesh);
    }
  }
}

/// A branch that rises less, the farther out it is, with twigs; returns where leaves may grow.
std::vector<Eigen::Vector3d> AddBranch(const Eigen::Vector3d& start, double reach, double radius,
                                       MaterialId bark, Random& random, TriangleMesh& mesh) {
  Eigen::Vector3d direction = RandomPlanDirection(random);
  direction.z() = random.Uniform(0.15, 0.9);
  direction.normalize();
  std::vector<Eigen::Vector3d> leafy;
  Eigen::Vector3d from = start;
  constexpr int kParts = 3;
  for (int part = 0; part < kParts; ++part) {
    const Eigen::Vector3d to = from + reach / kParts * direction;
    const double share = static_cast<double>(part) / kParts;
    AddTube(from, to, radius * (1.0 - 0.8 * share), radius * (0.75 - 0.8 * share + 0.1), 7, bark,
            mesh);
    const Eigen::Vector3d twig = to + 0.35 * reach * (direction + 0.8 * RandomDirection(random));
    AddTube(to, twig, 0.3 * radius, 0.006, 5, bark, mesh);
    if (part > 0) leafy.push_back(to);
    leafy.push_back(twig);
    direction =
        (direction + 0.35 * RandomDirection(random) - 0.12 * Eigen::Vector3d::UnitZ()).normalized();
    from = to;
  }
  return leafy;
}

void AddLeaves(const std::vector<Eigen::Vector3d>& clumps, double spread, int leaves,
               Random& random, TriangleMesh& mesh) {
  const double green = random.Uniform(0.35, 0.6);
  const MaterialId leaf = AddMaterial({0.45, {0.25, green, 0.15}, false}, mesh);
  for (int i = 0; i < leaves; ++i) {
    const Eigen::Vector3d& clump = clumps[random.Index(clumps.size())];
    const double distance = std::abs(random.Normal());
    const Eigen::Vector3d offset = RandomDirection(random);
    const Eigen::Vector3d middle = clump + spread * distance * offset;
    const Eigen::Matrix3d turn = random.Rotation();
    const double length = random.Uniform(0.04, 0.09);
    const Eigen::Vector3d u = length * turn.col(0);
    const Eigen::Vector3d v = 0.6 * length * turn.col(1);
    AddQuad(middle - u, middle - v, middle + u, middle + v, leaf, mesh);
  }
}

}  // namespace

void AddTree(const Tree& tree, const GroundModel& ground, Random& random, TriangleMesh& mesh) {
  const MaterialId bark = AddMaterial({0.3, {0.35, 0.28, 0.2}, false}, mesh);
  const Stem stem(tree, random);
  const Eigen::Vector3d foot = ground.At(tree.position_m);
  const double height = tree.height_m;
  // A crown begins at 2 to 3 m in a street, and at 0.4 of the height in a stand of tall trees.
  const double crown_base =
      std::min(0.4 * height, std::max(2.4, 0.4 * height - 1.0)) * random.Uniform(0.85, 1.15);
  const double top = 0.93 * height;
  AddStem(stem, top, foot, bark, mesh);
  const int stubs = height > 10.0 ? 2 + static_cast<int>(random.Index(4)) : 0;
  for (int i = 0; i < stubs; ++i) {
    const double z = random.Uniform(1.0, crown_base);
    Eigen::Vector3d end = RandomPlanDirection(random);
    end.z() = random.Uniform(-0.2, 0.5);
    AddTube(foot + stem.Axis(z), foot + stem.Axis(z) + random.Uniform(0.3, 1.0) * end,
            0.2 * stem.Radius(z), 0.012, 6, bark, mesh);
  }
  std::vector<Eigen::Vector3d> clumps;
  const int branches = 10 + static_cast<int>(random.Index(7));
  for (int i = 0; i < branches; ++i) {
    const double share = (i + random.Uniform(0.0, 1.0)) / branches;
    const double z = crown_base + share * (top - crown_base);
    // The crown is widest in its lower third.
    const double profile = std::sin(std::numbers::pi * std::pow(0.12 + 0.88 * share, 0.7));
    const double reach = std::max(0.25, profile) * tree.crown_radius_m * random.Uniform(0.75, 1.1);
    const double radius = std::clamp(0.45 * stem.Radius(z), 0.012, 0.09);
    const auto leafy = AddBranch(foot + stem.Axis(z), reach, radius, bark, random, mesh);
    clumps.insert(clumps.end(), leafy.begin(), leafy.end());
  }
  AddLeaves(clumps, 0.22 * tree.crown_radius_m, tree.leaves, random, mesh);
}

}  // namespace backsight
