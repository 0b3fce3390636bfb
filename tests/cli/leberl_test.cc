// SPDX-License-Identifier: Apache-2.0
// `sarblock leberl ...` as the interface gives it, by running the program.
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "io/io_fixture.h"
#include "support/csv_rows.h"
#include "support/run_program.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::RunProgram;
using testing::HasSubstr;
using testing::StartsWith;

// The middle of the aircraft model.
const std::vector<std::string> kConfiguration = {
    "--base-m", "8000", "--height-m", "10000", "--ground-range-m", "19000"};

ProgramRun Leberl(const std::string& command, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"leberl", command};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

ProgramRun LeberlAt(const std::string& command, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = kConfiguration;
  arguments.insert(arguments.end(), more.begin(), more.end());
  return Leberl(command, arguments);
}

class LeberlCommandTest : public test::FolderTest {
 protected:
  // Standard output kept as a table, to be read by the reader every other table is read by.
  std::filesystem::path Table(const std::string& text) const { return Put("table.csv", text); }
};

TEST_F(LeberlCommandTest, Table1HasTheColumnsOfTheContractAndAVerdictInEveryRow) {
  const ProgramRun run = Leberl("table1", {"--csv"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out,
              StartsWith("configuration,position,quantity,dy_km,dz_km,source,size_m,printed_m,"
                         "formula_m,derivative_m,exact_m,verdict,note\n"));
  test::CsvRows reader(Table(run.out),
                       std::vector<TableColumn>{{"configuration"},
                                                {"position"},
                                                {"quantity"},
                                                {"dy_km"},
                                                {"source"},
                                                {"printed_m"},
                                                {"formula_m"},
                                                {"derivative_m"},
                                                {"exact_m"},
                                                {"verdict"},
                                                {"note"}});
  std::map<std::string, int> verdicts;
  std::set<std::string> cells;
  while (reader.Next()) {
    const std::string verdict(reader.Text(9));
    ++verdicts[verdict];
    std::string cell;
    for (const std::size_t column : {0u, 1u, 2u, 4u})
      cell += std::string(reader.Text(column)) + ' ';
    if (reader.Text(2) == "dy" || reader.Text(2) == "dz") {
      EXPECT_FALSE(reader.Given(3)) << cell;
      EXPECT_TRUE(cells.insert(cell).second) << cell;
    } else {
      EXPECT_TRUE(reader.Given(3)) << cell;
    }
    EXPECT_EQ(reader.Given(5), verdict != "illegible") << cell;
    EXPECT_FALSE(reader.Text(10).empty() && verdict != "agrees") << cell;
    if (verdict == "agrees" || verdict == "truncation") {
      const double formula_m = reader.Number(6);
      EXPECT_NEAR(reader.Number(7), formula_m, 1e-9 * std::abs(formula_m)) << cell;
    }
  }
  // 4 columns of the paper's table, 6 rows, 3 sources each
  EXPECT_EQ(verdicts["agrees"] + verdicts["truncation"] + verdicts["slip"] + verdicts["illegible"],
            72);
  EXPECT_EQ(verdicts.size(), 4u);
  EXPECT_EQ(verdicts["illegible"], 3);  // the cells with a question mark
  EXPECT_EQ(cells.size(), 24u);
}

TEST_F(LeberlCommandTest, TextFitsATerminalAndTellsEveryCellOnce) {
  for (const char* table : {"table1", "examples"}) {
    std::istringstream lines(Leberl(table, {}).out);
    int cells = 0;
    std::set<std::string> headings;
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 80u) << line;
      if (line.ends_with(" range")) {
        EXPECT_TRUE(headings.insert(line).second) << line;
      }
      for (const char* verdict : {" agrees", " truncation", " slip", " illegible"}) {
        cells += line.ends_with(verdict) && !line.starts_with(" ") ? 1 : 0;
      }
    }
    const bool whole = table == std::string("table1");
    EXPECT_EQ(headings.size(), whole ? 4u : 0u);
    // The line of the sums ends with "illegible" too.
    EXPECT_EQ(cells, whole ? 73 : 22) << table;
  }
}

