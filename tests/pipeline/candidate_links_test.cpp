#include "pipeline/candidate_links.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace backsight {
namespace {

/// An accepted pair of one motion.
Pair Accepted(double quality, int consensus) {
  Pair pair;
  PairCandidate& motion = pair.candidates.emplace_back();
  motion.verification.verdict = Verdict::kAccepted;
  motion.verification.reason = VerificationResult::Reason::kNone;
  motion.verification.quality.value = quality;
  motion.verification.consensus = consensus;
  return pair;
}

/// Whether the pair added last to five that fit by `common` becomes a doubtful link.
bool IsDoubtful(double common, const Pair& last) {
  std::vector<Pair> pairs(5, Accepted(common, 0));
  pairs.push_back(last);
  const std::vector<CandidateLink> links = MakeCandidateLinks(pairs, {});
  EXPECT_EQ(links.size(), pairs.size());
  EXPECT_TRUE(std::none_of(links.begin(), links.end() - 1,
                           [](const CandidateLink& made) { return made.link.doubtful; }));
  return links.back().link.doubtful;
}

TEST(CandidateLinks, OfAPoorerFitThanIsCommonAreDoubtful) {
  EXPECT_TRUE(IsDoubtful(0.84, Accepted(0.7, 0)));
  EXPECT_FALSE(IsDoubtful(0.84, Accepted(0.8, 0)));
  EXPECT_FALSE(IsDoubtful(0.7, Accepted(0.66, 0))) << "as common in coarse scans";
}

TEST(CandidateLinks, ThatKeyPointsProveNeedNoCommonFit) {
  EXPECT_FALSE(IsDoubtful(0.84, Accepted(0.7, 40)));
}

TEST(CandidateLinks, OfAFitThatProvesAnywhereAreAccepted) {
  EXPECT_FALSE(IsDoubtful(0.95, Accepted(0.81, 0)));
}

TEST(CandidateLinks, OfPredictedPairsDoNotSayWhatIsCommon) {
  Pair predicted = Accepted(0.4, 0);
  predicted.predicted = true;
  std::vector<Pair> pairs(7, predicted);
  for (int i = 0; i < 5; ++i) pairs.push_back(Accepted(0.84, 40));
  pairs.push_back(Accepted(0.7, 0));
  EXPECT_TRUE(MakeCandidateLinks(pairs, {}).back().link.doubtful);
}

}  // namespace
}  // namespace backsight
