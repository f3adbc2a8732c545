#pragma once

#include "stages/simulation/facade.h"

namespace backsight {

/// A rectangle on a wall, panel frame (see AddFacade), metres.
struct WallRectangle {
  double left = 0.0, right = 0.0, bottom = 0.0, top = 0.0;
  double width() const { return right - left; }
  double height() const { return top - bottom; }
};

enum class OpeningKind { kNone, kBlind, kWindow, kDoor, kArch };

struct Opening {
  OpeningKind kind = OpeningKind::kNone;
  WallRectangle hole;
  double depth_m = 0.2;  ///< of the pane, or of the pillars beside an arch
  int panes = 2;
  bool sill = false;
  bool shutters = false;
  bool balcony = false;
};

/// One cell of a wall with the opening in it: wall around the hole, reveals, and what closes it.
void AddWallCell(const WallRectangle& cell, const Opening& opening,
                 const FacadeMaterials& materials, const RigidTransform& world_from_panel,
                 TriangleMesh& mesh);

}  // namespace backsight
