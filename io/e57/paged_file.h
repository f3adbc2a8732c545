#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"
#include "io/byte_source.h"
#include "io/e57/page_layout.h"

namespace backsight {

/// The file header of an E57 file (ASTM E2807, clause 9).
struct E57FileHeader {
  std::uint64_t physical_bytes = 0;  ///< of the whole file, a multiple of kE57PageBytes
  std::uint64_t xml_offset = 0;      ///< physical
  std::uint64_t xml_bytes = 0;       ///< logical
};

/// The payload of an E57 file as one run of bytes, addressed by logical offsets. The checksum of
/// each page is verified whenever the page is fetched. All functions throw InputError with file and
/// physical byte offset. Memory: constant.
class PagedFile {
 public:
  /// Reads and checks the file header.
  explicit PagedFile(const std::string& path);

  const std::string& path() const { return source_.path(); }
  const E57FileHeader& header() const { return header_; }
  /// Payload bytes of all pages.
  std::uint64_t size() const { return header_.physical_bytes / kE57PageBytes * kE57PayloadBytes; }
  /// Bytes behind the length that the header states.
  std::uint64_t surplus() const { return source_.size() - header_.physical_bytes; }

  /// Copies `n` bytes from logical offset `offset` on; `what` names them in errors.
  void Read(std::uint64_t offset, char* to, std::size_t n, std::string_view what);

  /// Logical offset of the payload byte at physical offset `physical`. Throws if that lies in a
  /// checksum or outside the file; `stated_at` is the logical offset of the statement.
  std::uint64_t Logical(std::uint64_t physical, std::uint64_t stated_at,
                        std::string_view what) const;

  /// An error at logical offset `offset`; the remedy is to export the file again.
  InputError Error(std::uint64_t offset, std::string found, std::string expected) const;

 private:
  void ReadHeader();
  void LoadPage(std::uint64_t page);

  ByteSource source_;
  E57FileHeader header_;
  std::array<char, kE57PageBytes> page_{};
  std::uint64_t page_index_ = UINT64_MAX;
};

}  // namespace backsight
