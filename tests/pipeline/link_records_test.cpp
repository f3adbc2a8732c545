#include "pipeline/link_records.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/support/matchers.h"

namespace backsight {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Stations with known poses whose pairs were all registered without error and are all used.
struct Survey {
  Survey(std::uint64_t seed, int count) {
    Random random(seed);
    for (int s = 0; s < count; ++s) {
      stations.emplace_back().spec.id = fmt::format("S{}", s + 1);
      survey_from_station.push_back(RandomTransform(random, 20.0));
    }
    for (int t = 0; t < count; ++t) {
      for (int s = t + 1; s < count; ++s) Link(random, s, t);
    }
  }

  /// A link between two stations, either way round, behind a candidate that is not used.
  void Link(Random& random, int s, int t) {
    if (random.Uniform() < 0.5) std::swap(s, t);
    Pair pair;
    pair.source = s;
    pair.target = t;
    pair.candidates.resize(2);
    pair.candidates[0].fine.target_from_source = RandomTransform(random, 20.0);
    PairCandidate& used = pair.candidates[1];
    used.coarse.target_from_source = used.fine.target_from_source =
        survey_from_station[static_cast<std::size_t>(t)].Inverse() *
        survey_from_station[static_cast<std::size_t>(s)];
    NetworkCandidate rival;
    rival.pair = static_cast<int>(pairs.size());
    rival.fate = LinkFate::kRivalWon;
    NetworkCandidate candidate;
    candidate.pair = rival.pair;
    candidate.candidate = 1;
    network.candidates.push_back(rival);
    network.candidates.push_back(candidate);
    pairs.push_back(std::move(pair));
  }

  std::size_t Find(int a, int b) const {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (std::minmax(pairs[p].source, pairs[p].target) == std::minmax(a, b)) return p;
    }
    ADD_FAILURE() << "no pair " << a << " " << b;
    return 0;
  }
  PairCandidate& Motion(int a, int b) { return pairs[Find(a, b)].candidates[1]; }
  NetworkCandidate& Fate(int a, int b) { return network.candidates[2 * Find(a, b) + 1]; }

  std::vector<ClosureRecord> Closures() const {
    return MakeClosureRecords(stations, pairs, network);
  }

  std::vector<Station> stations;
  std::vector<RigidTransform> survey_from_station;
  std::vector<Pair> pairs;
  Network network;
};

using Triangle = std::array<std::string, 3>;

std::vector<Triangle> Triangles(const std::vector<ClosureRecord>& closures) {
  std::vector<Triangle> triangles;
  triangles.reserve(closures.size());
  for (const ClosureRecord& closure : closures) triangles.push_back(closure.stations);
  return triangles;
}

bool Holds(const ClosureRecord& closure, const char* a, const char* b) {
  const auto has = [&](const char* id) {
    return std::find(closure.stations.begin(), closure.stations.end(), id) !=
           closure.stations.end();
  };
  return has(a) && has(b);
}

TEST(MakeClosureRecords, ListsEveryTriangleOnceAndRightOnesClose) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto closures = Survey(seed, 4).Closures();
    EXPECT_EQ(Triangles(closures),
              (std::vector<Triangle>{
                  {"S1", "S2", "S3"}, {"S1", "S2", "S4"}, {"S1", "S3", "S4"}, {"S2", "S3", "S4"}}));
    for (const ClosureRecord& closure : closures) {
      EXPECT_LT(closure.coarse_m, 1e-12);
      EXPECT_LT(closure.coarse_deg, 1e-12);
      EXPECT_LT(closure.fine_m, 1e-12);
      EXPECT_LT(closure.fine_deg, 1e-12);
    }
  }
}

