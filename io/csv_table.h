#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace backsight {

/// `cells` as one line of CSV (RFC 4180, ended by \n): cells with a comma, quote, line break or
/// outer space are quoted.
std::string CsvLine(const std::vector<std::string>& cells);

/// Shortest decimal text that reads back as the same double. Throws InternalError naming `field`
/// for NaN and infinity, which no output of Backsight may hold.
std::string ExactText(double value, std::string_view field);

/// A CSV file with a header line.
class CsvTable {
 public:
  struct Row {
    int line = 0;  ///< where the row begins, from 1
    std::vector<std::string> cells;
  };

  /// Throws InputError with the line for a missing file, an open quote, a row whose number of cells
  /// differs from the header's, or a column name given twice. Accepts CRLF and a byte order mark.
  static CsvTable Load(const std::string& path);
  static CsvTable Parse(const std::string& text, const std::string& name);

  const std::vector<Row>& rows() const { return rows_; }
  bool HasColumn(const std::string& column) const { return Find(column).has_value(); }
  /// The cell in `column`; empty where the table has no such column.
  std::string Text(const Row& row, const std::string& column) const;
  /// Throw InputError with line and column where the cell is absent, empty or no finite number.
  double Real(const Row& row, const std::string& column) const;
  int Integer(const Row& row, const std::string& column) const;
  /// "poses.csv:12"
  std::string Where(const Row& row) const;

 private:
  std::optional<std::size_t> Find(const std::string& column) const;

  std::string name_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
};

}  // namespace backsight
