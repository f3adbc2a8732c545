#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace backsight {

/// Bytes put aside on the disk while the program works. The file loses its name before its first
/// byte is written, so that it vanishes with this object and even with a process that is killed
/// (where a file system names open files to the end, it vanishes with this object).
/// All functions throw InputError with the system's reason (unwritable place, full disk).
class ScratchFile {
 public:
  /// In the folder of `path`, which messages name.
  explicit ScratchFile(std::string path);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void Append(std::string_view bytes);
  /// Fills `bytes` from `offset`; they must have been appended.
  void Read(std::uint64_t offset, std::span<char> bytes) const;
  std::uint64_t size() const { return size_; }

 private:
  std::string path_;
  std::string name_;  // left to be removed; usually empty
  int file_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace backsight
