#include "io/external_sort.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <map>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

struct Entry {
  std::uint32_t group = 0;
  std::uint32_t rank = 0;
  auto operator<=>(const Entry&) const = default;
};
struct GroupOfEntry {
  std::uint32_t operator()(const Entry& entry) const { return entry.group; }
};
using Sorter = ExternalSorter<Entry, GroupOfEntry>;

std::vector<Entry> RandomEntries(std::size_t count, std::uint32_t groups) {
  Random random(3);
  std::vector<Entry> entries(count);
  for (Entry& entry : entries) {
    entry.group = static_cast<std::uint32_t>(random.Index(groups));
    entry.rank = static_cast<std::uint32_t>(random.Index(1000));
  }
  return entries;
}

std::vector<Entry> LeastOfGroups(const std::vector<Entry>& entries) {
  std::map<std::uint32_t, std::uint32_t> least;
  for (const Entry& entry : entries) {
    const auto [at, is_new] = least.try_emplace(entry.group, entry.rank);
    at->second = std::min(at->second, entry.rank);
  }
  std::vector<Entry> result;
  result.reserve(least.size());
  for (const auto& [group, rank] : least) result.push_back({group, rank});
  return result;
}

std::vector<Entry> Drain(Sorter* sorter) {
  sorter->Finish();
  std::vector<Entry> result;
  for (Entry entry; sorter->Next(&entry);) result.push_back(entry);
  Entry beyond;
  EXPECT_FALSE(sorter->Next(&beyond));
  return result;
}

TEST(ExternalSorter, GivesTheLeastOfEachGroupWhateverTheMemory) {
  const TempDir dir;
  for (const std::uint32_t groups : {1U, 40U, 3000U, 4000000000U}) {
    const std::vector<Entry> entries = RandomEntries(10000, groups);
    const std::vector<Entry> expected = LeastOfGroups(entries);
    for (const std::size_t bytes : {1U, 100U, 1000U, 20000U, 1000000U}) {
      Sorter sorter(dir / "sort", bytes);
      for (const Entry& entry : entries) sorter.Add(entry);
      EXPECT_EQ(Drain(&sorter), expected) << groups << " groups, " << bytes << " bytes";
    }
  }
}

TEST(ExternalSorter, GivesUpWhileMerging) {
  const TempDir dir;
  Sorter sorter(dir / "a", 100 * sizeof(Entry));
  for (const Entry& entry : RandomEntries(10000, 4000000000U)) sorter.Add(entry);
  EXPECT_THROW(sorter.Finish([] { throw Interrupted(); }), Interrupted);
}

TEST(ExternalSorter, LeavesTheDiskAloneWhereMemorySuffices) {
  const TempDir dir;
  Sorter none(dir / "missing/sort", 80);
  EXPECT_TRUE(Drain(&none).empty());
  Sorter few_groups(dir / "missing/sort", 80);
  for (const Entry& entry : RandomEntries(10000, 5)) few_groups.Add(entry);
  EXPECT_EQ(few_groups.runs(), 0U);
  EXPECT_EQ(Drain(&few_groups).size(), 5U);
}

TEST(ExternalSorter, ScratchFilesHaveNoNameAndVanish) {
  const TempDir dir;
  Sorter sorter(dir / "sort", 800);
  for (const Entry& entry : RandomEntries(10000, 5000)) sorter.Add(entry);
  EXPECT_GT(sorter.runs(), 10U);
  EXPECT_EQ(dir.FileCount(), 0U);
  Drain(&sorter);
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(ExternalSorter, NamesThePlaceThatCannotBeWritten) {
  const TempDir dir;
  Sorter sorter(dir / "missing/sort", 800);
  EXPECT_THAT(ErrorOf([&] {
                for (const Entry& entry : RandomEntries(1000, 5000)) sorter.Add(entry);
              }),
              HasSubstr("missing/sort: cannot be written: No such file or directory; create"));
}

TEST(ExternalSorter, ReportsAFullDisk) {
  const TempDir dir;
  // A limit on file size stands in for a full disk: both make the write itself fail.
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 5000, old.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = ErrorOf([&] {
    Sorter sorter(dir / "sort", 800);
    for (const Entry& entry : RandomEntries(10000, 50000)) sorter.Add(entry);
  });
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(error, HasSubstr("sort: writing failed: File too large; free disk space"));
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(ScratchFile, ReadsWhatWasAppendedAndNothingElse) {
  const TempDir dir;
  ScratchFile file(dir / "scratch");
  file.Append("abc");
  file.Append("defg");
  EXPECT_EQ(file.size(), 7U);
  std::string middle(4, '\0');
  file.Read(2, middle);
  EXPECT_EQ(middle, "cdef");
  EXPECT_THROW(file.Read(4, middle), InternalError);
  EXPECT_EQ(dir.FileCount(), 0U);
}

}  // namespace
}  // namespace backsight
