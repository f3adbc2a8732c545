#pragma once

#include <optional>
#include <string>

namespace backsight {

/// The stages of a run, in order. Each has its artifacts in a folder of its name.
enum class Stage { kStations, kPairs, kNetwork, kOutputs };

inline constexpr Stage kStages[] = {Stage::kStations, Stage::kPairs, Stage::kNetwork,
                                    Stage::kOutputs};

/// "stations", "pairs", "network", "outputs"
std::string ToString(Stage stage);

/// What a run is asked to do of all it could.
struct StageRange {
  std::optional<Stage> from;  ///< this and all after it is done anew, though it is up to date
  Stage last = Stage::kOutputs;
};

/// Removes what is stored of the stage and all after it from the work folder.
void ForgetFrom(Stage stage, const std::string& work);

}  // namespace backsight
