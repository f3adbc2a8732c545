#include "io/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace backsight {
namespace {

InputError CannotOpen(const std::string& path) {
  return InputError({path, fmt::format("cannot be opened: {}", std::strerror(errno)),
                     "a readable file", "check the path and its permissions"});
}

}  // namespace

ByteSource::ByteSource(const std::string& path) : path_(path) {
  struct stat status {};
  // Asked before opening, because opening a pipe would wait for a writer.
  if (::stat(path.c_str(), &status) != 0) throw CannotOpen(path);
  if (!S_ISREG(status.st_mode)) {
    const char* kind = S_ISDIR(status.st_mode) ? "is a directory" : "is not a regular file";
    throw InputError({path, kind, "a scan file", "name the file itself"});
  }
  if (status.st_size == 0) {
    throw InputError({path, "is empty (0 bytes)", "a scan file", "copy or export it again"});
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  // No longer than the file, so that sanitizers see whoever looks behind its end.
  buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kCapacity, size_)));
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw CannotOpen(path);
}

ByteSource::~ByteSource() {
  if (file_ >= 0) ::close(file_);
}

void ByteSource::Fill(std::size_t want) {
  BACKSIGHT_CHECK(want <= kCapacity, "more bytes asked for than the buffer holds");
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  buffer_offset_ += begin_;
  end_ -= begin_;
  begin_ = 0;
  while (end_ < want) {
    const std::size_t got =
        ReadAt(buffer_offset_ + end_, buffer_.data() + end_, buffer_.size() - end_);
    if (got == 0) return;
    end_ += got;
  }
}

void ByteSource::Read(char* to, std::size_t n, std::string_view what) {
  const std::uint64_t start = position();
  const std::size_t done = ReadSome(to, n);
  if (done < n) throw Truncated(start, what, n, done);
}

std::size_t ByteSource::ReadSome(char* to, std::size_t n) {
  std::size_t done = std::min(n, end_ - begin_);
  std::copy_n(buffer_.data() + begin_, done, to);
  Consume(done);
  while (n - done >= kCapacity) {  // what the buffer could not hold goes past it
    const std::size_t got = ReadAt(position(), to + done, n - done);
    if (got == 0) return done;
    Seek(position() + got);
    done += got;
  }
  while (done < n) {
    const std::string_view ahead = Peek(1);
    if (ahead.empty()) break;
    const std::size_t step = std::min(n - done, ahead.size());
    std::copy_n(ahead.data(), step, to + done);
    Consume(step);
    done += step;
  }
  return done;
}

std::size_t ByteSource::ReadAt(std::uint64_t offset, char* to, std::size_t n) const {
  while (true) {
    const ssize_t got = ::pread(file_, to, n, static_cast<off_t>(offset));
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno == EINTR) continue;
    throw Error(offset, fmt::format("reading failed: {}", std::strerror(errno)), "",
                "check the disk or the network drive");
  }
}

void ByteSource::Seek(std::uint64_t position) {
  // Short steps ahead stay in the buffer; reading it again for each would cost far more.
  if (position >= buffer_offset_ && position - buffer_offset_ <= end_) {
    begin_ = static_cast<std::size_t>(position - buffer_offset_);
    return;
  }
  buffer_offset_ = position;
  begin_ = end_ = 0;
}

InputError ByteSource::Error(std::uint64_t offset, std::string found, std::string expected,
                             std::string remedy) const {
  return InputError({fmt::format("{}: byte {}", path_, offset), std::move(found),
                     std::move(expected), std::move(remedy)});
}

InputError ByteSource::Truncated(std::uint64_t offset, std::string_view unit,
                                 std::uint64_t declared, std::uint64_t available) const {
  return Error(offset, fmt::format("only {} {} are available", available, unit),
               fmt::format("the declared {} {}", declared, unit),
               "the file is cut short: copy or export it again");
}

}  // namespace backsight
