#include "pipeline/run_stages.h"

#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace backsight {

std::string ToString(Stage stage) {
  switch (stage) {
    case Stage::kStations:
      return "stations";
    case Stage::kPairs:
      return "pairs";
    case Stage::kNetwork:
      return "network";
    case Stage::kOutputs:
      return "outputs";
  }
  throw InternalError("a stage without a name");
}

void ForgetFrom(Stage stage, const std::string& work) {
  for (const Stage later : kStages) {
    if (later < stage) continue;
    const std::filesystem::path folder = std::filesystem::path(work) / ToString(later);
    std::error_code error;
    std::filesystem::remove_all(folder, error);
    if (error) {
      throw InputError({folder.string(), "cannot be removed: " + error.message(),
                        "a folder that this run may empty (--from)", "look at its permissions"});
    }
  }
}

}  // namespace backsight
