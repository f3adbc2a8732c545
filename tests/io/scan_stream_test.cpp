#include "io/scan_stream.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kChunk = 16384;
constexpr std::uint64_t kRecords = 2 * kChunk + 1000;

void Append(const PointChunk& from, PointChunk* to) {
  const auto append = [](auto& all, const auto& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  append(to->x, from.x);
  append(to->y, from.y);
  append(to->z, from.z);
  append(to->intensity, from.intensity);
  append(to->rgb, from.rgb);
  append(to->classification, from.classification);
  append(to->gps_time, from.gps_time);
  append(to->row, from.row);
  append(to->column, from.column);
}

/// Everything that a scan gave until it ended or broke.
struct Streamed {
  PointChunk points;
  ScanTally tally;
  std::string error;
};

Streamed StreamWhole(const std::string& path, int threads, const TextColumns& columns = {}) {
  Streamed result;
  const ExecutionContext context(threads);
  try {
    const auto reader = OpenScan(path, 0, columns);
    std::vector<double> worked(context.StreamSlots());
    StreamScan(
        *reader, worked.size(), context,
        [&](std::size_t slot, const PointChunk& points) {
          worked[slot] = points.empty() ? 0.0 : points.x.back();
        },
        [&](std::size_t slot, const PointChunk& points) {
          EXPECT_EQ(worked[slot], points.empty() ? 0.0 : points.x.back());
          Append(points, &result.points);
        });
    result.tally = reader->tally();
  } catch (const InputError& error) {
    result.error = error.what();
  }
  return result;
}

/// Reading in turn, by Next.
Streamed ReadInTurn(const std::string& path, const TextColumns& columns = {}) {
  Streamed result;
  try {
    const auto reader = OpenScan(path, 0, columns);
    PointChunk chunk;
    while (reader->Next(chunk)) Append(chunk, &result.points);
    result.tally = reader->tally();
  } catch (const InputError& error) {
    result.error = error.what();
  }
  return result;
}

void ExpectSame(const Streamed& a, const Streamed& b) {
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.points.x, b.points.x);
  EXPECT_EQ(a.points.y, b.points.y);
  EXPECT_EQ(a.points.z, b.points.z);
  EXPECT_EQ(a.points.intensity, b.points.intensity);
  EXPECT_EQ(a.points.rgb, b.points.rgb);
  EXPECT_EQ(a.points.classification, b.points.classification);
  EXPECT_EQ(a.points.gps_time, b.points.gps_time);
  EXPECT_EQ(a.points.row, b.points.row);
  EXPECT_EQ(a.points.column, b.points.column);
  EXPECT_EQ(a.tally.records, b.tally.records);
  EXPECT_EQ(a.tally.points, b.tally.points);
  EXPECT_EQ(a.tally.no_return, b.tally.no_return);
  EXPECT_EQ(a.tally.not_finite, b.tally.not_finite);
  EXPECT_EQ(a.tally.notes, b.tally.notes);
}

/// A text scan whose records are known; `lines` replaces some of them by other text.
struct TextScan {
  std::string name;
  std::string head;
  std::string separator;
  TextColumns columns = {};
  std::uint64_t lines_before = 0;

  std::string Text(const std::function<std::string(std::uint64_t)>& replaced = {}) const {
    std::string text = head;
    for (std::uint64_t i = 0; i < kRecords; ++i) {
      std::string line = replaced ? replaced(i) : "";
      if (line.empty()) line = Record(i);
      text += line + "\n";
    }
    return text;
  }
  std::string Record(std::uint64_t i) const {
    if (i % 7 == 0) return fmt::format("0{0}0{0}0{0}0.5", separator);
    if (i % 1000 == 0) return fmt::format("nan{0}1e3{0}+2{0}0.25", separator);
    return fmt::format("{1}.{2:03}{0}-{3}{0}0.{1}{0}{4}", separator, i % 300, i % 997, i,
                       i % 13 == 0 ? 2.5 : 0.75);
  }
};

std::vector<TextScan> TextScans() {
  const std::string ptx = fmt::format(
      "{}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", kRecords);
  using enum TextColumn;
  return {{"a.ptx", ptx, " ", {}, 10},
          {"a.pts", fmt::format("{}\n", kRecords), " ", {}, 1},
          {"a.xyz", "", "\t", {}, 0},
          {"a.csv", "x,y,z,intensity\n", ", ", {}, 1},
          {"a.asc", "# mine\n", " ", {kY, kX, kZ, kSkip}, 1}};
}

