#include "pipeline/run_warnings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

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
  const auto warnings =
      WarningsOf({Link("A", "weak"), Link("B", "refined"), Link("C", "refined_on_surfaces"),
                  Link("D", "weak"), Link("E", "weak", LinkStatus::kDoubtful)});
  EXPECT_THAT(warnings, Contains(HasSubstr("2 accepted link(s) do not know one direction to 5 mm "
                                           "by themselves, as along a street or a tunnel: A - T, "
                                           "D - T; see")));
  EXPECT_THAT(warnings, Not(Contains(HasSubstr("fine registration ended as"))));
}

TEST(RunWarnings, TenLinksAreNamedAndOthersCounted) {
  std::vector<LinkRecord> links;
  for (int i = 1; i <= 10; ++i) links.push_back(Link(fmt::format("S{}", i), "weak"));
  EXPECT_THAT(WarningsOf(links), Contains(HasSubstr("S10 - T; see")));
  links.push_back(Link("S11", "weak"));
  const auto warnings = WarningsOf(links);
  EXPECT_THAT(warnings, Contains(HasSubstr("11 accepted link(s) do not know")));
  EXPECT_THAT(warnings, Contains(HasSubstr("S10 - T and others; see")));
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
