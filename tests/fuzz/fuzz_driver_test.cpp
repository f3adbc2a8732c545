#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>

#include "core/random.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

TEST(FuzzTarget, ReadsItsSeeds) {
  const FuzzTarget target = TargetUnderTest();
  int readable = 0;
  for (const std::string& seed : target.seeds()) readable += ReadFuzzed(target, seed) ? 1 : 0;
  EXPECT_GE(readable, 3);
}

/// One to three changes of one byte, a few erased or a few repeated elsewhere.
std::string Mutate(std::string input, Random& random) {
  for (std::uint64_t hits = 1 + random.Index(3); hits > 0 && !input.empty(); --hits) {
    const std::size_t at = random.Index(input.size());
    switch (random.Index(3)) {
      case 0:
        input[at] = static_cast<char>(random.Index(256));
        break;
      case 1:
        input.erase(at, 1 + random.Index(8));
        break;
      default:
        input.insert(at, input.substr(random.Index(input.size()), 1 + random.Index(40)));
        break;
    }
  }
  return input;
}

double PeakMegabytes() {
  struct rusage usage {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

TEST(FuzzTarget, MutationsAreReadOrRefused) {
  const FuzzTarget target = TargetUnderTest();
  const std::vector<std::string> seeds = target.seeds();
  int readable = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Random random(seed);
    const std::string input = Mutate(seeds[random.Index(seeds.size())], random);
    const auto start = std::chrono::steady_clock::now();
    readable += ReadFuzzed(target, input) ? 1 : 0;
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    ASSERT_LT(took.count(), 10.0) << "mutation " << seed;
  }
  // Inputs are a few kilobytes; sanitizers alone keep some hundred megabytes.
  EXPECT_LT(PeakMegabytes(), 2048.0);
  // Both outcomes occur, or the mutations do not reach where they should. Strict formats, in which
  // nearly every byte matters, refuse most.
  EXPECT_GT(readable, 10);
  EXPECT_LT(readable, 1900);
}

}  // namespace
}  // namespace backsight
