#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace backsight {

/// How much of a file is taken at a time, to be understood beside other parts of it: about so much,
/// or one line or record that is longer.
inline constexpr std::size_t kBlockBytes = std::size_t{4} << 20U;

/// A file read front to back through one buffer of fixed size. Throws InputError if the file is
/// missing, empty, not a regular file or not readable.
class ByteSource {
 public:
  /// The longest run of bytes that Peek can show.
  static constexpr std::size_t kCapacity = std::size_t{1} << 18U;

  explicit ByteSource(const std::string& path);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  const std::string& path() const { return path_; }
  /// Size of the file in bytes, as it was when opened.
  std::uint64_t size() const { return size_; }
  /// Offset of the next unread byte.
  std::uint64_t position() const { return buffer_offset_ + begin_; }
  /// Bytes from here to the end of the file.
  std::uint64_t remaining() const { return size_ > position() ? size_ - position() : 0; }

  /// Everything that is buffered ahead, at least `want` (<= kCapacity) bytes unless the file ends
  /// earlier. Nothing is consumed. The view holds until the next call of Peek, Read or Seek.
  std::string_view Peek(std::size_t want) {
    if (end_ - begin_ < want) Fill(want);
    return {buffer_.data() + begin_, end_ - begin_};
  }
  /// Steps over `n` bytes that a Peek has shown.
  void Consume(std::size_t n) { begin_ += n; }
  /// Copies exactly `n` bytes; InputError if the file ends earlier. `what` names them.
  void Read(char* to, std::size_t n, std::string_view what);
  /// Copies up to `n` bytes; fewer only where the file ends. Returns how many.
  std::size_t ReadSome(char* to, std::size_t n);
  void Seek(std::uint64_t position);

  /// An error at byte `offset` of this file.
  InputError Error(std::uint64_t offset, std::string found, std::string expected,
                   std::string remedy) const;
  /// The error for a file that ends before what its header promises; counts in `unit`.
  InputError Truncated(std::uint64_t offset, std::string_view unit, std::uint64_t declared,
                       std::uint64_t available) const;

 private:
  void Fill(std::size_t want);
  /// Bytes read from the file at `offset`, at least one unless it ends there.
  std::size_t ReadAt(std::uint64_t offset, char* to, std::size_t n) const;

  std::string path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::vector<char> buffer_;
  std::uint64_t buffer_offset_ = 0;  // offset in the file of buffer_[0]
  std::size_t begin_ = 0;            // unread bytes are buffer_[begin_, end_)
  std::size_t end_ = 0;
};

}  // namespace backsight
