#include "io/text_block.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "io/line_reader.h"
#include "io/plain_number.h"
#include "io/text_fields.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

/// Whether `text` is taken as a plain number; if so, it must have exactly the value it has.
bool IsPlain(const std::string& text) {
  const std::string line = text + "\n";
  const char* at = line.data();
  const std::optional<double> value = TakePlainNumber(at);
  if (!value || *at != '\n') return false;
  const std::optional<double> expected = ParseNumber(text);
  EXPECT_TRUE(expected) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(*value),
            std::bit_cast<std::uint64_t>(expected.value_or(9)))
      << text;
  return true;
}

TEST(PlainNumber, HasTheBitsOfFromChars) {
  Random random(1);
  int plain = 0;
  for (int i = 0; i < 200000; ++i) {
    const double value = random.Uniform(-1.0, 1.0) * std::pow(10.0, random.Index(7));
    plain += IsPlain(fmt::format("{:.{}f}", value, random.Index(12))) ? 1 : 0;
    IsPlain(fmt::format("{}", value));
    IsPlain(std::to_string(random.Index(UINT64_MAX)));
  }
  EXPECT_GT(plain, 190000);
  for (const char* text : {"0", "-0", "-0.0", "000.5", "9007199254740992", "0.000000000000000001",
                           "900719925474.0992"}) {
    EXPECT_TRUE(IsPlain(text)) << text;
  }
}

TEST(PlainNumber, LeavesOtherFormsToOthers) {
  for (const char* text :
       {"", "-", ".5", "5.", "+5", "1e5", "1E-5", "nan", "inf", "0x10", "1,5", "9007199254740993",
        "12345678901234567890", "1.7976931348623157", "0.0000000000000000001", "1.2.3", "--1"}) {
    EXPECT_FALSE(IsPlain(text)) << text;
  }
}

/// What a line holds for those who read it slowly.
std::optional<std::vector<double>> SlowLine(std::string_view line, char separator,
                                            const std::vector<char>& is_skipped, std::size_t n) {
  std::vector<std::string_view> words(64);
  if (SplitFields(Trim(line), separator, words) != n) return std::nullopt;
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_skipped.empty() && is_skipped[i] != 0) continue;
    const std::optional<double> number = ParseNumber(words[i]);
    if (!number) return std::nullopt;
    values[i] = *number;
  }
  return values;
}

TEST(PlainLine, SaysWhatTheSlowWaySaysOrNothing) {
  Random random(2);
  const std::vector<std::string> pieces = {"1",  "-2.5", " ",  "\t", "  ", ",", ";",
                                           "\r", "x",    "#a", "/",  "",   "7", "0.125"};
  int taken = 0;
  for (int round = 0; round < 400000; ++round) {
    const char separator = " ,;"[random.Index(3)];
    std::vector<char> is_skipped;
    if (random.Index(2) == 0) is_skipped = {static_cast<char>(random.Index(2)), 0, 1};
    std::string line;
    for (std::uint64_t i = 2 + random.Index(8); i > 0; --i) {
      line += random.Index(2) == 0 ? pieces[random.Index(pieces.size())]
                                   : std::string("3.5") + separator;
    }
    const std::string text = line + "\nrest";
    std::vector<double> values(3);
    const char* at = text.data();
    if (!TakePlainLine(at, separator, is_skipped, values)) continue;
    ++taken;
    ASSERT_EQ(at, text.data() + line.size() + 1) << line;
    ASSERT_EQ(SlowLine(line, separator, is_skipped, 3), values) << "'" << line << "'";
  }
  EXPECT_GT(taken, 1000);
}

/// The lines of a file, `most` at a time, and where Take says they stand.
std::vector<std::string> TakeAll(const std::string& path, std::size_t most) {
  ByteSource source(path);
  LineReader lines(source);
  std::vector<std::string> all;
  std::string text;
  while (true) {
    const std::uint64_t before = lines.line_number();
    const std::size_t taken = lines.Take(most, text);
    EXPECT_EQ(lines.line_number(), before + taken);
    EXPECT_LE(taken, most);
    if (taken == 0) break;
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t i = 0; i < taken; ++i) all.emplace_back(TakeLine(at, end));
    EXPECT_EQ(at, end);
  }
  return all;
}

TEST(LineReader, TakesTheLinesThatNextHandsOut) {
  const TempDir dir;
  Random random(3);
  std::string text = "\xEF\xBB\xBF";
  for (int i = 0; i < 4000; ++i) {
    const std::size_t length = i % 500 == 0 ? 65000 + random.Index(500) : random.Index(300);
    text += std::string(length, static_cast<char>('a' + i % 26)) + (i % 3 == 0 ? "\r\n" : "\n");
  }
  for (const std::string& end : {std::string(), std::string("no end"), std::string("\n\n")}) {
    const std::string path = dir.File("a.txt", text + end);
    std::vector<std::string> expected;
    ByteSource source(path);
    LineReader lines(source);
    for (std::string_view line; lines.Next(line);) expected.emplace_back(line);
    for (const std::size_t most : {1U, 7U, 1000U, 100000U}) {
      EXPECT_EQ(TakeAll(path, most), expected) << most;
    }
  }
}

TEST(LineReader, TakesWhatStandsBeforeALineThatIsTooLong) {
  const TempDir dir;
  for (const std::string& end : {std::string(), std::string("\nmore\n")}) {
    ByteSource source(dir.File("a.txt", "one\ntwo\n" + std::string(65537, 'x') + end));
    LineReader lines(source);
    std::string text;
    EXPECT_EQ(lines.Take(10, text), 2U);
    EXPECT_EQ(text, "one\ntwo\n");
    const std::string error = ErrorOf([&] { lines.Take(10, text); });
    EXPECT_NE(error.find("a.txt:3: a line longer than 65536 bytes"), std::string::npos) << error;
  }
}

}  // namespace
}  // namespace backsight
