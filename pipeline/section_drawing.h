#pragma once

#include <functional>
#include <vector>

#include "core/execution.h"
#include "io/picture_record.h"
#include "pipeline/picture_canvas.h"
#include "pipeline/placed_clouds.h"

namespace backsight {

/// A slab through the cloud, and how its drawing lies on paper. Frame of the clouds.
struct Section {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();   ///< where the drawing's axes are zero
  Eigen::Vector3d across = Eigen::Vector3d::UnitX();  ///< unit, to the right
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();      ///< unit
  double thickness_m = 0.05;

  Eigen::Vector3d normal() const { return across.cross(up); }
  Eigen::Vector2d OnPaper(const Eigen::Vector3d& point) const {
    return {across.dot(point - origin), up.dot(point - origin)};
  }
};

/// A voxel's share of a section: its surface in the slab lies about `middle`, as a layer.
struct VoxelCut {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< on paper
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();  ///< unit, along the layer
  double half_length_m = 0.0;
  double half_width_m = 0.0;  ///< a standard deviation of the points across the layer
  bool layer = false;         ///< false: they lie on no surface, only `middle` means something
};

/// Calls `body(cut, index of the station among all)` for every voxel that reaches into the section.
/// The voxel's mean, moved onto the plane of its patch (FindPatch, or PatchOf its own points where
/// they suffice) and along that to the nearest place in the slab, is where it is cut: a wall comes
/// out as a line in its own place and as thick as its points scatter, wherever in the slab the
/// voxels' means lie.
void ForEachCut(const PlacedClouds& clouds, const Section& section, const ExecutionContext& context,
                const std::function<void(const VoxelCut&, std::size_t)>& body);

/// Draws the section in the window, stations in their colours; where several share a pixel their
/// colours alternate along the diagonal, so that walls that fall together are striped and walls
/// that do not stand beside each other in one colour. Of more stations than there are colours
/// (kStationColours) those with most pixels have one. Memory: 8 bytes per drawn pixel and station.
PictureRecord DrawSection(const PlacedClouds& clouds, const Section& section,
                          const PictureWindow& window, PictureRecord::Kind kind,
                          const ExecutionContext& context);

}  // namespace backsight
