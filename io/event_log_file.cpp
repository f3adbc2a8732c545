#include "io/event_log_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

std::string SystemReason() { return std::generic_category().message(errno); }

/// As much as the system takes; errno says why not all of it.
std::size_t WriteSome(int file, std::string_view text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t part = ::write(file, text.data() + written, text.size() - written);
    if (part < 0 && errno == EINTR) continue;
    if (part <= 0) break;
    written += static_cast<std::size_t>(part);
  }
  return written;
}

}  // namespace

EventLogFile::EventLogFile(std::string path, std::string_view mark) : path_(std::move(path)) {
  RequireMark(mark);
  constexpr mode_t kMode = 0666;  // the umask takes from it
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, kMode);
  if (file_ < 0) {
    throw InputError({.where = path_,
                      .found = "the event log cannot be written: " + SystemReason(),
                      .expected = "",
                      .remedy = "give another file"});
  }
  struct stat status {};
  is_file_ = ::fstat(file_, &status) == 0 && S_ISREG(status.st_mode);
  if (!is_file_) return;
  in_use_ = ::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (!in_use_ && ::ftruncate(file_, 0) != 0) bytes_ = status.st_size;
}

EventLogFile::~EventLogFile() {
  if (file_ >= 0) ::close(file_);
}

void EventLogFile::RequireMark(std::string_view mark) const {
  struct stat status {};
  if (::stat(path_.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_size == 0) {
    return;
  }
  std::string start(mark.size(), '\0');
  std::ifstream(path_, std::ios::binary)
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  if (start == mark) return;
  throw InputError({.where = path_,
                    .found = "the file exists and is no event log",
                    .expected = "a new file or the log of an earlier run",
                    .remedy = "give another name, or remove the file"});
}

std::string EventLogFile::Append(std::string_view line) {
  if (in_use_) return "another run is writing it";
  if (WriteSome(file_, line) < line.size()) {
    const std::string reason = SystemReason();
    // Should this fail too, a reader meets a last line without its end.
    if (is_file_ && ::ftruncate(file_, bytes_) != 0) return reason + ", its last line is cut off";
    return reason;
  }
  bytes_ += static_cast<std::int64_t>(line.size());
  return "";
}

}  // namespace backsight
