#include "stages/descriptor_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "core/error.h"
#include "core/random.h"
#include "stages/descriptor_vectors.h"
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

/// Blocks that sum to 100, as of real surfaces; those of every `empty`-th have nothing in them.
std::vector<FpfhDescriptor> Histograms(std::uint64_t seed, std::size_t count, std::size_t empty) {
  std::vector<FpfhDescriptor> descriptors = FineDescriptors(seed, count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t block = 0; block < 3; ++block) {
      const std::span bins = std::span(descriptors[i]).subspan(11 * block, 11);
      const float sum = std::accumulate(bins.begin(), bins.end(), 0.0F);
      const float factor = i % empty == empty - 1 ? 0.0F : 100.0F / sum;
      for (float& bin : bins) bin *= factor;
    }
  }
  return descriptors;
}

constexpr FpfhDescriptor kOne{1.0F, 2.0F, 3.0F};

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
  ExpectReferenceMatches(FineDescriptors(5, 1030), FineDescriptors(6, 1500), 5);
  ExpectReferenceMatches(FineDescriptors(7, 150), FineDescriptors(8, 4500), 5);
  EXPECT_TRUE(MatchDescriptors({}, FineDescriptors(5, 4), {}).empty());
  EXPECT_TRUE(MatchDescriptors(FineDescriptors(5, 4), {}, {}).empty());
}

TEST(MatchDescriptors, EqualsBruteForceForHistograms) {
  ExpectReferenceMatches(Histograms(1, 900, 10000), Histograms(2, 1100, 10000), 5);
  ExpectReferenceMatches(Histograms(3, 900, 50), Histograms(4, 1100, 70), 5);
}

/// Where bounds are as wide as they may be: in the first case the grid is coarse beside most
/// distances, in the second much lies along the axes that it leaves out, in the third only one
/// side's lengths fill it.
TEST(MatchDescriptors, EqualsBruteForceWhereBoundsAreWide) {
  const auto with_outlier = [](std::uint64_t seed, std::size_t count) {
    std::vector<FpfhDescriptor> descriptors = FineDescriptors(seed, count);
    for (FpfhDescriptor& d : descriptors) {
      for (float& bin : d) bin /= 20.0F;
    }
    for (float& bin : descriptors[count / 2]) bin *= 5000.0F;
    return descriptors;
  };
  ExpectReferenceMatches(with_outlier(1, 442), with_outlier(2, 1389), 8);

  const auto far_away = [](std::uint64_t seed, std::size_t count) {
    Random random(seed);
    std::vector<FpfhDescriptor> descriptors(count);
    for (FpfhDescriptor& d : descriptors) {
      for (float& bin : d) bin = 1e6F + static_cast<float>(random.Index(3));
    }
    return descriptors;
  };
  ExpectReferenceMatches(far_away(3, 51), far_away(4, 1283), 1);
  ExpectReferenceMatches(far_away(5, 1283), far_away(6, 51), 1);

  std::vector<FpfhDescriptor> kinds = FineDescriptors(7, 5);
  std::vector<FpfhDescriptor> of_kinds;
  Random random(8);
  for (int i = 0; i < 1448; ++i) {
    of_kinds.push_back(kinds[random.Index(kinds.size())]);
    for (float& bin : of_kinds.back())
      bin = 0.5F * bin + static_cast<float>(1e-4 * random.Normal());
  }
  const auto histograms = Histograms(9, 540, 20);
  ExpectReferenceMatches(of_kinds, histograms, 15);
  ExpectReferenceMatches(histograms, of_kinds, 15);
}

TEST(FindNearestDescriptors, RefusesWhatIsNotFinite) {
  std::vector<FpfhDescriptor> some = FineDescriptors(1, 50);
  const std::vector<FpfhDescriptor> others = FineDescriptors(2, 40);
  std::vector<DescriptorNeighbor> of_some(3 * 50), of_others(3 * 40);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    some[17][30] = bad;
    EXPECT_THROW(FindNearestDescriptors(some, others, 3, of_some, of_others), InternalError);
    EXPECT_THROW(FindNearestDescriptors(others, some, 3, of_others, of_some), InternalError);
  }
}

TEST(FindNearestDescriptors, WithoutAnOtherSideNothingIsNear) {
  const std::vector<FpfhDescriptor> some(3);
  std::vector<DescriptorNeighbor> of_source(6, {1.0, 7});
  FindNearestDescriptors(some, {}, 2, of_source, {});
  for (const DescriptorNeighbor& none : of_source) EXPECT_TRUE(std::isinf(none.squared));
}

