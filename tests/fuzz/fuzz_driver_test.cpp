#include <gtest/gtest.h>

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

TEST(FuzzTarget, MutationsAreReadOrRefused) {
  const FuzzTarget target = TargetUnderTest();
  const std::vector<std::string> seeds = target.seeds();
  int readable = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Random random(seed);
    std::string input = seeds[random.Index(seeds.size())];
    for (std::uint64_t hits = 1 + random.Index(3); hits > 0; --hits) {
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
    readable += ReadFuzzed(target, input) ? 1 : 0;
  }
  // Both outcomes are common, or the mutations do not reach where they should.
  EXPECT_GT(readable, 100);
  EXPECT_LT(readable, 1900);
}

}  // namespace
}  // namespace backsight
