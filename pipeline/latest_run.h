#pragma once

#include <optional>
#include <string>

namespace backsight {

/// How a run ended that could still say so.
struct RunEnding {
  std::string at_utc;  ///< ISO 8601
  int exit_code = 0;
  std::string line;  ///< its summary line
};

/// The run that began last in a work folder.
struct LatestRun {
  std::string host;
  int process = 0;
  std::string since_utc;            ///< ISO 8601
  std::optional<RunEnding> ending;  ///< none while it goes on, and where it was killed
};

/// Notes in work folder `work`, of which this process holds the lock, that its run begins. Where a
/// note cannot be written, nothing happens: the run is worth more.
void NoteBeginning(const std::string& work);

/// Notes how the run ends whose beginning this process has noted, while it still holds the lock.
void NoteEnding(const std::string& work, int exit_code, const std::string& line);

/// What is noted; nothing where no run has begun or the note is damaged.
std::optional<LatestRun> ReadLatestRun(const std::string& work);

}  // namespace backsight