TEST_F(LeberlCommandTest, TablesEndWithTheirSlipsByCause) {
  for (const char* table : {"table1", "examples"}) {
    const ProgramRun run = Leberl(table, {});
    int slips = 0;
    for (const json& cell : json::parse(Leberl(table, {"--json"}).out)) {
      slips += cell["verdict"] == "slip" ? 1 : 0;
      EXPECT_EQ(cell["cause"] != "", cell["verdict"] == "slip") << cell.dump();
    }
    const std::size_t heading = run.out.find("\nslips by cause\n");
    ASSERT_NE(heading, std::string::npos) << table;
    std::istringstream lines(run.out.substr(heading + 16));
    int counted = 0, last = slips;
    std::string line;
    while (std::getline(lines, line)) {
      const int count = std::stoi(line);
      EXPECT_LE(count, last) << line;  // the most frequent first
      last = count;
      counted += count;
    }
    EXPECT_EQ(counted, slips) << table;
  }
}

TEST_F(LeberlCommandTest, ErrorsAreThreeTriplesInAnObject) {  // Eq. 16 and 17 by hand
  const ProgramRun run = LeberlAt("errors", {"--dy0-2", "100", "--along-m", "731.5", "--json"});
  EXPECT_EQ(run.exit_code, 0);
  const json object = json::parse(run.out);
  for (const char* side : {"formula", "derivative", "exact"}) {
    ASSERT_TRUE(object.contains(side)) << side;
    for (const char* key : {"dx_m", "dy_m", "dz_m"}) {
      EXPECT_TRUE(object[side][key].is_number()) << side << key;
    }
    EXPECT_EQ(object[side].size(), 3u) << side;
  }
  EXPECT_FALSE(object.contains("sigma_y_m"));
  EXPECT_NEAR(object["formula"]["dy_m"].get<double>(), -137.5, 1e-9);   // 100 (8 - 19)/8
  EXPECT_NEAR(object["formula"]["dz_m"].get<double>(), -261.25, 1e-9);  // -100 19 11/(8 10)
  EXPECT_NEAR(object["derivative"]["dz_m"].get<double>(), -261.25, 1e-9);
  const double exact_m = object["exact"]["dz_m"].get<double>();
  EXPECT_GT(std::abs(exact_m + 261.25), 0.1);  // finite: not the first order, but near it
  EXPECT_NEAR(exact_m, -261.25, 0.05 * 261.25);
}

TEST_F(LeberlCommandTest, ErrorsOfEverySourceHaveAnOption) {
  for (const char* source : {"--dx0", "--dy0", "--dz0", "--dr", "--dydot", "--dzdot"}) {
    for (const char* station : {"-1", "-2"}) {
      const ProgramRun run = LeberlAt("errors", {std::string(source) + station, "1e-3", "--json"});
      ASSERT_EQ(run.exit_code, 0) << source << station << run.err;
      const json d = json::parse(run.out)["derivative"];
      EXPECT_GT(std::abs(d["dx_m"].get<double>()) + std::abs(d["dy_m"].get<double>()) +
                    std::abs(d["dz_m"].get<double>()),
                1e-5)
          << source << station;
    }
  }
}

