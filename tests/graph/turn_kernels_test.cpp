#include "graph/turn_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "graph/turn_measure.h"
#include "tests/support/instruction_sets.h"

namespace backsight {
namespace {

constexpr double kLimit = 0.2;

/// Rows about an edge, and the axes of a frame turned at random in either cloud.
struct Scene {
  explicit Scene(std::uint64_t seed) {
    Random random(seed);
    const auto vector = [&](double size) {
      return Eigen::Vector3d(size * random.Normal(), size * random.Normal(),
                             size * random.Normal());
    };
    const auto rotation = [&] {
      return Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), random.Normal())
          .normalized()
          .toRotationMatrix();
    };
    source_axes = rotation();
    target_axes = rotation();
    shift_m = 0.05 * random.Normal();
    for (std::size_t row = 0; row < 150 + seed; ++row) {
      // Within a metre of the edge, or far from it; off by less than the limit or by more.
      Eigen::Vector3d p = vector(row % 3 == 0 ? 0.1 : 10.0);
      if (row % 7 == 0) p.head<2>().setZero();  // on the edge
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(random.Uniform(0.0, 6.28), Eigen::Vector3d::UnitZ()).toRotationMatrix();
      source.push_back(source_axes * p);
      target.push_back(target_axes * (turn * p + vector(0.12)));
    }
  }

  EdgeFrame Frame() const {
    const auto axis = [](const Eigen::Matrix3d& axes, Eigen::Index k) {
      return EdgeFrame::Axis{axes(0, k), axes(1, k), axes(2, k)};
    };
    return {axis(source_axes, 2),
            axis(source_axes, 0),
            axis(source_axes, 1),
            axis(target_axes, 2),
            axis(target_axes, 0),
            axis(target_axes, 1),
            shift_m};
  }
  /// The distance of a row's points after the edge was moved onto its target and turned.
  double Residual(std::size_t row, double angle) const {
    const Eigen::Vector3d moved = source_axes.transpose() * source[row];
    const Eigen::Vector3d turned =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() * moved;
    return (turned + shift_m * Eigen::Vector3d::UnitZ() - target_axes.transpose() * target[row])
        .norm();
  }
  bool LiesAlike(std::size_t row) const {
    return std::abs(source[row].norm() - target[row].norm()) < kLimit &&
           std::abs(source[row].dot(source_axes.col(2)) - target[row].dot(target_axes.col(2))) <
               kLimit;
  }

  Eigen::Matrix3d source_axes, target_axes;  // columns u, v, along
  double shift_m = 0.0;
  std::vector<Eigen::Vector3d> source, target;
};

struct Found {
  std::vector<std::uint32_t> places;
  std::vector<double> begins, ends;
  bool operator==(const Found&) const = default;
};

Found Find(const Scene& scene) {
  const std::size_t rows = scene.source.size();
  std::vector<double> columns[6];
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const auto& p : scene.source) columns[axis].push_back(p[axis]);
    for (const auto& p : scene.target) columns[axis + 3].push_back(p[axis]);
  }
  for (auto& column : columns) column.resize(rows + kTurnPadding);
  Found found{std::vector<std::uint32_t>(rows), std::vector<double>(rows),
              std::vector<double>(rows)};
  const std::size_t count =
      FindTurns({{columns[0].data(), columns[1].data(), columns[2].data()},
                 {columns[3].data(), columns[4].data(), columns[5].data()},
                 rows},
                scene.Frame(), kLimit, found.places.data(), found.begins.data(), found.ends.data());
  found.places.resize(count);
  found.begins.resize(count);
  found.ends.resize(count);
  return found;
}

TEST(TurnKernels, ArcsHoldTheRotationsThatSatisfyARow) {
  std::size_t partial = 0, all_round = 0, none = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene(seed);
    const Found found = Find(scene);
    std::size_t next = 0;
    for (std::uint32_t row = 0; row < scene.source.size(); ++row) {
      const bool has_arc = next < found.places.size() && found.places[next] == row;
      TurnArc arc;
      if (has_arc) arc = {found.begins[next], found.ends[next], 0};
      next += has_arc ? 1 : 0;
      partial += has_arc && arc.end - arc.begin < kFullTurn ? 1 : 0;
      all_round += has_arc && arc.end - arc.begin == kFullTurn ? 1 : 0;
      none += has_arc ? 0 : 1;
      if (has_arc) {
        EXPECT_TRUE(scene.LiesAlike(row));
        EXPECT_GE(arc.begin, 0.0);
        EXPECT_LT(arc.begin, kFullTurn);
        EXPECT_GE(arc.end, arc.begin);
        EXPECT_LE(arc.end, arc.begin + kFullTurn);
      }
      if (!scene.LiesAlike(row)) continue;
      for (double angle = 0.001; angle < 6.28; angle += 0.01) {
        const double residual = scene.Residual(row, angle);
        if (std::abs(residual - kLimit) < 1e-9) continue;
        const bool inside = has_arc && Contains(arc, TurnOf(std::cos(angle), std::sin(angle)));
        ASSERT_EQ(inside, residual < kLimit) << seed << " " << row << " " << angle;
      }
    }
    EXPECT_EQ(next, found.places.size());
  }
  EXPECT_GT(partial, 200U);
  EXPECT_GT(all_round, 50U);
  EXPECT_GT(none, 200U);
}

TEST(TurnKernels, TheSameBitsWithEveryInstructionSet) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene(seed);
    const Found expected = Find(scene);
    ForEachInstructionSet(
        [&](const std::string& name) { EXPECT_EQ(Find(scene), expected) << name; });
  }
}

}  // namespace
}  // namespace backsight
