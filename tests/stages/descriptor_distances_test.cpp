#include "stages/descriptor_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "stages/matching.h"
#include "tests/support/instruction_sets.h"

namespace backsight {
namespace {

/// Whole numbers, so that sums are exact, and few of them, so that distances are often equal.
std::vector<FpfhDescriptor> CoarseDescriptors(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<FpfhDescriptor> descriptors(count);
  for (FpfhDescriptor& d : descriptors) {
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      d[bin] = bin < 6 ? static_cast<float>(random.Index(3)) : 0.0F;
    }
  }
  return descriptors;
}

std::vector<FpfhDescriptor> FineDescriptors(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<FpfhDescriptor> descriptors(count);
  for (FpfhDescriptor& d : descriptors) {
    for (float& bin : d) bin = static_cast<float>(random.Uniform(0.0, 20.0));
  }
  return descriptors;
}

/// Every distance, sorted with its index.
std::vector<std::vector<std::uint32_t>> ReferenceNearest(const std::vector<FpfhDescriptor>& queries,
                                                         const std::vector<FpfhDescriptor>& others,
                                                         std::size_t k) {
  std::vector<std::vector<std::uint32_t>> nearest;
  for (const FpfhDescriptor& query : queries) {
    std::vector<std::pair<double, std::uint32_t>> all;
    for (std::uint32_t j = 0; j < others.size(); ++j) {
      double squared = 0.0;
      for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
        const double d = static_cast<double>(query[bin]) - static_cast<double>(others[j][bin]);
        squared += d * d;
      }
      all.emplace_back(squared, j);
    }
    std::sort(all.begin(), all.end());
    all.resize(std::min(all.size(), k));
    nearest.emplace_back();
    for (const auto& [squared, j] : all) nearest.back().push_back(j);
  }
  return nearest;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> ReferenceMatches(
    const std::vector<FpfhDescriptor>& source, const std::vector<FpfhDescriptor>& target,
    std::size_t k) {
  const auto of_source = ReferenceNearest(source, target, k);
  const auto of_target = ReferenceNearest(target, source, k);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
  for (std::uint32_t s = 0; s < source.size(); ++s) {
    for (const std::uint32_t t : of_source[s]) {
      const auto& back = of_target[t];
      if (std::find(back.begin(), back.end(), s) != back.end()) matches.emplace_back(s, t);
    }
  }
  return matches;
}

void ExpectReferenceMatches(const std::vector<FpfhDescriptor>& source,
                            const std::vector<FpfhDescriptor>& target, int k) {
  const auto expected = ReferenceMatches(source, target, static_cast<std::size_t>(k));
  ForEachInstructionSet([&](const std::string& name) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
    for (const DescriptorMatch& match : MatchDescriptors(source, target, {.neighbors = k})) {
      matches.emplace_back(match.source, match.target);
    }
    EXPECT_EQ(matches, expected) << name << " " << source.size() << " " << target.size();
  });
}

TEST(MatchDescriptors, EqualsBruteForceForEverySize) {
  for (std::size_t n = 1; n < 40; n += 3) {
    for (const std::size_t m : {1U, 15U, 16U, 17U, 300U}) {
      ExpectReferenceMatches(FineDescriptors(n, n), FineDescriptors(1000 + m, m), 5);
    }
  }
  ExpectReferenceMatches(FineDescriptors(1, 700), FineDescriptors(2, 530), 1);
  ExpectReferenceMatches(FineDescriptors(3, 257), FineDescriptors(4, 770), 50);
  EXPECT_TRUE(MatchDescriptors({}, FineDescriptors(5, 4), {}).empty());
  EXPECT_TRUE(MatchDescriptors(FineDescriptors(5, 4), {}, {}).empty());
}

TEST(FindNearestDescriptors, EqualDistancesGoToTheLowerIndex) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const auto source = CoarseDescriptors(seed, 61 + seed);
    const auto target = CoarseDescriptors(50 + seed, 310 + seed);
    const std::size_t stride = (target.size() + 15) / 16 * 16;
    std::vector<float> rows, squares, columns(kDescriptorBins * stride, 0.0F);
    std::vector<float> column_squares(stride, 0.0F);
    for (const FpfhDescriptor& d : source) {
      rows.insert(rows.end(), d.begin(), d.end());
      squares.push_back(0.0F);
      for (const float bin : d) squares.back() += bin * bin;
    }
    rows.resize(rows.size() + 3 * kDescriptorBins);
    for (std::size_t j = 0; j < target.size(); ++j) {
      for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
        columns[bin * stride + j] = target[j][bin];
        column_squares[j] += target[j][bin] * target[j][bin];
      }
    }
    constexpr std::size_t kNearest = 7;
    const auto of_source = ReferenceNearest(source, target, kNearest);
    const auto of_target = ReferenceNearest(target, source, kNearest);
    ForEachInstructionSet([&](const std::string& name) {
      std::vector<DescriptorNeighbor> there(kNearest * source.size());
      std::vector<DescriptorNeighbor> back(kNearest * target.size());
      FindNearestDescriptors({rows.data(), squares.data(), source.size()},
                             {columns.data(), column_squares.data(), target.size(), stride},
                             kNearest, there, back);
      for (std::size_t i = 0; i < there.size(); ++i) {
        EXPECT_EQ(there[i].index, of_source[i / kNearest][i % kNearest]) << name;
      }
      for (std::size_t i = 0; i < back.size(); ++i) {
        EXPECT_EQ(back[i].index, of_target[i / kNearest][i % kNearest]) << name;
      }
    });
  }
}

}  // namespace
}  // namespace backsight
