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
  /// Takes the next lines, at most `n`, with an LF behind each, into `text` in place of what it
  /// held; returns how many there were, 0 only at the end of the file. Ends before a line that is
  /// too long, unless that is the first, and once the text holds kBlockBytes. line_number() is that
  /// of the last one.
  std::size_t Take(std::size_t n, std::string& text);
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
  InputError TooLong() const;
  /// How many bytes of `ahead` are whole lines, at most `n` of them; counts these.
  std::size_t WholeLines(std::string_view ahead, std::size_t n, std::size_t* lines) const;

  ByteSource& source_;
  std::uint64_t line_number_ = 0;
};

/// An error in line `line` of the file.
InputError ErrorInLine(const std::string& path, std::uint64_t line, std::string found,
                       std::string expected, std::string remedy);

}  // namespace backsight