TEST_F(LeberlCommandTest, SigmaRangeAddsEq25AndItsRigorousCounterpart) {  // two routes
  const ProgramRun run = Leberl("errors",
                                {"--base-m",
                                 "40e3",
                                 "--height-m",
                                 "375e3",
                                 "--ground-range-m",
                                 "395e3",
                                 "--sigma-range-m",
                                 "100",
                                 "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json object = json::parse(run.out);
  for (const char* axis : {"y", "z"}) {
    const double sigma_m = object[std::string("sigma_") + axis + "_m"].get<double>();
    EXPECT_NEAR(sigma_m, 1.9e3, 50.0);  // the paper's number
    EXPECT_NEAR(object[std::string("rigorous_sigma_") + axis + "_m"].get<double>(),
                sigma_m,
                1e-9 * sigma_m);
  }
}

TEST_F(LeberlCommandTest, OppositeSideIsAskedFor) {
  EXPECT_EQ(Leberl("errors", {"--base-m", "31e3", "--height-m", "10e3", "--ground-range-m", "19e3"})
                .exit_code,
            3);
  EXPECT_EQ(
      Leberl("errors",
             {"--base-m", "31e3", "--height-m", "10e3", "--ground-range-m", "19e3", "--opposite"})
          .exit_code,
      0);
}

TEST_F(LeberlCommandTest, ExaggerationIsThatOfEq11) {  // 5 H B/(y (y - B)) = 4e8/(19e3 11e3)
  const ProgramRun run = LeberlAt("exaggeration", {"--json"});
  ASSERT_EQ(run.exit_code, 0);
  const json object = json::parse(run.out);
  EXPECT_NEAR(object["exaggeration"].get<double>(), 4e8 / 2.09e8, 1e-12);
  EXPECT_NEAR(object["exaggeration_from_angles"].get<double>(), 4e8 / 2.09e8, 1e-12);
  EXPECT_TRUE(object["looks_not_below_40_deg"].get<bool>());             // atan 1.1 = 47.7 degrees
  EXPECT_TRUE(object["intersection_within_12_and_15_deg"].get<bool>());  // 14.5 degrees
}

TEST_F(LeberlCommandTest, ParallaxAnswersEachRowOfATable) {  // Eq. 6: dp = h (cot'' - cot')
  const double per_height = 10e3 / 11e3 - 10e3 / 19e3;
  const std::filesystem::path table =
      Put("in.csv",
          "point,ground_range_m,point_height_m,parallax_m\n\"a,1\",19000,123.5,\nb,19000,,50\n");
  const ProgramRun run = Leberl(
      "parallax", {"--base-m", "8000", "--height-m", "10000", "--presentation", "ground", table});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  test::CsvRows reader(
      Table(run.out),
      std::vector<TableColumn>{
          {"point"}, {"point_height_m"}, {"parallax_m"}, {"exact_point_height_m"}});
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Text(0), "a,1");
  EXPECT_NEAR(reader.Number(2), 123.5 * per_height, 1e-10);
  ASSERT_TRUE(reader.Next());
  EXPECT_NEAR(reader.Number(1), 50.0 / per_height, 1e-9);
  EXPECT_NEAR(reader.Number(3), 50.0 / per_height, 10.0);  // spherical fronts: second order
  EXPECT_FALSE(reader.Next());
}

TEST_F(LeberlCommandTest, ParallaxNamesTheRowAtFault) {
  const std::filesystem::path table =
      Put("in.csv", "ground_range_m,point_height_m,parallax_m\n19000,1,\n19000,1,2\n");
  const ProgramRun run = Leberl(
      "parallax", {"--base-m", "8000", "--height-m", "10000", "--presentation", "slant", table});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("in.csv:3: point_height_m"));
}

TEST_F(LeberlCommandTest, SingleFlightIsUndeterminedForEveryPairOfSquints) {
  for (const char* forward : {"15", "40"}) {
    const ProgramRun run = Leberl("single-flight",
                                  {"--height-m",
                                   "10000",
                                   "--ground-range-m",
                                   "19000",
                                   "--squint-1-deg",
                                   forward,
                                   "--squint-2-deg",
                                   "-23.5",
                                   "--json"});
    EXPECT_EQ(run.exit_code, 4);
    const json object = json::parse(run.out);
    EXPECT_EQ(object["rank"], 2);
    EXPECT_EQ(object["outcome"], "circles-coincide");
    EXPECT_THAT(run.err, HasSubstr("sarblock: "));
  }
}

TEST_F(LeberlCommandTest, ValidityWritesMapLinesAndNinePlots) {
  const std::filesystem::path out = folder_ / "maps";
  ASSERT_EQ(Leberl("validity", {"-o", out, "--quiet"}).exit_code, 0);
  int plots = 0;
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    plots += entry.path().extension() == ".svg" ? 1 : 0;
  }
  EXPECT_EQ(plots, 9);
  EXPECT_TRUE(std::filesystem::exists(out / "validity_map.csv"));
  test::CsvRows lines(
      out / "validity_lines.csv",
      std::vector<TableColumn>{{"error_ratio_1_percent"}, {"error_ratio_5_percent"}});
  int rows = 0;
  while (lines.Next()) {
    ++rows;
    if (!lines.Given(0) || !lines.Given(1)) continue;
    EXPECT_LE(lines.Number(0), lines.Number(1));
  }
  EXPECT_GT(rows, 100);
}

TEST_F(LeberlCommandTest, WrongUsageExitsWithTwoAndNonsenseWithThree) {
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"leberl"},
        {"leberl", "table2"},
        {"leberl", "errors", "--base-m", "8000"},
        {"leberl", "table1", "--csv=maybe"},
        {"leberl", "parallax", "--base-m", "8e3", "--height-m", "1e4", "--presentation", "up", "t"},
        {"leberl", "validity"}}) {
    const ProgramRun run = RunProgram(wrong);
    EXPECT_EQ(run.exit_code, 2) << wrong.back();
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err, "");
  }
  const ProgramRun no_base =
      Leberl("exaggeration", {"--base-m", "0", "--height-m", "1e4", "--ground-range-m", "19e3"});
  EXPECT_EQ(no_base.exit_code, 3);
  EXPECT_THAT(no_base.err, HasSubstr("base_m"));
}

}  // namespace
}  // namespace sarblock
