#include "io/option_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/option_table.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

struct FakeOptions {
  double resolution_m = 0.1;
  int rounds = 3;
  bool polish = true;
  int solver = 1;

  std::vector<OptionSection> Sections() {
    return {{"registration", "How pairs are registered.", [this](OptionVisitor& v) {
               v.Real("resolution_m", resolution_m, "m", 0.01, 1.0, "Voxel edge");
               v.Integer("rounds", rounds, "1", 1, 10, "Rounds");
               v.Flag("polish", polish, "Polish a | b");
               v.Choice("solver", solver, {"exact", "gauss_newton"}, "Solver");
             }}};
  }
};

std::string Read(FakeOptions& options, const std::string& text) {
  YamlDocument document = YamlDocument::Parse(text, "a.yaml");
  ReadOptions(document.root(), options.Sections());
  try {
    document.ThrowIfInvalid();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(OptionReader, FillsFieldsAndKeepsDefaults) {
  FakeOptions options;
  EXPECT_EQ(Read(options, "registration: {resolution_m: 0.2, solver: exact}"), "");
  EXPECT_EQ(options.resolution_m, 0.2);
  EXPECT_EQ(options.rounds, 3);
  EXPECT_TRUE(options.polish);
  EXPECT_EQ(options.solver, 0);
}

TEST(OptionReader, MissingOrEmptySectionKeepsDefaults) {
  FakeOptions options;
  EXPECT_EQ(Read(options, "{}"), "");
  EXPECT_EQ(Read(options, "registration:\n  # resolution_m: 0.2\n"), "");
  EXPECT_EQ(options.resolution_m, 0.1);
}

TEST(OptionReader, NamesRangesChoicesAndNearestKeys) {
  FakeOptions options;
  const std::string complaint = Read(options,
                                     "registration:\n  resolution_m: 2\n  rounds: 0\n"
                                     "  polish: on\n  solver: exakt\n  resolutoin_m: 1\n");
  for (const char* part :
       {"5 mistakes",
        "a.yaml:2: registration.resolution_m: found '2'; expected a number from 0.01 to 1 m",
        "a.yaml:3: registration.rounds: found '0'; expected a whole number from 1 to 10",
        "a.yaml:4: registration.polish", "write true", "did you mean 'exact'?",
        "a.yaml:6: registration.resolutoin_m", "did you mean 'resolution_m'?"}) {
    EXPECT_THAT(complaint, HasSubstr(part));
  }
  EXPECT_EQ(options.resolution_m, 0.1);
  EXPECT_THAT(Read(options, "registration: 5"), HasSubstr("expected a map"));
}

TEST(OptionTable, ShowsDefaultUnitRangeAndMeaning) {
  FakeOptions options;
  const std::string text = OptionsAsText(options.Sections());
  for (const char* part : {"registration: How pairs", "resolution_m  0.1 m", "[0.01 to 1]",
                           "Voxel edge", "[exact, gauss_newton]"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  const std::string markdown = OptionsAsMarkdown(options.Sections());
  EXPECT_THAT(markdown, HasSubstr("| `resolution_m` | 0.1 | m | 0.01 to 1 | Voxel edge |"));
  EXPECT_THAT(markdown, HasSubstr("Polish a \\| b"));
}

TEST(OptionTable, JsonParsesBack) {
  FakeOptions options;
  const auto json = nlohmann::ordered_json::parse(OptionsAsJson(options.Sections()));
  EXPECT_EQ(json["schema_version"], 1);
  const auto& list = json["sections"][0]["options"];
  ASSERT_EQ(list.size(), 4U);
  EXPECT_EQ(list[0]["default"], 0.1);
  EXPECT_EQ(list[1]["max"], 10);
  EXPECT_EQ(list[3]["choices"][1], "gauss_newton");
  EXPECT_EQ(list[3]["default"], "gauss_newton");
}

}  // namespace
}  // namespace backsight