TEST(MakeClosureRecords, ShowsAShiftInTheTrianglesOfItsLinkOnly) {
  // A shift stays as long as it is wherever in the loop it sits, whichever way it is gone.
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Survey survey(seed, 4);
    survey.Motion(1, 3).coarse.target_from_source.translation += Eigen::Vector3d(0.3, -0.4, 1.2);
    survey.Motion(1, 3).fine.target_from_source.translation += Eigen::Vector3d(0.0, 0.003, -0.004);
    int concerned = 0;
    for (const ClosureRecord& closure : survey.Closures()) {
      const bool holds = Holds(closure, "S2", "S4");
      EXPECT_NEAR(closure.coarse_m, holds ? 1.3 : 0.0, 1e-12);
      EXPECT_NEAR(closure.fine_m, holds ? 0.005 : 0.0, 1e-12);
      EXPECT_LT(closure.coarse_deg, 1e-9);
      EXPECT_LT(closure.fine_deg, 1e-9);
      concerned += holds ? 1 : 0;
    }
    EXPECT_EQ(concerned, 2);
  }
}

TEST(MakeClosureRecords, ShowsATurnAsLargeAsItIsAndWhatItMovesTheFirstStationBy) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Survey survey(seed, 3);
    // The link between the first two turns the scene about the second station's instrument: the
    // first comes back moved by the chord at its distance.
    const double distance_m = survey.Motion(0, 1).fine.target_from_source.translation.norm();
    constexpr double kFine = 0.002;
    constexpr double kCoarse = 0.5;
    const auto turn = [&](double angle, RigidTransform* motion) {
      const RigidTransform& survey_from_second = survey.survey_from_station[1];
      const Eigen::Vector3d to_first =
          survey_from_second.Inverse() * survey.survey_from_station[0].translation;
      const Eigen::Vector3d axis = to_first.unitOrthogonal();
      const RigidTransform about_second{ExpSo3(angle * axis), Eigen::Vector3d::Zero()};
      const bool second_is_target = survey.pairs[survey.Find(0, 1)].target == 1;
      *motion = second_is_target ? about_second * *motion : *motion * about_second.Inverse();
    };
    turn(kCoarse, &survey.Motion(0, 1).coarse.target_from_source);
    turn(kFine, &survey.Motion(0, 1).fine.target_from_source);
    const auto closures = survey.Closures();
    ASSERT_EQ(closures.size(), 1U);
    EXPECT_NEAR(closures[0].coarse_deg, kCoarse * kDegrees, 1e-9);
    EXPECT_NEAR(closures[0].fine_deg, kFine * kDegrees, 1e-9);
    EXPECT_NEAR(closures[0].coarse_m, 2.0 * distance_m * std::sin(0.5 * kCoarse), 1e-9);
    EXPECT_NEAR(closures[0].fine_m, 2.0 * distance_m * std::sin(0.5 * kFine), 1e-9);
  }
}

TEST(MakeClosureRecords, KnowsOnlyTrianglesOfUsedLinks) {
  Survey survey(7, 6);
  // Two components, of the first and the last three; the links between them are not used, for
  // whatever reason.
  constexpr LinkFate kReasons[] = {LinkFate::kContradictsNetwork, LinkFate::kAmbiguous,
                                   LinkFate::kUnconfirmed};
  for (int a = 0; a < 3; ++a) {
    for (int b = 3; b < 6; ++b) survey.Fate(a, b).fate = kReasons[b - 3];
  }
  EXPECT_EQ(Triangles(survey.Closures()),
            (std::vector<Triangle>{{"S1", "S2", "S3"}, {"S4", "S5", "S6"}}));
  // One link across is a bridge and closes no triangle; nor does a refuted link.
  survey.Fate(2, 3).fate = LinkFate::kUsed;
  survey.Fate(4, 5).refuted = true;
  EXPECT_EQ(Triangles(survey.Closures()), (std::vector<Triangle>{{"S1", "S2", "S3"}}));
}

