#include "io/strict_yaml.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "core/error.h"
#include "core/random.h"
#include "io/nearest_name.h"
#include "io/utf8.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using Reader = std::function<void(YamlValue)>;

/// What reading `text` with `read` complains about; empty if nothing.
std::string Complaint(const std::string& text, const Reader& read) {
  try {
    YamlDocument document = YamlDocument::Parse(text, "dir/a.yaml");
    read(document.root());
    document.ThrowIfInvalid();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(StrictYaml, ReadsEveryType) {
  setenv("BACKSIGHT_TEST_FOLDER", "/data", 1);
  YamlDocument document = YamlDocument::Parse(
      "text: hello\nreal: 1.5e-3\nwhole: 3\nflag: true\nchoice: ply\nreals: [1, -2.5, +3]\n"
      "path: ${BACKSIGHT_TEST_FOLDER}/b.ptx\nrelative: ../c.ptx\nlist: [{a: 1}, {a: 2}]\n",
      "dir/a.yaml");
  const YamlValue root = document.root();
  EXPECT_EQ(root.Required("text").Text(), "hello");
  EXPECT_EQ(root.Required("real").Real(0.0), 1.5e-3);
  EXPECT_EQ(root.Required("whole").Real(0.0), 3.0);
  EXPECT_EQ(root.Required("whole").Integer(0, 0, 10), 3);
  EXPECT_TRUE(root.Required("flag").Flag(false));
  EXPECT_EQ(root.Required("choice").Choice(0, {"las", "ply"}), 1);
  EXPECT_EQ(root.Required("reals").Reals(3), (std::vector<double>{1.0, -2.5, 3.0}));
  EXPECT_EQ(root.Required("path").Path(), "/data/b.ptx");
  EXPECT_EQ(root.Required("relative").Path(), "c.ptx");
  const auto items = root.Required("list").Items(1);
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(items[1].Required("a").Integer(0, 0, 9), 2);
  EXPECT_EQ(items[1].Required("a").key(), "list[1].a");
  EXPECT_EQ(items[1].Required("a").Where(), "dir/a.yaml:9");
  EXPECT_FALSE(root.Optional("absent").present());
  EXPECT_EQ(root.Optional("absent").Real(7.0), 7.0);
  EXPECT_NO_THROW(document.ThrowIfInvalid());
}

struct Case {
  const char* text;
  Reader read;
  std::vector<const char*> parts;
};

TEST(StrictYaml, NamesWhatIsWrong) {
  unsetenv("BACKSIGHT_TEST_UNSET");
  setenv("BACKSIGHT_TEST_EMPTY", "", 1);
  const Reader real = [](YamlValue v) { v.Required("k").Real(0, {0, 10, "m"}); };
  const Reader integer = [](YamlValue v) { v.Required("k").Integer(0, 1, 5); };
  const Reader flag = [](YamlValue v) { v.Required("k").Flag(false); };
  const Reader choice = [](YamlValue v) { v.Required("k").Choice(0, {"las", "ply"}); };
  const Reader path = [](YamlValue v) { v.Required("k").Path(); };
  const Reader text = [](YamlValue v) { v.Required("k").Text(); };
  const Reader list = [](YamlValue v) { v.Required("k").Items(2, 3); };
  const Reader map = [](YamlValue v) { v.Required("k").Required("x").Text(); };
  const Reader nested = [](YamlValue v) { v.Required("m").Required("k").Text(); };
  const std::vector<Case> cases = {
      {"k: 11", real, {"dir/a.yaml:1: k: found '11'", "a number from 0 to 10 m"}},
      {"k: .nan", real, {"'.nan'", "a number"}},
      {"k: nan", real, {"'nan'"}},
      {"k: .inf", real, {"'.inf'"}},
      {"k: 1e999", real, {"'1e999'"}},
      {"k: 0x10", real, {"'0x10'"}},
      {"k: '1'", real, {"the text '1'", "without quotes"}},
      {"k: 1,5", real, {"'1,5'", "decimal point"}},
      {"k: 5 m", real, {"'5 m'", "without its unit"}},
      {"k: [1]", real, {"a list of 1", "a number"}},
      {"k: {a: 1}", real, {"a map", "a number"}},
      {"k:", real, {"found nothing", "a number"}},
      {"{}", real, {"k: found nothing", "the required key 'k'"}},
      {"k: 2.5", integer, {"'2.5'", "a whole number from 1 to 5"}},
      {"k: 99999999999999999999", integer, {"a whole number"}},
      {"k: yes", flag, {"'yes'", "true or false", "write true"}},
      {"k: Off", flag, {"'Off'", "write false"}},
      {"k: maybe", flag, {"'maybe'", "true or false"}},
      {"k: lsa", choice, {"'lsa'", "one of: las, ply", "did you mean 'las'?"}},
      {"k: ${BACKSIGHT_TEST_UNSET}/a", path, {"BACKSIGHT_TEST_UNSET is not set"}},
      {"k: ${BACKSIGHT_TEST_EMPTY}/a", path, {"BACKSIGHT_TEST_EMPTY is empty"}},
      {"k: ${oops", path, {"without its '}'"}},
      {"k: ${a b}", path, {"name of a variable"}},
      {"k: ''", text, {"empty text"}},
      {"k: [1]", list, {"a list of at least 2"}},
      {"k: [1, 2, 3, 4]", list, {"a list of at most 3"}},
      {"k: 7", list, {"'7'", "a list"}},
      {"k: 7", map, {"'7'", "a map"}},
      {"m:\n  k: a\n  k: b",
       nested,
       {"dir/a.yaml:3: m.k: found the same key a second time", "line 2"}},
      {"k: a\nkk: b", text, {"dir/a.yaml:2: kk: found an unknown key", "did you mean 'k'?"}},
      {"k: a\nzebra: b", text, {"zebra", "one of: k"}},
      {"k: a\n[1]: b", text, {"dir/a.yaml:2: found a key that is not text"}},
      {"k: &x a\n*x : b", text, {"dir/a.yaml:2: found an alias"}},
      {"k: a\n---\nk: b", text, {"a second document"}},
      {"", text, {"found nothing", "a map"}},
      {"- a", text, {"a list of 1", "a map"}},
  };
  for (const Case& c : cases) {
    const std::string complaint = Complaint(c.text, c.read);
    for (const char* part : c.parts) EXPECT_THAT(complaint, HasSubstr(part)) << c.text;
    EXPECT_THAT(complaint, HasSubstr("1 mistake\n")) << c.text;
  }
}

TEST(StrictYaml, SyntaxErrorsNameLineAndColumn) {
  EXPECT_THAT(Complaint("a: 1\nb: [1, 2\nc: }", [](YamlValue) {}),
              AllOf(HasSubstr("dir/a.yaml:3:"), HasSubstr("not valid YAML")));
  EXPECT_THAT(Complaint("a: 1\nb: \xff", [](YamlValue) {}),
              AllOf(HasSubstr("dir/a.yaml:2:4"), HasSubstr("0xff"), HasSubstr("UTF-8")));
}

TEST(StrictYaml, MissingFilesAndFoldersAreNamed) {
  EXPECT_THROW(YamlDocument::Load("no/such.yaml"), InputError);
  EXPECT_THROW(YamlDocument::Load("tests"), InputError);
}

TEST(StrictYaml, ListsEverythingSortedByLine) {
  const std::string complaint = Complaint("c: no\nb: x\na: y\nextra: 1\n", [](YamlValue v) {
    v.Required("a").Real(0);
    v.Required("b").Real(0);
    v.Required("c").Flag(true);
  });
  EXPECT_THAT(complaint, HasSubstr("4 mistakes"));
  EXPECT_LT(complaint.find("a.yaml:1: c"), complaint.find("a.yaml:2: b"));
  EXPECT_LT(complaint.find("a.yaml:2: b"), complaint.find("a.yaml:3: a"));
  EXPECT_LT(complaint.find("a.yaml:3: a"), complaint.find("a.yaml:4: extra"));
}

TEST(StrictYaml, SurvivesDeepAndHugeDocuments) {
  const Reader nothing = [](YamlValue v) { v.Optional("a").Text(); };
  for (const char* open : {"[", "{a: ", "- ", "? ", "a: [", "!t ", "&a "}) {
    std::string text;
    for (int i = 0; i < 20000; ++i) text += open;
    EXPECT_NE(Complaint(text, nothing), "") << open;
  }
  std::string bomb = "a0: &a0 [1, 1]\n";
  for (int i = 1; i < 40; ++i) {
    bomb += fmt::format("a{0}: &a{0} [*a{1}, *a{1}]\n", i, i - 1);
  }
  EXPECT_THAT(Complaint(bomb, nothing), HasSubstr("aliases are not supported"));
  EXPECT_THAT(Complaint(std::string(200000, 'x') + ": 1", nothing), HasSubstr("YAML"));
}

TEST(StrictYaml, MessagesAreCleanTextWhateverTheKeysHold) {
  const auto nothing = [](YamlValue v) { v.Optional("a"); };
  EXPECT_THAT(Complaint("\"\\e[31m\": 1", nothing), HasSubstr("?[31m: found an unknown key"));
  std::string umlauts;  // shortened in the middle of one
  for (int i = 0; i < 100; ++i) umlauts += "\u00e4";
  const std::string message = Complaint(umlauts + ": 1", nothing);
  EXPECT_EQ(CleanUtf8(message), message);
}

TEST(StrictYaml, SurvivesRandomText) {
  constexpr std::string_view kAlphabet = "ab:-[]{},&*!|>'\"%@`#? \n\t~0.\\";
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Random random(seed);
    std::string text;
    for (std::uint64_t n = random.Index(60); n > 0; --n) {
      text += kAlphabet[random.Index(kAlphabet.size())];
    }
    Complaint(text, [](YamlValue v) {
      v.Optional("a").Text();
      v.Optional("b").Items();
    });
  }
}

TEST(NearestName, FindsSlipsOnly) {
  const std::vector<std::string> names = {"scan", "scan_index", "levelled"};
  EXPECT_EQ(NearestName("scna", names), "scan");
  EXPECT_EQ(NearestName("leveled", names), "levelled");
  EXPECT_EQ(NearestName("scanindex", names), "scan_index");
  EXPECT_EQ(NearestName("colour", names), "");
  EXPECT_EQ(NearestName(std::string(1000000, 'x'), names), "");
}

}  // namespace
}  // namespace backsight
