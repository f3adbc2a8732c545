#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/text_block.h"
#include "io/xyz_layout.h"

namespace backsight {

/// ';' or ',' where the line has one, otherwise ' '.
char SeparatorOf(std::string_view line);

/// What is known of the lines of a text cloud, and so how a line becomes a record.
class XyzLines {
 public:
  /// `given`: fit by FaultOf, or empty; columns to skip are not read and may hold anything.
  XyzLines(std::string path, TextColumns given)
      : path_(std::move(path)), given_(std::move(given)) {}

  const TextColumns& given() const { return given_; }
  /// The same by names found in the file.
  void UseColumns(TextColumns columns) { given_ = std::move(columns); }
  /// Errors are to say that this line was taken as header.
  void SetHeader(std::uint64_t line) { header_line_ = line; }

  bool IsSkipped(std::size_t column) const {
    return !given_.empty() && given_[column] == TextColumn::kSkip;
  }
  /// `line` is trimmed.
  bool IsComment(std::string_view line) const;
  /// Reads a trimmed line that is neither blank nor comment, line `number` of the file; what is
  /// skipped becomes 0. The first one settles separator and columns. Throws InputError for a line
  /// that has not as many numbers as the first, or as there are given columns.
  void Read(std::string_view line, std::uint64_t number, std::vector<double>* values);
  /// Makes points of all records of the block; comments and blank lines are passed over. Errors as
  /// of Read, which must have seen a record before.
  void Decode(const XyzLayout& layout, TextBlock& block) const;

 private:
  void ReadSettled(std::string_view line, std::uint64_t number,
                   std::vector<std::string_view>* words, std::vector<double>* values) const;
  void RequireCount(std::size_t count, std::string_view line, std::uint64_t number) const;
  double Number(std::string_view word, std::uint64_t number) const;

  std::string path_;
  TextColumns given_;
  std::uint64_t header_line_ = 0;
  char separator_ = ' ';
  std::size_t columns_ = 0;  // of the first record; 0: there was none yet
};

}  // namespace backsight
