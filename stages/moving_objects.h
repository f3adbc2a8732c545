#pragma once

#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"

namespace backsight {

struct MovingObjectOptions {
  double clearance = 2.0;  ///< voxels: how far beyond a point others must have seen
  double reach = 4.0;      ///< voxels: radius of the neighbourhood that decides together
  double majority = 0.5;   ///< share of the neighbourhood that must be seen through
};
void VisitOptions(OptionVisitor& visitor, MovingObjectOptions& options);

/// A placed station, as what it measured and as a witness of what others measured.
struct PlacedSurface {
  Surface surface;
  const CloudIndex& index;               ///< of the surface's model
  RigidTransform frame_from_instrument;  ///< into a frame that all share
};

/// What a station measured of things that were gone when others looked.
struct MovingLeaves {
  std::vector<std::uint32_t> leaves;  ///< indices, ascending
  std::uint64_t points = 0;           ///< raw points in them
};

/// Finds in each station the voxels that other stations looked through: people, vehicles, echoes
/// that blend two surfaces. All stations must be of one network; `surfaces[s]` answers to result s.
///
/// A voxel is suspect where more credible scanners saw clearly past it than saw something there
/// (LookAt, with a tolerance that follows incidence and pixel size; of a surface seen edge on only
/// what came back from both sides of it counts), and is kept where most of what
/// its station measured within `reach` is suspect as well: edges and foliage, which others see
/// through here and there, are not, nor is what is thinner than the witnesses' beams are apart.
/// From there the object grows to voxels of which the others say nothing certain, against those
/// that are seen to stand still, at most a metre of smooth surface far. Time about 0.3 us per voxel
/// and station within whose range it lies.
std::vector<MovingLeaves> FindMovingLeaves(const std::vector<PlacedSurface>& surfaces,
                                           const MovingObjectOptions& options,
                                           const ExecutionContext& context);

}  // namespace backsight
