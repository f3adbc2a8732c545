#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "io/atomic_file.h"
#include "io/e57/page_layout.h"

namespace backsight {

/// Writes a run of payload bytes as the pages of an E57 file, each with its checksum. The file
/// appears under its name only in Commit(). Throws InputError for an unwritable place or a full
/// disk. Memory: a page, and the pages with reserved bytes.
class PagedWriter {
 public:
  explicit PagedWriter(const std::string& path) : file_(path) {}

  /// Logical offset of the next byte.
  std::uint64_t position() const { return pages_ * kE57PayloadBytes + page_.size(); }
  void Write(std::string_view bytes);
  /// Writes zeros up to the next multiple of 4, where sections begin.
  void Align();
  /// Writes `n` zeros, to be filled in later; returns their logical offset.
  std::uint64_t Reserve(std::size_t n);
  /// Replaces reserved bytes at logical offset `offset`.
  void Fill(std::uint64_t offset, std::string_view bytes);
  /// Physical size of the file that Commit will leave.
  std::uint64_t PhysicalBytes() const;
  /// Ends the file, which can then be read at temporary_path(); only Commit(), which does it too,
  /// may follow.
  void Seal();
  void Commit();
  const std::string& temporary_path() const { return file_.temporary_path(); }

 private:
  void FinishPage();

  AtomicFile file_;
  std::uint64_t pages_ = 0;  // finished ones
  std::string page_;         // payload of the page that is being filled
  /// Payload of the pages with reserved bytes, by number; empty until the page is finished.
  std::map<std::uint64_t, std::string> kept_;
};

}  // namespace backsight
