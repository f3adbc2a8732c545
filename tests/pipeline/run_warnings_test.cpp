#include "pipeline/run_warnings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

namespace backsight {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

LinkRecord Link(const std::string& source, const std::string& fine_status,
                LinkStatus status = LinkStatus::kAccepted) {
  LinkRecord link;
  link.source = source;
  link.target = fmt::format("T");  // GCC 12 warns of nothing where a literal is assigned
  link.status = status;
  link.fine_status = fine_status;
  link.loop_controlled = true;
  return link;
}

std::vector<std::string> WarningsOf(std::vector<LinkRecord> links) {
  RunRecord run;
  run.links = std::move(links);
  AddWarnings(SurveyProject(), {}, PairDiscovery(), Network(), GeoreferencedNetwork(), &run);
  return run.warnings;
}

TEST(RunWarnings, LinksThatLeaveADirectionOpenAreNamedTogether) {
  std::vector<LinkRecord> links{Link("A", "weak"), Link("B", "refined"),
                                Link("C", "refined_on_surfaces"), Link("D", "weak"),
                                Link("E", "weak", LinkStatus::kDoubtful)};
  links[0].weakest_sigma_m = 0.0062;
  links[3].weakest_sigma_m = 0.0241;
  links.push_back(Link("F", "weak"));
  links.back().weakest_sigma_m = 100.0;
  links[3].worst_place = WorstPlaceRecord{.sigma_m = 0.0518};
  const auto warnings = WarningsOf(links);
  EXPECT_THAT(warnings,
              Contains(HasSubstr("3 accepted link(s) do not know one direction to 5 mm by "
                                 "themselves, as along a street, or up and down where little "
                                 "ground is seen: F - T (open), D - T (24.1 mm; scanner's place "
                                 "51.8 mm), A - T (6.2 mm); the")));
  EXPECT_THAT(warnings, Not(Contains(HasSubstr("fine registration ended as"))));
}

TEST(RunWarnings, TenLinksAreNamedAndOthersCounted) {
  std::vector<LinkRecord> links;
  const auto add = [&](int i) {
    links.push_back(Link(fmt::format("S{}", i), "weak"));
    links.back().weakest_sigma_m = 0.006;
  };
  for (int i = 1; i <= 10; ++i) add(i);
  EXPECT_THAT(WarningsOf(links), Contains(HasSubstr("S10 - T (6.0 mm); the")));
  add(11);
  const auto warnings = WarningsOf(links);
  EXPECT_THAT(warnings, Contains(HasSubstr("11 accepted link(s) do not know")));
  EXPECT_THAT(warnings, Contains(HasSubstr("S10 - T (6.0 mm) and others; the")));
}

TEST(RunWarnings, LinksThatClaimTooMuchAreNamedWorstFirst) {
  std::vector<LinkRecord> links;
  for (const auto& [name, sigmas] : {std::pair("A", 1.9), {"B", 2.5}, {"C", 4.0}, {"D", 9.0}}) {
    links.push_back(Link(name, "refined"));
    links.back().network_residual_m = 0.0012 * sigmas;
    links.back().network_residual_deg = 0.01 * sigmas;
    links.back().network_residual_sigmas = sigmas;
  }
  links.back().status = LinkStatus::kRejected;
  EXPECT_THAT(
      WarningsOf(links),
      Contains(HasSubstr("2 accepted link(s) lie further from the adjusted network than "
                         "their own sigmas tell: C - T (4.8 mm and 0.0400 deg: 4.0 sigmas), "
                         "B - T (3.0 mm and 0.0250 deg: 2.5 sigmas); either")));
  links.resize(1);
  EXPECT_THAT(WarningsOf(links), Not(Contains(HasSubstr("their own sigmas tell"))));
}

TEST(RunWarnings, APartThatStandsApartIsOneWarning) {
  RunRecord run;
  for (const auto& [name, component] : {std::pair("A", 0), {"B", 0}, {"C", 1}, {"D", 1}}) {
    PoseRecord pose;
    pose.station = name;
    pose.status = StationStatus::kRegistered;
    pose.component = component;
    run.poses.push_back(pose);
  }
  const auto doubtful = [&](const std::string& source, const char* target, const char* reason,
                            double conflict) {
    LinkRecord link = Link(source, "refined", LinkStatus::kDoubtful);
    link.target = fmt::format("{}", target);
    link.reason = fmt::format("{}", reason);
    link.conflict = conflict;
    run.links.push_back(link);
  };
  doubtful("C", "A", "free_space_conflict", 0.1);
  doubtful("C", "B", "far_from_start", 0.004);
  doubtful("C", "D", "ambiguous", 0.0);  // within the part
  AddWarnings(SurveyProject(), {}, PairDiscovery(), Network(), GeoreferencedNetwork(), &run);
  EXPECT_THAT(
      run.warnings,
      ::testing::ElementsAre(::testing::AllOf(
          HasSubstr(
              "component 2 (C, D) stands apart: no link joins it with other stations; "
              "2 pair(s) doubtful or ambiguous, the least seen through first: C - B (far from "
              "start, 0.4 %), C - A (free space conflict, 10.0 %); no loop"),
          HasSubstr("of 2 pair(s) that were tried: "))));
  GeoreferenceRecord ground;
  ground.component = 1;
  ground.status = "georeferenced";
  run.georeference.push_back(ground);
  run.warnings.clear();
  AddWarnings(SurveyProject(), {}, PairDiscovery(), Network(), GeoreferencedNetwork(), &run);
  EXPECT_THAT(run.warnings, Contains(HasSubstr("other stations; control alone places it; 2 pair")));
}

TEST(RunWarnings, WhereStationsStandApartLevelledOnesAreAskedFor) {
  SurveyProject project;
  project.stations.resize(2);
  const auto hinted = [&](StationStatus status, int component) {
    RunRecord run;
    run.poses.resize(2);
    run.poses[0].status = StationStatus::kRegistered;
    run.poses[0].component = 0;
    run.poses[1].status = status;
    run.poses[1].component = component;
    AddWarnings(project, {}, PairDiscovery(), Network(), GeoreferencedNetwork(), &run);
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& text) {
      return text.starts_with("no station is said to be levelled");
    });
  };
  EXPECT_EQ(hinted(StationStatus::kRegistered, 0), 0);
  EXPECT_EQ(hinted(StationStatus::kUnreadable, -1), 0);
  EXPECT_EQ(hinted(StationStatus::kRegistered, 1), 1);
  EXPECT_EQ(hinted(StationStatus::kNotRegistered, -1), 1);
  project.stations[1].levelled = true;
  EXPECT_EQ(hinted(StationStatus::kNotRegistered, -1), 0);
}

