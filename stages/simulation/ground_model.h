#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "io/scene_description.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Height of the ground at every place: a plane, gentle undulation drawn from the seed, and raised
/// strips with kerbs. World frame, metres.
class GroundModel {
 public:
  GroundModel(const Ground& ground, std::uint64_t seed);

  /// The surface one stands on, strips included.
  double Height(const Eigen::Vector2d& place) const;
  Eigen::Vector3d At(const Eigen::Vector2d& place, double above_m = 0.0) const {
    return {place.x(), place.y(), Height(place) + above_m};
  }
  /// The surface below the strips.
  double BaseHeight(const Eigen::Vector2d& place) const;

 private:
  struct Wave {
    Eigen::Vector2d frequency;  // radians per metre
    double phase = 0.0;
  };

  Ground ground_;
  Eigen::Vector2d slope_;
  std::array<Wave, 3> waves_;
};

/// The ground's surface and its strips as triangles of about a metre.
void AddGround(const Ground& ground, const GroundModel& model, MaterialId surface, MaterialId strip,
               TriangleMesh& mesh);

}  // namespace backsight
