#pragma once

#include <string>

#include "io/scene_description.h"

namespace backsight {

/// Reads and validates a scene file (schema_version 1). Keys are the fields of the structs in
/// scene_description.h with
/// `moving: {people, area_m, traffic: [{count, from_m, to_m}]}` for people and cars, and `role:
/// control|check` for the targets; every key with a default there may be left out. Throws one
/// InputError that lists everything wrong with the file, line by line.
Scene ReadScene(const std::string& path);

}  // namespace backsight