TEST(FindNearestDescriptors, EqualDistancesGoToTheLowerIndex) {
  constexpr std::size_t kNearest = 7;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const auto source = CoarseDescriptors(seed, 61 + seed);
    const auto target = CoarseDescriptors(50 + seed, 310 + seed);
    const auto of_source = ReferenceNearest(source, target, kNearest);
    const auto of_target = ReferenceNearest(target, source, kNearest);
    ForEachInstructionSet([&](const std::string& name) {
      std::vector<DescriptorNeighbor> there(kNearest * source.size());
      std::vector<DescriptorNeighbor> back(kNearest * target.size());
      FindNearestDescriptors(source, target, kNearest, there, back);
      for (std::size_t i = 0; i < there.size(); ++i) {
        EXPECT_EQ(there[i].index, of_source[i / kNearest][i % kNearest]) << name;
      }
      for (std::size_t i = 0; i < back.size(); ++i) {
        EXPECT_EQ(back[i].index, of_target[i / kNearest][i % kNearest]) << name;
      }
    });
  }
}

TEST(FindNearestDescriptors, DescriptorsThatOccurOftenAreFoundByIndex) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Random random(seed);
    const auto kinds = Histograms(seed, 30, 10000);
    const auto some = [&](std::size_t count) {
      std::vector<FpfhDescriptor> chosen(count);
      for (FpfhDescriptor& d : chosen) d = kinds[random.Index(kinds.size())];
      return chosen;
    };
    ExpectReferenceMatches(some(640 + seed), some(513 - seed), 5);
    ExpectReferenceMatches(some(97), std::vector<FpfhDescriptor>(130, kinds[0]), 9);
  }
  const std::vector<FpfhDescriptor> equal(90, kOne);
  ExpectReferenceMatches(equal, std::vector<FpfhDescriptor>(70, kOne), 5);
}

/// As of real scans: most of the differences along few directions, many descriptors of few kinds.
std::vector<FpfhDescriptor> SurfaceDescriptors(std::uint64_t seed, std::size_t count) {
  const auto kinds = Histograms(7, 12, 10000);
  Random random(seed);
  std::vector<FpfhDescriptor> descriptors(count);
  for (FpfhDescriptor& d : descriptors) {
    const FpfhDescriptor& a = kinds[random.Index(3)];
    const FpfhDescriptor& b = kinds[random.Index(kinds.size())];
    const float share = static_cast<float>(random.Uniform());
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      const double noise = random.Uniform(0.0, 0.3);
      d[bin] = share * a[bin] + (1.0F - share) * b[bin] + static_cast<float>(noise);
    }
  }
  return descriptors;
}

TEST(MatchDescriptors, EqualsBruteForceForSurfaces) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    ExpectReferenceMatches(SurfaceDescriptors(seed, 1300), SurfaceDescriptors(10 + seed, 1101), 5);
  }
  ExpectReferenceMatches(SurfaceDescriptors(1, 140), SurfaceDescriptors(2, 2200), 8);
  ExpectReferenceMatches(SurfaceDescriptors(3, 2200), SurfaceDescriptors(4, 140), 3);
}

/// Descriptors a ten thousandth of a bin apart, far from the others: the grid cannot tell them.
std::vector<FpfhDescriptor> CrowdedDescriptors(std::uint64_t seed, std::size_t count) {
  std::vector<FpfhDescriptor> descriptors = FineDescriptors(seed, count);
  Random random(seed + 1);
  for (std::size_t i = 0; i < count / 2; ++i) {
    descriptors[i] = FineDescriptors(99, 1).front();
    for (float& bin : descriptors[i]) bin += static_cast<float>(random.Uniform(0.0, 1e-4));
  }
  return descriptors;
}

TEST(MatchDescriptors, TellsApartWhatTheGridCannot) {
  ExpectReferenceMatches(CrowdedDescriptors(1, 320), CrowdedDescriptors(5, 290), 5);
}

TEST(MatchDescriptors, IsExactForBinsOfAnySize) {
  for (const float factor : {1e-6F, 1.0F, 1e6F}) {
    auto source = FineDescriptors(11, 150);
    auto target = FineDescriptors(12, 170);
    for (auto* side : {&source, &target}) {
      for (FpfhDescriptor& d : *side) {
        for (float& bin : d) bin *= factor;
      }
    }
    ExpectReferenceMatches(source, target, 5);
  }
}

}  // namespace
}  // namespace backsight
