#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "core/error.h"
#include "io/temporary_file.h"

namespace backsight {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;
constexpr std::uint64_t kMostUnsyncedBytes = std::uint64_t{128} << 20U;  // slow disks: 2 seconds

std::string DirectoryOf(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  struct stat status {};
  if (::stat(path_.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) {
    errno = EISDIR;
    Fail("cannot be written");
  }
  const TemporaryFile temporary = CreateTemporaryFile(path_);
  file_ = temporary.descriptor;
  temporary_path_ = temporary.path;
  pending_ = true;
  buffer_.reserve(kBufferBytes);
}

AtomicFile::~AtomicFile() { Discard(); }

void AtomicFile::Discard() noexcept {
  if (file_ >= 0) ::close(file_);
  if (pending_) ::unlink(temporary_path_.c_str());
  file_ = -1;
  pending_ = false;
}

void AtomicFile::Write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) Flush();
  if (bytes.size() > kBufferBytes) {
    WriteAt(flushed_, bytes);
    flushed_ += bytes.size();
    BringToDisk();
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void AtomicFile::Overwrite(std::uint64_t offset, std::string_view bytes) {
  Flush();
  BACKSIGHT_CHECK(offset + bytes.size() <= flushed_, "only written bytes can be replaced");
  WriteAt(offset, bytes);
}

void AtomicFile::Flush() {
  WriteAt(flushed_, {buffer_.data(), buffer_.size()});
  flushed_ += buffer_.size();
  buffer_.clear();
  BringToDisk();
}

void AtomicFile::BringToDisk() {
  if (flushed_ - synced_ < kMostUnsyncedBytes) return;
  if (::fdatasync(file_) != 0) Fail("writing failed");
  synced_ = flushed_;
}

void AtomicFile::WriteAt(std::uint64_t offset, std::string_view bytes) {
  BACKSIGHT_CHECK(file_ >= 0, "the file is sealed or committed");
  backsight::WriteAt(file_, offset, bytes, path_);
}

void AtomicFile::Sync() {
  Flush();
  if (::fsync(file_) != 0) Fail("writing failed");
}

void AtomicFile::Seal() {
  Sync();
  std::vector<char>().swap(buffer_);
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0) Fail("writing failed");
}

void AtomicFile::Commit() {
  if (file_ >= 0) Seal();
  BACKSIGHT_CHECK(pending_, "the file is committed");
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0) Fail("cannot be put in place");
  pending_ = false;
  // The new name itself must reach the disk too. Some network file systems cannot sync a directory
  // and say EINVAL; there is nothing better to do there.
  const int directory = ::open(DirectoryOf(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) Fail("its directory cannot be synchronised");
  const bool synced = ::fsync(directory) == 0 || errno == EINVAL;
  const int error = errno;
  ::close(directory);
  errno = error;
  if (!synced) Fail("its directory cannot be synchronised");
}

void AtomicFile::Fail(std::string_view action) const { ThrowFileError(path_, action); }

void WriteTextFile(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

}  // namespace backsight
