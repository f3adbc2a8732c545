#include "pipeline/unlinked_stations.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "graph/link_selection.h"
#include "io/link_reasons.h"
#include "stages/pair_selection.h"
#include "stages/verification.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

LinkRecord Link(const std::string& source, const std::string& target, LinkStatus status,
                const std::string& reason) {
  LinkRecord link;
  link.source = source;
  link.target = target;
  link.status = status;
  link.reason = reason;
  return link;
}

TEST(UnlinkedStations, DoubtfulLinksAreNamedWithWhatCouldConfirmThem) {
  std::vector<LinkRecord> links = {
      Link("S1", "S2", LinkStatus::kDoubtful, "free_space_conflict"),
      Link("S3", "S1", LinkStatus::kDoubtful, "unconfirmed"),
      Link("S2", "S3", LinkStatus::kRejected, "refuted_by_views"),
  };
  EXPECT_THAT(
      DescribeGap(links, {"S1"}),
      StartsWith(
          "; 2 pair(s) doubtful or ambiguous, the least seen through first: S1 - S2 (free space "
          "conflict, 0.0 %), S3 - S1 (unconfirmed, 0.0 %); no loop"));
  EXPECT_THAT(DescribeGap(links, {"S2"}),
              HasSubstr("first: S1 - S2 (free space conflict, 0.0 %); no loop"));
  EXPECT_THAT(DescribeGap(links, {"S1", "S2"}), HasSubstr("first: S3 - S1 (unconfirmed, 0.0 %); "));
  EXPECT_THAT(DescribeGap(links, {"S1"}), Not(HasSubstr("pairs: include")));
  // A station that could not be tried either is no way out.
  links.push_back(Link("S4", "S1", LinkStatus::kSkipped, "unusable_station"));
  EXPECT_THAT(DescribeGap(links, {"S1"}), Not(HasSubstr("pairs: include")));
  links.back().reason = "not_similar";
  EXPECT_THAT(DescribeGap(links, {"S1"}), HasSubstr("pairs: include"));
  EXPECT_THAT(DescribeGap(links, {"S4"}), StartsWith("; none of its pairs was tried"));
  // That of which least was seen through comes first.
  links[0].conflict = 0.2;
  links[1].conflict = 0.1;
  EXPECT_THAT(DescribeGap(links, {"S1"}),
              HasSubstr("first: S3 - S1 (unconfirmed, 10.0 %), S1 - S2"));
}

TEST(UnlinkedStations, TellWhatBecameOfTheirPairs) {
  const std::vector<LinkRecord> links = {
      Link("A", "S1", LinkStatus::kRejected, "low_overlap"),
      Link("S1", "B", LinkStatus::kDoubtful, "ambiguous"),
      Link("S1", "C", LinkStatus::kRejected, "ambiguous"),
      Link("S1", "D", LinkStatus::kFailed, "not enough memory"),
      Link("S1", "E", LinkStatus::kSkipped, "not_similar"),
      Link("A", "B", LinkStatus::kRejected, "tilted"),
  };
  const std::string text = DescribeUnlinked(links, "S1");
  EXPECT_THAT(
      text,
      StartsWith(
          "no accepted link to any other station; 2 pair(s) doubtful or ambiguous, the least seen "
          "through first: S1 - B (ambiguous, 0.0 %), S1 - C (ambiguous, 0.0 %); no"));
  EXPECT_THAT(text, HasSubstr("; of 4 pair(s) that were tried: 2 ambiguous (several placements fit "
                              "alike, as where a scene repeats or is symmetric), 1 failed, 1 low "
                              "overlap (too little of the two clouds would lie on each other)"));
  EXPECT_EQ(DescribeUnlinked(links, "E"),
            "no accepted link to any other station; none of its pairs was tried: 1 not similar "
            "(other pairs of the two parts were more alike)");
}

TEST(UnlinkedStations, NameNoMoreThanCanBeRead) {
  std::vector<LinkRecord> links;
  for (int i = 1; i <= 11; ++i) {
    links.push_back(Link("S0", fmt::format("T{}", i), LinkStatus::kDoubtful, "ambiguous"));
  }
  EXPECT_THAT(
      DescribeGap(links, {"S0"}),
      HasSubstr(
          "; 11 pair(s) doubtful or ambiguous, the least seen through first: S0 - T1 (ambiguous, "
          "0.0 %), S0 - T2 (ambiguous, 0.0 %), S0 - T3 (ambiguous, 0.0 %) and others"));
  EXPECT_THAT(DescribeGap(links, {"S0"}), Not(HasSubstr("T4")));
  for (const char* reason : {"undetermined", "low_overlap", "contradicts_prior"}) {
    links.push_back(Link("S0", "U", LinkStatus::kRejected, reason));
  }
  const std::string text = DescribeUnlinked(links, "S0");
  EXPECT_THAT(text, HasSubstr("of 14 pair(s) that were tried: 11 ambiguous ("));
  EXPECT_THAT(text, HasSubstr("1 low overlap (too little of the two clouds would lie on each "
                              "other) and other reasons"));
}

TEST(LinkReasons, OfPairsAndLinksHaveMeanings) {
  std::vector<std::string> reasons = {"refuted_by_views", "unusable_station"};
  using Reason = VerificationResult::Reason;
  for (int r = static_cast<int>(Reason::kNone) + 1;
       r <= static_cast<int>(Reason::kContradictsPrior); ++r) {
    reasons.push_back(ToString(static_cast<Reason>(r)));
  }
  for (const LinkFate fate : {LinkFate::kContradictsNetwork, LinkFate::kRivalWon,
                              LinkFate::kUnconfirmed, LinkFate::kAmbiguous}) {
    reasons.push_back(ToString(fate));
  }
  PairProspect pair;
  reasons.push_back(SkipReason(pair, {}));
  for (const double overlap : {0.0, 1.0}) {
    pair.predicted_overlap = overlap;
    reasons.push_back(SkipReason(pair, {}));
  }
  pair.too_far = true;
  reasons.push_back(SkipReason(pair, {}));
  pair.excluded = true;
  reasons.push_back(SkipReason(pair, {}));
  for (const std::string& reason : reasons) {
    EXPECT_NE(reason, "");
    EXPECT_NE(MeaningOfReason(reason), "") << reason;
  }
  EXPECT_EQ(MeaningOfReason("not enough memory"), "");
  EXPECT_EQ(MeaningOfReason(""), "");
}

}  // namespace
}  // namespace backsight