TEST(MakeLinkRecords, CallsALinkDoubtfulThatNothingConfirms) {
  Survey survey(1, 3);
  survey.network.component = {0, 0, 0};
  survey.network.survey_from_station = survey.survey_from_station;
  for (std::size_t p = 0; p < survey.pairs.size(); ++p) {
    survey.network.reported.push_back(static_cast<int>(2 * p + 1));
  }
  const auto doubt = [&](int a, int b, VerificationResult::Reason reason) {
    survey.Fate(a, b).fate = LinkFate::kUnconfirmed;
    VerificationResult& first = survey.pairs[survey.Find(a, b)].candidates[0].verification;
    first.verdict = Verdict::kDoubtful;
    first.reason = reason;
  };
  doubt(0, 1, VerificationResult::Reason::kFreeSpace);
  doubt(0, 2, VerificationResult::Reason::kNone);
  doubt(1, 2, VerificationResult::Reason::kFreeSpace);
  survey.Fate(1, 2).refuted = true;
  auto records = MakeLinkRecords(survey.stations, survey.pairs, survey.network);
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(ToString(records[survey.Find(0, 1)].status), "doubtful");
  EXPECT_EQ(records[survey.Find(0, 1)].reason, "free_space_conflict");
  EXPECT_EQ(ToString(records[survey.Find(0, 2)].status), "doubtful");
  EXPECT_EQ(records[survey.Find(0, 2)].reason, "unconfirmed");
  EXPECT_EQ(ToString(records[survey.Find(1, 2)].status), "rejected");
  EXPECT_EQ(records[survey.Find(1, 2)].reason, "refuted_by_views");
}

TEST(MakeLinkRecords, ResidualIsHowFarApartTheSourceStands) {
  Survey survey(2, 3);
  survey.network.component = {0, 0, -1};
  survey.network.survey_from_station = survey.survey_from_station;
  for (std::size_t p = 0; p < survey.pairs.size(); ++p) {
    survey.network.reported.push_back(static_cast<int>(2 * p + 1));
  }
  const std::size_t joined = survey.Find(0, 1);
  Pair& pair = survey.pairs[joined];
  RigidTransform& link = pair.candidates[1].fine.target_from_source;
  // Turned about the source's own place, which stays, and then moved by 5 mm.
  link.rotation = ExpSo3(Eigen::Vector3d(0.0, 0.0, 0.01)) * link.rotation;
  link.translation += Eigen::Vector3d(0.003, 0.0, -0.004);
  survey.Fate(0, 1).residual_sigmas = 1.7;
  auto records = MakeLinkRecords(survey.stations, survey.pairs, survey.network);
  EXPECT_EQ(records[joined].network_residual_sigmas, 1.7);
  EXPECT_FALSE(records[survey.Find(0, 2)].network_residual_sigmas);
  EXPECT_NEAR(*records[joined].network_residual_m, 0.005, 1e-12);
  EXPECT_NEAR(*records[joined].network_residual_deg, 0.01 * kDegrees, 1e-9);
  EXPECT_FALSE(records[survey.Find(0, 2)].network_residual_m);
  // Without planes there is no distance from them.
  EXPECT_FALSE(records[joined].rms_m);
  pair.candidates[1].fine.rms_m = 0.002;
  records = MakeLinkRecords(survey.stations, survey.pairs, survey.network);
  EXPECT_EQ(*records[joined].rms_m, 0.002);
}

TEST(MakeLinkRecords, TheReportedMotionIsThePredictedOneOrNot) {
  Survey survey(2, 3);
  survey.network.component = {0, 0, -1};
  survey.network.survey_from_station = survey.survey_from_station;
  for (std::size_t p = 0; p < survey.pairs.size(); ++p) {
    survey.network.reported.push_back(static_cast<int>(2 * p + 1));  // the second of each pair
    survey.pairs[p].candidates[p == 0 ? 1 : 0].predicted = true;
  }
  const auto records = MakeLinkRecords(survey.stations, survey.pairs, survey.network);
  EXPECT_TRUE(records[0].predicted);
  for (std::size_t p = 1; p < records.size(); ++p) EXPECT_FALSE(records[p].predicted) << p;
}

}  // namespace
}  // namespace backsight
