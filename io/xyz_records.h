#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/text_block.h"
#include "io/xyz_layout.h"
#include "io/xyz_lines.h"

namespace backsight {

/// What text clouds share: lines of numbers, blank lines and comments (#, //) between them, a line
/// of names before them, and columns whose meaning is given, or named by that line or the comments
/// before the numbers, or must be guessed.
class XyzRecords {
 public:
  /// `lines` must outlive the object. `columns`: as for XyzLines.
  XyzRecords(LineReader& lines, TextColumns columns)
      : lines_(lines), rule_(lines.source().path(), std::move(columns)) {}

  /// Goes to the first line that is neither blank nor comment nor, once, a line of names; false if
  /// the file ends before.
  bool SkipPreamble(std::vector<std::string>& notes);
  /// The next line that is neither blank nor comment; false at the end of the file.
  bool NextLine(std::string_view& line);
  /// Takes the columns from the names, or guesses them, and the ranges of given ones, from the next
  /// lines, at most `most`, notes them and returns to where it began. Damage behind the first of
  /// these lines is left to be found by Next(). Throws InputError where the guess would contradict
  /// the names.
  void GuessLayout(bool is_pts, std::uint64_t most, std::vector<std::string>& notes);
  /// What the columns hold.
  void Describe(ScanInfo& info) const;
  /// Takes the next lines into the block, comments among them; false at the end of the file.
  bool Take(std::size_t most, TextBlock& block);
  /// Replaces the block's points by those of its lines. Throws InputError for a line that has not
  /// as many numbers as the first, or as there are given columns. Safe for several threads.
  void Decode(TextBlock& block) const { rule_.Decode(layout_, block); }

  const XyzLayout& layout() const { return layout_; }

 private:
  bool LooksLikeNames(std::string_view line) const;
  void TakeNames(std::string_view line, bool is_header);
  /// Goes by the names for lines of so many columns.
  void UseNames(std::size_t columns, std::vector<std::string>& notes);
  /// Words of the next line; goes back to before it.
  std::size_t CountColumns();
  /// Finite records of the next `most`; zeros if there is none.
  std::vector<std::vector<double>> TakeSample(std::uint64_t most);

  LineReader& lines_;
  XyzLines rule_;
  XyzLayout layout_;
  std::vector<std::string> names_;
  std::uint64_t names_line_ = 0;
  bool names_are_header_ = false;  ///< a line of names, not a comment
};

}  // namespace backsight
