#include "io/folder_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "core/error.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// A process that holds the lock of a folder until it is killed.
class Holder {
 public:
  explicit Holder(const std::string& folder) {
    std::array<int, 2> ready{};
    EXPECT_EQ(::pipe(ready.data()), 0);
    process_ = ::fork();
    if (process_ == 0) {
      const FolderLock lock(folder);
      const char byte = 'y';
      [[maybe_unused]] const auto written = ::write(ready[1], &byte, 1);
      while (true) ::pause();
    }
    char byte = 'n';
    EXPECT_EQ(::read(ready[0], &byte, 1), 1);
    ::close(ready[0]), ::close(ready[1]);
  }
  ~Holder() { Kill(); }
  void Kill() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  int process() const { return process_; }

 private:
  pid_t process_ = 0;
};

TEST(FolderLock, KeepsOthersOutAndNamesItsHolder) {
  const ScratchFolder folder;
  const std::string work = folder / "work/deep";
  Holder holder(work);
  try {
    const FolderLock lock(work);
    FAIL() << "two hold it";
  } catch (const FolderInUse& error) {
    std::array<char, 256> host{};
    ASSERT_EQ(::gethostname(host.data(), host.size() - 1), 0);
    EXPECT_THAT(error.what(), HasSubstr(std::string(host.data()) + ", process " +
                                        std::to_string(holder.process())));
  }
  const auto seen = HolderOf(work);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->process, holder.process());
  EXPECT_THAT(seen->since_utc, ::testing::MatchesRegex("20..-..-..T..:..:..Z"));
}

TEST(FolderLock, EndsWithItsProcess) {
  const ScratchFolder folder;
  Holder holder(folder / "work");
  holder.Kill();
  EXPECT_FALSE(HolderOf(folder / "work"));
  const FolderLock lock(folder / "work");
  EXPECT_THROW(FolderLock(folder / "work"), FolderInUse);  // even within one process
}

TEST(FolderLock, NobodyHoldsWhatIsNotThere) {
  const ScratchFolder folder;
  EXPECT_FALSE(HolderOf(folder / "work"));
  WriteBytes(folder / "file", "");
  EXPECT_THROW(FolderLock(folder / "file"), StorageFailure);
}

}  // namespace
}  // namespace backsight
