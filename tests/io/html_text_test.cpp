#include "io/html_text.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>

namespace backsight {
namespace {

TEST(HtmlText, NumbersAndBase64) {
  EXPECT_EQ(FixedText(-0.0001, 3, "x"), "0.000");
  EXPECT_EQ(FixedText(-1.25, 1, "x"), "-1.2");
  EXPECT_EQ(GroupedText(1234567),
            "1\xc2\xa0"
            "234\xc2\xa0"
            "567");
  EXPECT_EQ(GroupedText(12), "12");
  const auto base64 = [](std::string_view text) {
    return Base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  // RFC 4648, section 10.
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace backsight
