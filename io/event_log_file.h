#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace backsight {

/// A file that grows line by line while others read it: each line goes to the system at once. A
/// file starts empty; a pipe or device is written to as it is.
class EventLogFile {
 public:
  /// Throws InputError where the file cannot be opened, or where it exists and does not begin with
  /// `mark`, so that no scan or project file can be emptied by a slip.
  EventLogFile(std::string path, std::string_view mark);
  ~EventLogFile();
  EventLogFile(const EventLogFile&) = delete;
  EventLogFile& operator=(const EventLogFile&) = delete;

  /// Why the line could not be written, empty if it was: a full disk, or another process that
  /// writes this file. Where it could not, no part of it is left in the file.
  std::string Append(std::string_view line);

 private:
  void RequireMark(std::string_view mark) const;

  std::string path_;
  int file_ = -1;
  bool is_file_ = false;
  bool in_use_ = false;  // by another process
  std::int64_t bytes_ = 0;
};

}  // namespace backsight
