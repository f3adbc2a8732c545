#include "io/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

namespace backsight {
namespace {

constexpr std::string_view kMark = ".tmp-";

std::string TemporaryName(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  return fmt::format("{}{}{}-{}", path, kMark, ::getpid(), counter++);
}

bool IsNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

bool IsTemporary(int error) {
  return error == EIO || error == ESTALE || error == ETIMEDOUT || error == ENOLCK;
}

std::string_view RemedyFor(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "free disk space or write elsewhere";
    case ENOENT:
    case ENOTDIR:
      return "create the directory first";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a place you may write to";
    case EIO:
    case ESTALE:
    case ETIMEDOUT:
    case ENOLCK:
      return "check the disk or the network drive, and try again";
    default:
      return "check the output path and the disk";
  }
}

}  // namespace

TemporaryFile CreateTemporaryFile(const std::string& path) {
  TemporaryFile file;
  do {
    file.path = TemporaryName(path);
    file.descriptor = ::open(file.path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file.descriptor < 0 && errno == EEXIST);
  if (file.descriptor < 0) ThrowFileError(path, "cannot be written");
  return file;
}

std::string TargetOfTemporary(std::string_view file_name) {
  const std::size_t mark = file_name.rfind(kMark);
  if (mark == std::string_view::npos) return "";
  const std::string_view numbers = file_name.substr(mark + kMark.size());
  const std::size_t dash = numbers.find('-');
  const bool ours = dash != std::string_view::npos && IsNumber(numbers.substr(0, dash)) &&
                    IsNumber(numbers.substr(dash + 1));
  return ours ? std::string(file_name.substr(0, mark)) : "";
}

void WriteAt(int descriptor, std::uint64_t offset, std::string_view bytes,
             const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t put =
        ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) ThrowFileError(path, "writing failed");
    bytes.remove_prefix(static_cast<std::size_t>(put));
    offset += static_cast<std::uint64_t>(put);
  }
}

void ThrowFileError(const std::string& path, std::string_view action) {
  const int error = errno;
  const bool full = error == ENOSPC || error == EDQUOT;
  InputError::Details details{path, fmt::format("{}: {}", action, std::strerror(error)), "",
                              std::string(RemedyFor(error))};
  if (IsTemporary(error)) throw TemporaryFailure(std::move(details), full);
  throw StorageFailure(std::move(details), full);
}

}  // namespace backsight
