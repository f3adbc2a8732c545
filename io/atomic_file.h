#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace backsight {

/// A file that appears under its name whole or not at all: written to a temporary file beside the
/// target, which takes the target's place in Commit(). Destroyed before that, it removes the
/// temporary file and leaves an older target untouched. All functions throw StorageFailure with
/// the system's reason (unwritable place, full disk).
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Brings to the disk what has been written ever so often, lest Sync() take long.
  void Write(std::string_view bytes);
  /// Replaces bytes that were written before, e.g. a count in a header.
  void Overwrite(std::uint64_t offset, std::string_view bytes);
  /// Brings everything written so far to the disk, so that temporary_path() can be read.
  void Sync();
  /// Sync, and lets go of the open file and its buffer until Commit(). Nothing may be written
  /// afterwards.
  void Seal();
  /// The name to take in Commit() instead, in the same directory.
  void Retarget(std::string path) { path_ = std::move(path); }
  /// Seal, rename to the target, sync of the directory.
  void Commit();

  const std::string& path() const { return path_; }
  const std::string& temporary_path() const { return temporary_path_; }

 private:
  void Flush();
  void BringToDisk();
  void WriteAt(std::uint64_t offset, std::string_view bytes);
  void Discard() noexcept;
  [[noreturn]] void Fail(std::string_view action) const;

  std::string path_;
  std::string temporary_path_;
  int file_ = -1;
  bool pending_ = false;  // the temporary file exists
  std::vector<char> buffer_;
  std::uint64_t flushed_ = 0;  // bytes of the file that have left the buffer
  std::uint64_t synced_ = 0;   // of these, what has been brought to the disk
};

/// Writes `text` as the whole file `path`, through AtomicFile.
void WriteTextFile(const std::string& path, std::string_view text);

}  // namespace backsight