TEST(StreamScan, AnyNumberOfThreadsReadsWhatNextReads) {
  const TempDir dir;
  for (const TextScan& scan : TextScans()) {
    const std::string path = dir.File(scan.name, scan.Text());
    const Streamed expected = ReadInTurn(path, scan.columns);
    EXPECT_EQ(expected.error, "") << scan.name;
    EXPECT_EQ(expected.tally.records, kRecords);
    EXPECT_GT(expected.tally.not_finite, 20U);
    for (const int threads : {1, 2, 5}) {
      ExpectSame(StreamWhole(path, threads, scan.columns), expected);
    }
  }
}

TEST(StreamScan, ReadsRecordsAmongCommentsAndBlankLines) {
  const TempDir dir;
  for (const TextScan& scan : TextScans()) {
    if (scan.name == "a.ptx") continue;  // grids have a line for every cell
    const std::string path = dir.File(scan.name, scan.Text([&](std::uint64_t i) {
      return i % kChunk < 3 ? "# here\n\n  " + scan.Record(i) + " \r" : std::string();
    }));
    const Streamed expected = ReadInTurn(path, scan.columns);
    EXPECT_EQ(expected.error, "") << scan.name;
    EXPECT_EQ(expected.tally.records, kRecords);
    ExpectSame(StreamWhole(path, 3, scan.columns), expected);
  }
}

TEST(StreamScan, NamesTheFirstDamagedLineAtTheBordersOfChunks) {
  const TempDir dir;
  for (const TextScan& scan : TextScans()) {
    for (const std::uint64_t at : {kChunk - 1, kChunk, kRecords - 1}) {
      // There is more damage behind, which other threads may find earlier.
      const std::string path = dir.File(scan.name, scan.Text([&](std::uint64_t i) {
        return i == at || i == at + 3 || i == at + kChunk / 2 ? std::string("1 2 damaged") : "";
      }));
      for (const int threads : {1, 4}) {
        const Streamed found = StreamWhole(path, threads, scan.columns);
        EXPECT_THAT(found.error,
                    HasSubstr(fmt::format("{}:{}: ", scan.name, scan.lines_before + at + 1)));
        ExpectSame(found, ReadInTurn(path, scan.columns));
        EXPECT_EQ(found.points.size() > 0, at >= kChunk);  // whole chunks before came through
      }
    }
  }
}

TEST(StreamScan, NamesALineThatIsTooLongBehindDamageOnlyAfterThat) {
  const TempDir dir;
  for (const TextScan& scan : TextScans()) {
    if (scan.name == "a.pts") continue;  // sees every line when it is opened
    for (const bool damaged_before : {false, true}) {
      const std::string path = dir.File(scan.name, scan.Text([&](std::uint64_t i) {
        if (damaged_before && i == kChunk + 8) return std::string("1 2 damaged");
        return i == kChunk + 10 ? std::string(70000, '1') : std::string();
      }));
      const std::uint64_t line = scan.lines_before + kChunk + (damaged_before ? 9 : 11);
      for (const int threads : {1, 4}) {
        const Streamed found = StreamWhole(path, threads, scan.columns);
        EXPECT_THAT(found.error, HasSubstr(fmt::format("{}:{}: ", scan.name, line)));
      }
    }
  }
}

TEST(StreamScan, NamesFilesThatEndAtTheBorderOfAChunk) {
  const TempDir dir;
  for (const TextScan& scan : TextScans()) {
    if (scan.name != "a.ptx" && scan.name != "a.pts") continue;  // the others state no number
    const std::string path = dir.File(scan.name, scan.Text());
    const auto reader = OpenScan(path);
    std::string text = scan.Text();
    std::size_t end = scan.head.size();
    for (std::uint64_t i = 0; i < kChunk; ++i) end = text.find('\n', end) + 1;
    std::filesystem::resize_file(path, end);  // after it was opened
    PointChunk chunk;
    const std::string error = ErrorOf([&] {
      while (reader->Next(chunk)) {
      }
    });
    EXPECT_THAT(error, HasSubstr(scan.name + ":"));
    EXPECT_THAT(error, HasSubstr("the file is cut short"));
    EXPECT_THAT(StreamWhole(path, 3).error, HasSubstr("the file is cut short"));
  }
}

TEST(StreamScan, PassesOnWhatWorkThrowsInTurn) {
  const TempDir dir;
  const TextScan scan = TextScans()[2];
  const std::string path = dir.File(scan.name, scan.Text());
  const ExecutionContext context(3);
  const auto reader = OpenScan(path);
  std::size_t taken = 0;
  const auto stream = [&] {
    StreamScan(
        *reader, context.StreamSlots(), context,
        [](std::size_t, const PointChunk& points) {
          if (*std::min_element(points.y.begin(), points.y.end()) < -1.0 * kChunk)
            throw InputError({"here", "", "", ""});
        },
        [&](std::size_t, const PointChunk&) { ++taken; });
  };
  EXPECT_THROW(stream(), InputError);
  EXPECT_EQ(taken, 1U);
}

}  // namespace
}  // namespace backsight
