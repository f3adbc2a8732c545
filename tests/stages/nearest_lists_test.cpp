#include "stages/nearest_lists.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/random.h"
#include "tests/support/instruction_sets.h"

namespace backsight {
namespace {

TEST(NearestLists, HoldTheNearestOfAllThatWereOffered) {
  constexpr std::size_t kLists = 3;
  for (const std::size_t k : {1U, 5U, 8U, 9U, 50U}) {
    ForEachInstructionSet([&](const std::string& name) {
      Random random(k);
      NearestLists lists(kLists, k);
      std::vector<std::vector<std::pair<double, std::uint32_t>>> expected(kLists);
      for (std::uint32_t number = 0; number < 300; ++number) {
        const auto list = static_cast<std::uint32_t>(random.Index(kLists));
        const double squared = static_cast<double>(random.Index(20));
        const std::uint32_t shuffled = number * 77 % 300;
        lists.Offer(std::span(&list, 1), std::span(&squared, 1), std::span(&shuffled, 1));
        expected[list].emplace_back(squared, shuffled);
      }
      for (std::size_t list = 0; list < kLists; ++list) {
        std::sort(expected[list].begin(), expected[list].end());
        for (std::size_t n = 0; n < k; ++n) {
          EXPECT_EQ(lists.Squared(list, n), expected[list][n].first) << name;
          EXPECT_EQ(lists.Number(list, n), expected[list][n].second) << name;
        }
      }
    });
  }
}

TEST(NearestLists, WhatWasNotOfferedIsInfinitelyFar) {
  NearestLists lists(2, 3);
  const std::uint32_t list = 1;
  const double squared = 4.0;
  const std::uint32_t number = 6;
  lists.Offer(std::span(&list, 1), std::span(&squared, 1), std::span(&number, 1));
  EXPECT_TRUE(std::isinf(lists.Squared(0, 0)));
  EXPECT_EQ(lists.Squared(1, 0), 4.0);
  EXPECT_TRUE(std::isinf(lists.Squared(1, 1)));
  EXPECT_TRUE(std::isinf(lists.Squared(1, 2)));
}

}  // namespace
}  // namespace backsight
