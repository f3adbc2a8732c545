#include "stages/dominant_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace backsight {
namespace {

using Normals = std::vector<Eigen::Vector3d>;

constexpr std::size_t kFewest = 10;

Normals Sample(std::span<const Eigen::Vector3f> normals) {
  constexpr std::size_t kMost = 4000;
  const std::size_t stride = std::max<std::size_t>(1, normals.size() / kMost);
  Normals sample;
  for (std::size_t i = 0; i < normals.size(); i += stride) {
    if (normals[i].allFinite()) sample.push_back(normals[i].cast<double>().normalized());
  }
  return sample;
}

/// The direction that most normals have within 10 deg, either way: the best of some of the normals
/// themselves, then the mean of those around it.
Eigen::Vector3d CommonDirection(const Normals& normals) {
  constexpr double kNear = 0.985;
  constexpr std::size_t kTried = 200;
  const std::size_t stride = std::max<std::size_t>(1, normals.size() / kTried);
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  std::ptrdiff_t most = 0;
  for (std::size_t i = 0; i < normals.size(); i += stride) {
    const auto near = std::count_if(normals.begin(), normals.end(), [&](const Eigen::Vector3d& n) {
      return std::abs(n.dot(normals[i])) > kNear;
    });
    if (near > most) {
      most = near;
      best = normals[i];
    }
  }
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& n : normals) {
    if (std::abs(n.dot(best)) > kNear) moment += n * n.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moment).eigenvectors().col(2);
}

/// Most common angle modulo a quarter turn, and the share of all within 5 deg of it.
std::pair<double, double> CommonQuarterAngle(const std::vector<double>& angles) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  constexpr std::size_t kBins = 90;
  std::array<int, kBins> histogram{};
  const auto bin_of = [](double angle) {
    const double turns = angle / kQuarter;
    return std::min(static_cast<std::size_t>((turns - std::floor(turns)) * kBins), kBins - 1);
  };
  for (const double angle : angles) ++histogram[bin_of(angle)];
  std::size_t best = 0;
  int most = -1;
  for (std::size_t b = 0; b < kBins; ++b) {
    const int around =
        histogram[(b + kBins - 1) % kBins] + histogram[b] + histogram[(b + 1) % kBins];
    if (around > most) {
      most = around;
      best = b;
    }
  }
  const double peak = (static_cast<double>(best) + 0.5) * kQuarter / kBins;
  constexpr double kNear = 5.0 * std::numbers::pi / 180.0;
  double sum = 0.0;
  double near = 0.0;
  for (const double angle : angles) {
    const double off = std::remainder(angle - peak, kQuarter);
    if (std::abs(off) > kNear) continue;
    sum += off;
    near += 1.0;
  }
  return {peak + sum / std::max(near, 1.0), near / static_cast<double>(angles.size())};
}

}  // namespace

std::vector<Eigen::Matrix3d> CubeTurns() {
  std::vector<Eigen::Matrix3d> turns;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        turn(axis, order[static_cast<std::size_t>(axis)]) = (signs >> axis & 1) != 0 ? -1.0 : 1.0;
      }
      if (turn.determinant() > 0.0) turns.push_back(turn);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return turns;
}

DominantFrame FindDominantFrame(std::span<const Eigen::Vector3f> normals,
                                const std::optional<Eigen::Vector3d>& up) {
  DominantFrame frame;
  const Normals sample = Sample(normals);
  if (sample.size() < kFewest) return frame;
  const Eigen::Vector3d first = up ? up->normalized() : CommonDirection(sample);
  const Eigen::Vector3d start = first.unitOrthogonal();
  const Eigen::Vector3d across = first.cross(start);
  constexpr double kAcross = 0.26;  // sine of 15 deg
  std::vector<double> angles;
  for (const Eigen::Vector3d& n : sample) {
    if (std::abs(n.dot(first)) < kAcross) angles.push_back(std::atan2(n.dot(across), n.dot(start)));
  }
  double angle = 0.0;
  if (angles.size() >= kFewest) std::tie(angle, frame.wall_share) = CommonQuarterAngle(angles);
  const Eigen::Vector3d second = std::cos(angle) * start + std::sin(angle) * across;
  frame.frame_from_cloud.row(0) = second;
  frame.frame_from_cloud.row(1) = first.cross(second);
  frame.frame_from_cloud.row(2) = first;
  return frame;
}

}  // namespace backsight
