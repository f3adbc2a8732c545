#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/line_reader.h"
#include "io/point_collector.h"
#include "io/xyz_layout.h"

namespace backsight {

/// What text clouds share: lines of numbers, blank lines and comments (#, //) between them, a line
/// of names before them, and columns whose meaning is given, or named by that line or the comments
/// before the numbers, or must be guessed.
class XyzRecords {
 public:
  /// `lines` must outlive the object. `columns`: fit by FaultOf, or empty; those to skip are not
  /// read and may hold anything.
  XyzRecords(LineReader& lines, TextColumns columns) : lines_(lines), given_(std::move(columns)) {}

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
  /// Reads the next record; false at the end of the file. Throws InputError for a line that has not
  /// as many numbers as the first, or as there are given columns.
  bool Next();
  /// Hands the record read last to `collector`.
  void Add(PointCollector& collector, PointChunk& chunk) const;

  const XyzLayout& layout() const { return layout_; }

 private:
  bool IsSkipped(std::size_t column) const {
    return !given_.empty() && given_[column] == TextColumn::kSkip;
  }
  bool IsComment(std::string_view line) const;
  bool LooksLikeNames(std::string_view line) const;
  void TakeNames(std::string_view line, bool is_header);
  /// Goes by the names for lines of so many columns.
  void UseNames(std::size_t columns, std::vector<std::string>& notes);
  /// Words of the next line; goes back to before it.
  std::size_t CountColumns();
  void RequireCount(std::size_t count, std::string_view line) const;
  double Number(std::string_view word) const;

  LineReader& lines_;
  TextColumns given_;  ///< or by names; empty: to be guessed
  XyzLayout layout_;
  std::vector<std::string> names_;
  std::uint64_t names_line_ = 0;
  bool names_are_header_ = false;  ///< a line of names, not a comment
  char separator_ = ' ';
  std::vector<std::string_view> words_;
  std::vector<double> values_;
};

}  // namespace backsight
