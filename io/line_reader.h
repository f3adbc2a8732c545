#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "core/error.h"
#include "io/byte_source.h"

namespace backsight {

/// Hands out the lines of a text file, or of the text header of a binary file: it takes nothing
/// from the source beyond the line end. Lines end with LF or CR LF.
class LineReader {
 public:
  /// Longer lines are taken as proof that the file is no text, and are an InputError.
  static constexpr std::size_t kMaxLineBytes = 65536;

  /// `source` must outlive the reader.
  explicit LineReader(ByteSource& source) : source_(source) {}

  /// The next line without its line end (and without a byte order mark); false at the end of the
  /// file. The view holds until the next call.
  bool Next(std::string_view& line);
  /// Like Next, but the end of the file is an InputError that names what was `expected`.
  std::string_view Require(std::string_view expected);
  /// Steps over up to `n` lines of any length; returns how many there were. `between`, called for
  /// every buffer of text, may throw to give up.
  std::uint64_t Skip(std::uint64_t n, const std::function<void()>& between = {});
  /// Goes on at byte `position`, where line `line_number` + 1 begins.
  void Restart(std::uint64_t position, std::uint64_t line_number);

  /// Number of the line handed out last, from 1.
  std::uint64_t line_number() const { return line_number_; }
  ByteSource& source() const { return source_; }

  /// An error in the line handed out last.
  InputError Error(std::string found, std::string expected, std::string remedy) const;

 private:
  ByteSource& source_;
  std::uint64_t line_number_ = 0;
};

}  // namespace backsight
