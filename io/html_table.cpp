#include "io/html_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/html_text.h"

namespace backsight {
namespace {

const char* ClassOf(const HtmlColumn& column) { return column.number ? " class=\"n\"" : ""; }

}  // namespace

HtmlTable::HtmlTable(std::vector<HtmlColumn> columns) : columns_(std::move(columns)) {
  html_ = "<table>\n<thead><tr>";
  for (const HtmlColumn& column : columns_) {
    html_ += fmt::format("<th{}>{}</th>", ClassOf(column), column.title);
  }
  html_ += "</tr></thead>\n<tbody>\n";
}

void HtmlTable::Row(const std::vector<std::string>& cells, const std::string& row_class) {
  html_ += row_class.empty() ? "<tr>" : "<tr class=\"" + row_class + "\">";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    html_ += fmt::format("<td{}>{}</td>", ClassOf(columns_.at(i)), cells[i]);
  }
  html_ += "</tr>\n";
}

std::string HtmlSentence(const std::string& sentence) { return "<p>" + sentence + "</p>\n"; }

std::string HtmlMark(bool good, const std::string& word) {
  return fmt::format("<span class=\"{}\">{} {}</span>", good ? "good" : "bad",
                     good ? "\xe2\x9c\x93" : "\xe2\x9c\x97", HtmlText(word));
}

std::string CodeWords(std::string code) {
  if (code.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos) {
    std::replace(code.begin(), code.end(), '_', ' ');
  }
  return code;
}

std::string HtmlBold(const std::string& text) { return "<b>" + HtmlText(text) + "</b>"; }

}  // namespace backsight
