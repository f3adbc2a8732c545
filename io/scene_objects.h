#pragma once

#include "io/scene_description.h"
#include "io/strict_yaml.h"

namespace backsight {

/// Readers of the things in a scene; mistakes join the document's violations.
Ground ReadGround(const YamlValue& map);
Building ReadBuilding(const YamlValue& map);
Room ReadRoom(const YamlValue& map);
Barrier ReadBarrier(const YamlValue& map);
Pole ReadPole(const YamlValue& map);
Tree ReadTree(const YamlValue& map);
Car ReadCar(const YamlValue& map);
People ReadPeople(const YamlValue& map);
Traffic ReadTraffic(const YamlValue& map);

/// A required position in the plan.
Eigen::Vector2d ReadPlanPosition(const YamlValue& value);
/// An optional real number with a default and inclusive bounds.
double ReadReal(const YamlValue& map, const std::string& key, double fallback, double min,
                double max, const std::string& unit);

}  // namespace backsight
