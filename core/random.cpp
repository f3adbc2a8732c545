#include "core/random.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/fingerprint.h"

namespace backsight {

double Random::Normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform());
}

Eigen::Matrix3d Random::Rotation() {
  const double u = Uniform();
  const double a = 2.0 * std::numbers::pi * Uniform();
  const double b = 2.0 * std::numbers::pi * Uniform();
  const double r = std::sqrt(1.0 - u);
  const double s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b))
      .toRotationMatrix();
}

std::uint64_t DeriveSeed(std::uint64_t seed, std::string_view name) {
  Fingerprint fingerprint;
  fingerprint.Add(seed);
  fingerprint.Add(name);
  return fingerprint.Value64();
}

}  // namespace backsight
