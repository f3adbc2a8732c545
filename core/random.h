#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string_view>

namespace backsight {

/// Deterministic random numbers: the same seed gives the same sequence on every platform. The
/// distributions are our own because the standard library's may differ between implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [0, 1).
  double Uniform() { return static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Uniform integer in [0, n), n > 0.
  std::uint64_t Index(std::uint64_t n) { return engine_() % n; }
  /// Normal with mean 0 and standard deviation 1 (Box-Muller).
  double Normal();
  /// Uniformly distributed rotation on SO(3) (Shoemake 1992).
  Eigen::Matrix3d Rotation();

 private:
  std::mt19937_64 engine_;
};

/// A seed of its own for each named unit of work ("pair S1 S2"), independent of scheduling.
std::uint64_t DeriveSeed(std::uint64_t seed, std::string_view name);

}  // namespace backsight
