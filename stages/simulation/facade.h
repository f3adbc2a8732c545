#pragma once

#include <vector>

#include "core/random.h"
#include "io/scene_description.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// The surfaces a facade is made of.
struct FacadeMaterials {
  MaterialId wall = 0;
  MaterialId trim = 0;   ///< sills, cornices, pillars
  MaterialId frame = 0;  ///< window frames, pipes
  MaterialId glass = 0;
  MaterialId door = 0;
};

struct FacadeSpec {
  FacadeStyle style = FacadeStyle::kMasonry;
  double width_m = 10.0;
  std::vector<double> storeys_m;  ///< heights from the ground up
  double foundation_m = 0.6;      ///< how far the wall goes on below the ground
  double bay_m = 3.0;
  double window_depth_m = 0.2;
  int doors = 1;
  bool arches = false;      ///< the ground storey opens in arches instead of windows
  bool repeat = false;      ///< identical bays without details
  bool projections = true;  ///< cornices, pipes, balconies
};

/// Adds one wall with real recessed openings. Panel frame: origin at the lower left corner as the
/// viewer sees it, at ground level; x to the viewer's right, y into the wall, z up.
void AddFacade(const FacadeSpec& spec, const FacadeMaterials& materials,
               const RigidTransform& world_from_panel, Random& random, TriangleMesh& mesh);

}  // namespace backsight
