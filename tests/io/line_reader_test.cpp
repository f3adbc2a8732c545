#include "io/line_reader.h"

#include <gmock/gmock.h>

#include <bit>
#include <cstdlib>
#include <random>
#include <vector>

#include "io/text_fields.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

TEST(LineReader, CutsLinesWhereverTheBufferEnds) {
  const TempDir dir;
  std::string text;
  std::vector<std::string> expected;
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    expected.emplace_back(random.Index(60), static_cast<char>('a' + i % 26));
    text += expected.back() + (i % 3 == 0 ? "\r\n" : "\n");
  }
  expected.emplace_back("no end");
  ByteSource source(dir.File("a.txt", text + "no end"));
  LineReader lines(source);
  std::string_view line;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(lines.Next(line));
    ASSERT_EQ(line, expected[i]);
    ASSERT_EQ(lines.line_number(), i + 1);
  }
  EXPECT_FALSE(lines.Next(line));
  EXPECT_EQ(source.position(), source.size());
}

TEST(LineReader, SkipsAndRestarts) {
  const TempDir dir;
  std::string text;
  for (int i = 0; i < 100000; ++i) text += std::to_string(i) + "\n";
  ByteSource source(dir.File("a.txt", text + "end"));
  LineReader lines(source);
  EXPECT_EQ(lines.Skip(70000), 70000U);
  const std::uint64_t place = source.position();
  EXPECT_EQ(lines.Require("a number"), "70000");
  EXPECT_EQ(lines.Skip(1'000'000), 30000U);  // the last line has no line end
  lines.Restart(place, 70000);
  EXPECT_EQ(lines.Require("a number"), "70000");
  EXPECT_EQ(lines.line_number(), 70001U);
}

TEST(ByteSource, ReadsAcrossItsBuffer) {
  const TempDir dir;
  std::string bytes(3 * ByteSource::kCapacity + 5, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i % 251);
  ByteSource source(dir.File("a.bin", bytes));
  std::string copy(bytes.size() - 10, '\0');
  EXPECT_EQ(source.Peek(3).substr(0, 3), bytes.substr(0, 3));
  source.Seek(7);
  source.Read(copy.data(), copy.size(), "bytes");
  EXPECT_EQ(copy, bytes.substr(7, copy.size()));
  EXPECT_EQ(source.remaining(), 3U);
  EXPECT_EQ(source.Peek(100), bytes.substr(bytes.size() - 3));
  EXPECT_THROW(source.Read(copy.data(), 4, "bytes"), InputError);
}

TEST(TextFields, ParsesWholeNumbersOnly) {
  EXPECT_EQ(ParseNumber("+1.5e2"), 150.0);
  EXPECT_FALSE(ParseNumber("1.5x"));
  EXPECT_FALSE(ParseNumber(""));
  EXPECT_FALSE(ParseNumber("+"));
  EXPECT_FALSE(ParseNumber("++1"));
  EXPECT_FALSE(ParseNumber("1,5"));
  EXPECT_EQ(ParseCount("18446744073709551615"), UINT64_MAX);
  EXPECT_FALSE(ParseCount("18446744073709551616"));
  EXPECT_FALSE(ParseCount("-1"));
  EXPECT_FALSE(ParseCount("1.0"));
}

TEST(TextFields, SplitsAndQuotes) {
  std::array<std::string_view, 3> fields;
  EXPECT_EQ(SplitFields(" a\tb  c d ", ' ', fields), 4U);
  EXPECT_EQ(fields[2], "c");
  EXPECT_EQ(SplitFields("a, b,", ',', fields), 2U);
  EXPECT_EQ(fields[1], "b");
  EXPECT_EQ(SplitFields(",b", ',', fields), 2U);
  EXPECT_EQ(fields[0], "");
  EXPECT_EQ(Quoted("a\nb"), "'a\\x0ab'");
  EXPECT_EQ(Quoted(std::string(50, 'a')), "'" + std::string(40, 'a') + "...'");
}

/// What the C library reads, or nothing where it does not read all.
std::optional<double> ReadByLibrary(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') return std::nullopt;
  return value;
}

TEST(ParseNumber, ReadsTheNearestDoubleAsTheLibraryDoes) {
  std::mt19937_64 random(7);
  std::vector<std::string> texts = {"9007199254740993",
                                    "9007199254740992",
                                    "0.1",
                                    "-0",
                                    "-0.0",
                                    "123.",
                                    ".5",
                                    "-.5",
                                    "18446744073709551615",
                                    "99999999999999999999",
                                    "-",
                                    ".",
                                    "-.",
                                    "1.2.3",
                                    "--1",
                                    "1-",
                                    "0.00000000000000000001234567",
                                    "5e-324",
                                    "1e400x"};
  for (int i = 0; i < 200000; ++i) {
    std::string text = std::to_string(random() >> random() % 60);
    if (random() % 8 != 0)
      text.insert(text.begin() + static_cast<long>(random() % text.size()), '.');
    if (random() % 2 == 0) text.insert(text.begin(), '-');
    if (random() % 32 == 0) text.append("e").append(std::to_string(random() % 40));
    texts.push_back(text);
  }
  for (const std::string& text : texts) {
    const std::optional<double> expected = ReadByLibrary(text);
    const std::optional<double> found = ParseNumber(text);
    ASSERT_EQ(found.has_value(), expected.has_value()) << text;
    if (!found) continue;
    ASSERT_EQ(std::bit_cast<std::uint64_t>(*found), std::bit_cast<std::uint64_t>(*expected))
        << text;
  }
}

}  // namespace
}  // namespace backsight
