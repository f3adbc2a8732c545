#include "io/scratch_file.h"

#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/error.h"
#include "io/temporary_file.h"

namespace backsight {

ScratchFile::ScratchFile(std::string path) : path_(std::move(path)) {
  TemporaryFile temporary = CreateTemporaryFile(path_);
  file_ = temporary.descriptor;
  if (::unlink(temporary.path.c_str()) != 0) name_ = std::move(temporary.path);
}

ScratchFile::~ScratchFile() {
  ::close(file_);
  if (!name_.empty()) ::unlink(name_.c_str());
}

void ScratchFile::Append(std::string_view bytes) {
  WriteAt(file_, size_, bytes, path_);
  size_ += bytes.size();
}

void ScratchFile::Read(std::uint64_t offset, std::span<char> bytes) const {
  BACKSIGHT_CHECK(offset + bytes.size() <= size_, "only appended bytes can be read");
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = EIO;  // somebody cut the file
    if (got <= 0) ThrowFileError(path_, "reading failed");
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

}  // namespace backsight
