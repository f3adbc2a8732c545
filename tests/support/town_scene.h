#pragma once

#include <cstdint>
#include <string>

namespace backsight {

/// A town of `columns` x `rows` blocks of houses with streets between and around them, drawn from
/// `seed`: no two blocks alike, crossings and streets much like each other. A station stands at
/// every crossing and in the middle of every street, (columns + 1)(rows + 1) + columns (rows + 1) +
/// (columns + 1) rows in all, some 15 m apart.
struct TownScene {
  int columns = 4;
  int rows = 3;
  std::uint64_t seed = 1;
  double step_deg = 0.6;  ///< of the scanner
};

int StationCount(const TownScene& town);

/// The text of a scene file for SimulateCampaign.
std::string SceneYaml(const TownScene& town);

}  // namespace backsight
