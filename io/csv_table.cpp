#include "io/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "core/error.h"
#include "io/text_file.h"

namespace backsight {
namespace {

std::string CsvCell(const std::string& text) {
  const bool plain = text.find_first_of(",\"\r\n") == std::string::npos &&
                     (text.empty() || (text.front() != ' ' && text.back() != ' '));
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Splits text into records of cells, one call per record.
class CsvParser {
 public:
  CsvParser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  bool AtEnd() const { return at_ >= text_.size(); }

  CsvTable::Row NextRow() {
    CsvTable::Row row{line_, {}};
    while (true) {
      row.cells.push_back(at_ < text_.size() && text_[at_] == '"' ? QuotedCell() : PlainCell());
      if (AtEnd()) return row;
      const char c = text_[at_++];
      if (c == ',') continue;
      ++line_;
      return row;
    }
  }

 private:
  [[noreturn]] void Fail(int line, const std::string& found, const std::string& expected) const {
    throw InputError({fmt::format("{}:{}", name_, line), found, expected, ""});
  }

  std::string PlainCell() {
    const std::size_t end = std::min(text_.find_first_of(",\n", at_), text_.size());
    std::string cell(text_.substr(at_, end - at_));
    at_ = end;
    if (!cell.empty() && cell.back() == '\r') cell.pop_back();
    return cell;
  }

  std::string QuotedCell() {
    const int begin_line = line_;
    std::string cell;
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] == '"') {
        if (at_ + 1 >= text_.size() || text_[at_ + 1] != '"') break;
        ++at_;
      }
      if (text_[at_] == '\n') ++line_;
      cell += text_[at_];
    }
    if (AtEnd()) Fail(begin_line, "a quote that is never closed", "a closing quote");
    ++at_;
    if (at_ < text_.size() && text_[at_] == '\r') ++at_;
    if (at_ < text_.size() && text_[at_] != ',' && text_[at_] != '\n') {
      Fail(line_, "text after a closing quote", "a comma or the end of the line");
    }
    return cell;
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace

std::string CsvLine(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    line += CsvCell(cells[i]);
  }
  return line + "\n";
}

std::string ExactText(double value, std::string_view field) {
  if (!std::isfinite(value)) throw InternalError(fmt::format("{} is {}", field, value));
  return fmt::format("{}", value);
}

CsvTable CsvTable::Load(const std::string& path) { return Parse(ReadTextFile(path), path); }

CsvTable CsvTable::Parse(const std::string& text, const std::string& name) {
  std::string_view view = text;
  if (view.starts_with("\xef\xbb\xbf")) view.remove_prefix(3);
  CsvTable table;
  table.name_ = name;
  CsvParser parser(view, table.name_);
  if (parser.AtEnd()) throw InputError({name, "an empty file", "a header line", ""});
  table.header_ = parser.NextRow().cells;
  std::set<std::string> columns;
  for (const std::string& column : table.header_) {
    if (!columns.insert(column).second) {
      throw InputError({name + ":1", "the column '" + column + "' twice", "each once", ""});
    }
  }
  while (!parser.AtEnd()) {
    Row row = parser.NextRow();
    if (row.cells.size() == 1 && row.cells[0].empty()) continue;
    if (row.cells.size() != table.header_.size()) {
      throw InputError({fmt::format("{}:{}", name, row.line),
                        fmt::format("{} cells", row.cells.size()),
                        fmt::format("{} as in the header", table.header_.size()), ""});
    }
    table.rows_.push_back(std::move(row));
  }
  return table;
}

std::optional<std::size_t> CsvTable::Find(const std::string& column) const {
  const auto it = std::find(header_.begin(), header_.end(), column);
  if (it == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(it - header_.begin());
}

std::string CsvTable::Where(const Row& row) const { return fmt::format("{}:{}", name_, row.line); }

std::string CsvTable::Text(const Row& row, const std::string& column) const {
  const auto index = Find(column);
  return index ? row.cells[*index] : std::string();
}

double CsvTable::Real(const Row& row, const std::string& column) const {
  if (!HasColumn(column)) throw InputError({name_ + ":1", "no column '" + column + "'", "one", ""});
  const std::string text = Text(row, column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw InputError({Where(row), fmt::format("'{}' in column {}", text, column), "a number", ""});
  }
  return value;
}

int CsvTable::Integer(const Row& row, const std::string& column) const {
  const double value = Real(row, column);
  if (value != std::floor(value) || std::abs(value) > 1e9) {
    throw InputError(
        {Where(row), fmt::format("{} in column {}", value, column), "a whole number", ""});
  }
  return static_cast<int>(value);
}

}  // namespace backsight
