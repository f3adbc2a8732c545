#include "pipeline/option_words.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace backsight {
namespace {

using Words = std::vector<std::string>;

Words Split(std::string_view text) { return SplitWords(text, "--slurm-options"); }

TEST(OptionWords, AreDividedByBlanks) {
  EXPECT_EQ(Split(""), Words{});
  EXPECT_EQ(Split("  --time=1:00  -p\tcpu\n"), (Words{"--time=1:00", "-p", "cpu"}));
}

TEST(OptionWords, AreKeptTogetherByQuotesAndBackslashes) {
  EXPECT_EQ(Split("--comment='two words' a\"b c\"d"), (Words{"--comment=two words", "ab cd"}));
  EXPECT_EQ(Split("a\\ b '' \"\""), (Words{"a b", "", ""}));
  EXPECT_EQ(Split(R"("say \"yes\"" 'a\b' "a\b")"), (Words{"say \"yes\"", "a\\b", "a\\b"}));
}

TEST(OptionWords, AreNotExpanded) {
  EXPECT_EQ(Split("$HOME `x` *;|"), (Words{"$HOME", "`x`", "*;|"}));
}

TEST(OptionWords, WithAnOpenQuoteAreRefused) {
  EXPECT_THROW(Split("--comment='two words"), InputError);
  EXPECT_THROW(Split("\"a"), InputError);
}

}  // namespace
}  // namespace backsight
