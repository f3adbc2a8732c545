#pragma once

#include <string>

#include "io/scene_description.h"

namespace backsight {

/// The scene file (see ReadScene) of a scene that a test made; control sites are left out.
std::string SceneText(const Scene& scene);

}  // namespace backsight
