// SPDX-License-Identifier: Apache-2.0
// Places named by refusals of JSON files: file, line and dotted key.
#include "sarblock/core/error.h"

#include <string>

#include "support/folder_test.h"
#include "tables/json.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// The lines of its keys stand in the tests.
const std::string kText =
    "{\n"                                // 1
    "  \"name\": \"a\\n\\\"b\",\n"       // 2: an escaped line end and quote
    "  \"list\": [1.5, 2,\n"             // 3
    "    -3\n"                           // 4
    "  ],\n"                             // 5
    "\n"                                 // 6
    "  \"passes\": [{\"id\": \"A\"},\n"  // 7
    "    {\"id\": true, \"deep\": {\n"   // 8
    "      \"x\":\n"                     // 9
    "        null, \"none\": {}}}],\n"   // 10
    "  \"end\": false\n"                 // 11
    "}\n";

TEST(JsonFileTest, NamesTheLineOfEveryKey) {
  const JsonFile file(kText, "f.json");
  const auto line = [&file](const std::string& key) { return file.PlaceOf(key).line; };
  EXPECT_EQ(line("name"), 2U);
  EXPECT_EQ(line("list"), 3U);
  EXPECT_EQ(line("list[0]"), 3U);
  EXPECT_EQ(line("list[1]"), 3U);
  EXPECT_EQ(line("list[2]"), 4U);  // the line's end is the number's
  EXPECT_EQ(line("passes[0]"), 7U);
  EXPECT_EQ(line("passes[0].id"), 7U);
  EXPECT_EQ(line("passes[1].id"), 8U);
  EXPECT_EQ(line("passes[1].deep"), 8U);
  EXPECT_EQ(line("passes[1].deep.x"), 9U);
  EXPECT_EQ(line("passes[1].deep.none"), 10U);
  EXPECT_EQ(line("end"), 11U);
  EXPECT_EQ(line(""), 0U);
  EXPECT_EQ(line("passes[2]"), 0U);
  EXPECT_EQ(line("deep"), 0U);
}

TEST(JsonFileTest, RefusalsSayFileLineAndKey) {
  const JsonFile file(kText, "f.json");
  const JsonValue root = file.Root();
  const auto expect = [](const auto& run, const std::string& message) {
    EXPECT_EQ(test::MessageOf<InputError>(run), message);
  };
  expect([&] { static_cast<void>(root.Require("name").Number()); },
         "f.json:2: name: is string, a number is needed");
  const JsonValue pass = root.Require("passes").Entries()[1];
  expect([&] { static_cast<void>(pass.Require("id").Text()); },
         "f.json:8: passes[1].id: is boolean, a text is needed");
  expect([&] { static_cast<void>(pass.Require("end")); }, "f.json:8: passes[1].end: is missing");
  expect([&] { static_cast<void>(root.Require("begin")); }, "f.json: begin: is missing");
}

TEST(JsonFileTest, AListMayBeTheWhole) {
  const std::string text = "[1,\n{\"a\": 2}\n]";
  const JsonFile file(text, "f.json");
  EXPECT_EQ(file.PlaceOf("[0]").line, 1U);
  EXPECT_EQ(file.PlaceOf("[1].a").line, 2U);
}

TEST(JsonFileTest, WhatIsNoJsonNamesItsLine) {
  EXPECT_EQ(test::MessageOf<InputError>([] { JsonFile("{\n\"a\": 1,\n}", "f.json"); }),
            "f.json:3: is not valid JSON");
  EXPECT_EQ(test::MessageOf<InputError>([] { JsonFile("[1e999]", "f.json"); }),
            "f.json: is not valid JSON: a number is out of range");
}

}  // namespace
}  // namespace sarblock