TEST(RunWarnings, LinksWithFewDistancesAreNamed) {
  RunRecord run;
  run.links = {Link("A", "refined"), Link("B", "refined"), Link("C", "refined")};
  run.distances.emplace();
  run.distances->pairs = {{{"A", "T"}, {.samples = 50}}, {{"T", "B"}, {.samples = 49}}};
  AddWarnings(SurveyProject(), {}, PairDiscovery(), Network(), GeoreferencedNetwork(), &run);
  EXPECT_THAT(run.warnings, Contains(HasSubstr("2 accepted link(s) join stations whose surfaces "
                                               "could be compared in fewer than 50 places")));
  EXPECT_THAT(run.warnings, Contains(HasSubstr("only from afar: B - T, C - T; look")));
}

TEST(RunWarnings, ALinkThatNothingRefinedIsNamedAlone) {
  EXPECT_THAT(WarningsOf({Link("A", "too_few_planes")}),
              Contains("link A - T: fine registration ended as too_few_planes"));
}

TEST(RunWarnings, AContradictionIsMeasuredWhereBothStationsArePlaced) {
  LinkRecord link = Link("A", "refined", LinkStatus::kRejected);
  link.reason = "contradicts_network";
  EXPECT_THAT(WarningsOf({link}), Contains("link A - T contradicts the network and was removed"));
  link.network_residual_m = 0.25;
  EXPECT_THAT(WarningsOf({link}),
              Contains("link A - T contradicts the network by 0.250 m and was removed"));
}

}  // namespace
}  // namespace backsight
