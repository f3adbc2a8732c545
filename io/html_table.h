#pragma once

#include <string>
#include <vector>

namespace backsight {

/// A column of an HTML table; numbers are set to the right.
struct HtmlColumn {
  std::string title;
  bool number = false;
};

/// Builds one table; titles and cells are HTML already.
class HtmlTable {
 public:
  explicit HtmlTable(std::vector<HtmlColumn> columns);

  /// One cell for each column.
  void Row(const std::vector<std::string>& cells, const std::string& row_class = {});

  std::string Finish() const { return html_ + "</tbody></table>\n"; }

 private:
  std::vector<HtmlColumn> columns_;
  std::string html_;
};

/// A paragraph in place of a table that would be empty.
std::string HtmlSentence(const std::string& sentence);

/// A word with a sign before it, so that colour is never the only difference.
std::string HtmlMark(bool good, const std::string& word);

/// A reason code as words; texts that are no code (they may hold paths) stay as they are.
std::string CodeWords(std::string code);

std::string HtmlBold(const std::string& text);

}  // namespace backsight
