// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "report/page.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(EscapeHtmlTest, LeavesNoMarkupInText) {
  EXPECT_EQ(EscapeHtml("a<b>&\"c\"'"), "a&lt;b&gt;&amp;&quot;c&quot;&#39;");
  EXPECT_EQ(EscapeHtml("</script><script>alert(1)</script>"),
            "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;");
}

TEST(EscapeHtmlTest, KeepsWholeCharactersAndReplacesBytesThatAreNone) {
  EXPECT_EQ(EscapeHtml("\xc3\xa4 \xe2\x82\xac \xf0\x9f\x9b\xb0"),
            "\xc3\xa4 \xe2\x82\xac \xf0\x9f\x9b\xb0");
  EXPECT_EQ(EscapeHtml("\xff|"), "\xef\xbf\xbd|");
  EXPECT_EQ(EscapeHtml("\xc3"), "\xef\xbf\xbd");                  // cut short
  EXPECT_EQ(EscapeHtml("\xc0\xbc"), "\xef\xbf\xbd\xef\xbf\xbd");  // overlong form of <
  EXPECT_EQ(EscapeHtml(std::string("a\0b", 3)),
            "a\xef\xbf\xbd"
            "b");
}

TEST(EscapeScriptJsonTest, CannotEndItsScriptElement) {
  EXPECT_EQ(EscapeScriptJson("{\"p\":\"</script><!--&\"}"),
            "{\"p\":\"\\u003c/script\\u003e\\u003c!--\\u0026\"}");
  EXPECT_EQ(EscapeScriptJson("a\xe2\x80\xa8z\xe2\x80\xa9"), "a\\u2028z\\u2029");
  EXPECT_EQ(EscapeScriptJson("[1.5,-2,\"\xe2\x82\xac\"]"), "[1.5,-2,\"\xe2\x82\xac\"]");
}

TEST(ReadableNumberTest, HasTheDigitsAskedForAndNoExponentInBetween) {
  EXPECT_EQ(ReadableNumber(1673.4567), "1673");
  EXPECT_EQ(ReadableNumber(0.012345, 3), "0.0123");
  EXPECT_EQ(ReadableNumber(-2.5), "-2.500");
  EXPECT_EQ(ReadableNumber(0.0), "0");
  EXPECT_EQ(ReadableNumber(2.3e-9, 3), "2.30e-09");
  EXPECT_EQ(ReadableNumber(std::numeric_limits<double>::quiet_NaN()), "-");
}

TEST(ReadableNumberTest, PartsThousandsFromFiveDigitsOn) {
  EXPECT_EQ(ReadableNumber(-123456.7),
            "-123\xe2\x80\xaf"
            "457");
  EXPECT_EQ(ReadableCount(1234567.0),
            "1\xe2\x80\xaf"
            "234\xe2\x80\xaf"
            "567");
  EXPECT_EQ(ReadableCount(std::size_t{9999}), "9999");
}

}  // namespace
}  // namespace sarblock
