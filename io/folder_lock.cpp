#include "io/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <utility>

#include "core/error.h"
#include "io/temporary_file.h"
#include "io/utc_text.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

std::string PathOf(const std::string& folder) { return (fs::path(folder) / "run.lock").string(); }

struct flock WholeFile() {
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return whole;
}

std::string Introduction() {
  return fmt::format("{} {} {}\n", HostName(), ::getpid(),
                     UtcText(std::chrono::system_clock::now()));
}

LockHolder ReadHolder(int file) {
  std::array<char, 512> text{};
  const ssize_t size = ::pread(file, text.data(), text.size() - 1, 0);
  std::istringstream words(size > 0 ? std::string(text.data(), static_cast<std::size_t>(size))
                                    : "");
  LockHolder holder;
  if (!(words >> holder.host >> holder.process >> holder.since_utc))
    return {"unknown", 0, "unknown"};
  return holder;
}

}  // namespace

std::string HostName() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

FolderLock::FolderLock(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);  // opening the file tells what is wrong
  const std::string path = PathOf(folder);
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) ThrowFileError(path, "cannot be written");
  try {
    Lock(path);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

void FolderLock::Lock(const std::string& path) {
  struct flock whole = WholeFile();
  if (::fcntl(file_, F_OFD_SETLK, &whole) == 0) {
    if (::ftruncate(file_, 0) != 0) ThrowFileError(path, "cannot be written");
    WriteAt(file_, 0, Introduction(), path);
    return;
  }
  if (errno == EAGAIN || errno == EACCES) {
    const LockHolder holder = ReadHolder(file_);
    throw FolderInUse(fmt::format(
        "{} is in use: a run is going on {}, process {}, since {}; wait for its end, "
        "or give another --work and --out",
        fs::path(path).parent_path().string(), holder.host, holder.process, holder.since_utc));
  }
  const int error = errno;
  InputError::Details details{path, fmt::format("cannot be locked: {}", std::strerror(error)),
                              "a file system that knows locks",
                              "put the work folder elsewhere (--work), or mount it with locking"};
  if (error == ENOLCK) throw TemporaryFailure(std::move(details), false);  // its server may be down
  throw InputError(std::move(details));
}

FolderLock::~FolderLock() { ::close(file_); }  // which frees the lock

std::optional<LockHolder> HolderOf(const std::string& folder) {
  const int file = ::open(PathOf(folder).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  struct flock whole = WholeFile();
  std::optional<LockHolder> holder;
  if (::fcntl(file, F_OFD_GETLK, &whole) == 0 && whole.l_type != F_UNLCK) holder = ReadHolder(file);
  ::close(file);
  return holder;
}

}  // namespace backsight
