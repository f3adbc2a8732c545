#include "io/csv_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

TEST(CsvTable, ReadsBackWhatWasWritten) {
  const std::vector<std::string> header = {"a", "b, c", "d"};
  const std::vector<std::vector<std::string>> rows = {{"plain", "with, comma", "with \"quotes\""},
                                                      {"two\nlines", "", " outer space "},
                                                      {"\"", ",", "cr\r\nlf"}};
  std::string text = CsvLine(header);
  for (const auto& row : rows) text += CsvLine(row);
  const CsvTable table = CsvTable::Parse(text, "t.csv");
  ASSERT_EQ(table.rows().size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(table.rows()[i].cells, rows[i]);
  EXPECT_EQ(table.rows()[2].line, 5);
  EXPECT_EQ(table.Text(table.rows()[0], "b, c"), "with, comma");
  EXPECT_EQ(table.Text(table.rows()[0], "none"), "");
}

TEST(CsvTable, AcceptsWindowsLineEndsAndByteOrderMark) {
  const CsvTable table = CsvTable::Parse(
      "\xef\xbb\xbf"
      "a,b\r\n\"1\",2\r\n\r\n",
      "t.csv");
  ASSERT_EQ(table.rows().size(), 1U);
  EXPECT_EQ(table.Integer(table.rows()[0], "a"), 1);
  EXPECT_EQ(table.Real(table.rows()[0], "b"), 2.0);
}

TEST(CsvTable, NamesTheDamagedLine) {
  const auto complaint = [](const std::string& text) {
    try {
      const CsvTable table = CsvTable::Parse(text, "t.csv");
      for (const auto& row : table.rows()) table.Real(row, "a");
      for (const auto& row : table.rows()) table.Integer(row, "a");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(complaint(""), HasSubstr("empty file"));
  EXPECT_THAT(complaint("a,a\n"), HasSubstr("t.csv:1: the column 'a' twice"));
  EXPECT_THAT(complaint("a,b\n1,2\n3\n"), HasSubstr("t.csv:3: 1 cells; expected 2"));
  EXPECT_THAT(complaint("a\n1\n\"2\n3"), HasSubstr("t.csv:3: a quote that is never closed"));
  EXPECT_THAT(complaint("a\n\"1\"2\n"), HasSubstr("t.csv:2: text after a closing quote"));
  EXPECT_THAT(complaint("a\n1\nx\n"), HasSubstr("t.csv:3: 'x' in column a; expected a number"));
  EXPECT_THAT(complaint("a\nnan\n"), HasSubstr("t.csv:2: 'nan'"));
  EXPECT_THAT(complaint("a\n1.5\n"), HasSubstr("whole number"));
  EXPECT_THAT(complaint("b\n1\n"), HasSubstr("no column 'a'"));
}

TEST(CsvTable, NumbersReadBackExactly) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double value = random.Normal() * std::pow(10.0, random.Uniform(-12, 8));
    EXPECT_EQ(std::stod(ExactText(value, "x")), value);
  }
  EXPECT_THROW(ExactText(std::numeric_limits<double>::quiet_NaN(), "x"), InternalError);
  EXPECT_THROW(ExactText(std::numeric_limits<double>::infinity(), "x"), InternalError);
}

}  // namespace
}  // namespace backsight
