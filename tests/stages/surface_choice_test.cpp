#include "stages/surface_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/rigid_transform.h"

namespace backsight {
namespace {

enum Direction : std::size_t { kGround, kWall, kReveal, kDirections };
constexpr std::array<std::size_t, kDirections> kCounts = {50000, 9000, 1000};

struct Normals {
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::size_t> direction;
};

/// Ground, walls and reveals, each with some noise, in random order.
Normals MakeNormals(std::uint64_t seed, const Eigen::Matrix3d& turn) {
  Random random(seed);
  Normals made;
  for (std::size_t d = 0; d < kDirections; ++d) {
    made.direction.insert(made.direction.end(), kCounts[d], d);
  }
  for (std::size_t i = made.direction.size(); i > 1; --i) {
    const auto other = static_cast<std::size_t>(random.Uniform() * static_cast<double>(i));
    std::swap(made.direction[i - 1], made.direction[other]);
  }
  for (const std::size_t d : made.direction) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(2 - static_cast<Eigen::Index>(d));
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    made.normals.emplace_back((turn * (axis + 0.02 * noise).normalized()).cast<float>());
  }
  return made;
}

std::array<std::size_t, kDirections> CountByDirection(const Normals& of,
                                                      const std::vector<std::uint32_t>& chosen) {
  std::array<std::size_t, kDirections> counts{};
  for (const std::uint32_t i : chosen) ++counts[of.direction[i]];
  return counts;
}

TEST(ChooseSurfaces, GivesRareDirectionsTheirShareHoweverTheyAreTurned) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const Normals made = MakeNormals(seed, random.Rotation());
    const std::vector<std::uint32_t> chosen = ChooseSurfaces(made.normals, 9000);
    EXPECT_LE(chosen.size(), 9000U);
    EXPECT_GE(chosen.size(), 8900U);
    EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end(), std::less_equal<>()));
    const auto counts = CountByDirection(made, chosen);
    EXPECT_GE(counts[kReveal], 950U) << "nearly all there are";
    EXPECT_GT(counts[kWall], 3000U);
    EXPECT_GT(counts[kGround], 3000U);
  }
}

TEST(ChooseSurfaces, SpreadsWhatItTakesOfADirection) {
  const Normals made = MakeNormals(3, Eigen::Matrix3d::Identity());
  const std::vector<std::uint32_t> chosen = ChooseSurfaces(made.normals, 6000);
  const auto in_all = CountByDirection(made, chosen)[kGround];
  for (std::uint32_t part = 0; part < 6; ++part) {
    const auto of_ground = std::count_if(chosen.begin(), chosen.end(), [&](std::uint32_t i) {
      return i / 10000 == part && made.direction[i] == kGround;
    });
    EXPECT_NEAR(static_cast<double>(of_ground), static_cast<double>(in_all) / 6.0, 60.0);
  }
}

TEST(ChooseSurfaces, TakesAllOfAFewAndNothingUndefined) {
  Normals made = MakeNormals(4, Eigen::Matrix3d::Identity());
  made.normals.resize(1000);
  made.normals[17].fill(std::numeric_limits<float>::quiet_NaN());
  const std::vector<std::uint32_t> all = ChooseSurfaces(made.normals, 999);
  EXPECT_EQ(all.size(), 999U);
  for (const std::size_t most : {std::size_t{0}, std::size_t{1}, std::size_t{500}, all.size()}) {
    const std::vector<std::uint32_t> chosen = ChooseSurfaces(made.normals, most);
    EXPECT_LE(chosen.size(), most);
    EXPECT_GE(chosen.size() + 2, most);
    EXPECT_EQ(std::count(chosen.begin(), chosen.end(), 17U), 0);
  }
  EXPECT_TRUE(ChooseSurfaces({}, 10).empty());
  std::fill(made.normals.begin(), made.normals.end(), made.normals[17]);
  EXPECT_TRUE(ChooseSurfaces(made.normals, 10).empty()) << "all undefined";
}

TEST(ChooseSurfaces, DoesNotTakeNoiseOfOnePlaneForDirections) {
  Random random(5);
  std::vector<Eigen::Vector3f> normals;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), 0.0);
    normals.emplace_back((Eigen::Vector3d::UnitZ() + 0.01 * noise).normalized().cast<float>());
  }
  const auto tilt = [](const Eigen::Vector3f& n) { return std::hypot(n.x(), n.y()); };
  double of_all = 0.0;
  for (const Eigen::Vector3f& n : normals) of_all += tilt(n) / 20000.0;
  const std::vector<std::uint32_t> chosen = ChooseSurfaces(normals, 2000);
  double of_chosen = 0.0;
  for (const std::uint32_t i : chosen) {
    of_chosen += tilt(normals[i]) / static_cast<double>(chosen.size());
  }
  EXPECT_LT(of_chosen, 1.1 * of_all);
}

}  // namespace
}  // namespace backsight
