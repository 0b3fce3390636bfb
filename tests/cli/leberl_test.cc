// SPDX-License-Identifier: Apache-2.0
// `sarblock leberl ...` as the interface gives it, by running the program.
#include "sarblock/core/error.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/csv_rows.h"
#include "support/folder_test.h"
#include "support/run_program.h"
#include <fmt/core.h>
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

TEST_F(LeberlCommandTest, TextFitsATerminalAndListsEveryCellOnce) {
  for (const char* table : {"table1", "examples"}) {
    const std::size_t expected = json::parse(Leberl(table, {"--json"}).out).size();
    std::istringstream lines(Leberl(table, {}).out);
    std::size_t cells = 0;
    std::set<std::string> headings;
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 80u) << line;
      if (line.ends_with(" range")) {
        EXPECT_TRUE(headings.insert(line).second) << line;
      }
      for (const char* verdict : {" agrees", " truncation", " slip", " illegible"}) {
        cells += line.ends_with(verdict) && !line.starts_with(" ") ? 1U : 0U;
      }
    }
    const bool whole = table == std::string("table1");
    EXPECT_EQ(headings.size(), whole ? 4u : 0u);
    // The line of the sums ends with "illegible" too.
    EXPECT_EQ(cells, expected + (whole ? 1 : 0)) << table;
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

// The paper's example, hand: -100/8; -37.5 + 26.125 as printed, -37.5 - 26.125 by the geometry.
TEST_F(LeberlCommandTest, DifferencesAreThreePairsInAnObject) {
  const ProgramRun run =
      LeberlAt("differences", {"--dy-m", "1000", "--dz-m", "1000", "--db", "100", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json object = json::parse(run.out);
  for (const char* side : {"printed", "derivative", "exact"}) {
    EXPECT_EQ(object[side].size(), 2u) << side;
    EXPECT_NEAR(object[side]["ddy_m"].get<double>(), -12.5, 0.02 * 12.5) << side;
  }
  EXPECT_NEAR(object["printed"]["ddz_m"].get<double>(), -11.375, 1e-9);
  EXPECT_NEAR(object["derivative"]["ddz_m"].get<double>(), -63.625, 1e-9);
  EXPECT_NEAR(object["exact"]["ddz_m"].get<double>(), -63.625, 0.1 * 63.625);
  EXPECT_FALSE(object.contains("profile"));
}

TEST_F(LeberlCommandTest, DifferencesOfEverySourceHaveAnOption) {
  // hand, at y = 19 km, B = 8 km, H = 10 km, Dy = 1 km, Dz = 0: -Dy/B; 0; Eq. 24 A; 2 y Dy/B
  const double first = 19.0 / (8.0 * std::hypot(10.0, 19.0));
  const double second = -11.0 / (8.0 * std::hypot(10.0, 11.0));
  for (const auto& [option, across] : {std::pair{"--db", -0.125},
                                       std::pair{"--dh", 0.0},
                                       std::pair{"--dr-1", first},
                                       std::pair{"--dr-2", second},
                                       std::pair{"--range-scale-1-ppm", 2e-3 * 19.0 / 8.0},
                                       std::pair{"--range-scale-2-ppm", -2e-3 * 11.0 / 8.0}}) {
    const ProgramRun run =
        LeberlAt("differences", {"--dy-m", "1000", "--dz-m", "0", option, "1", "--json"});
    ASSERT_EQ(run.exit_code, 0) << option << run.err;
    EXPECT_NEAR(json::parse(run.out)["derivative"]["ddy_m"].get<double>(), across, 1e-9) << option;
  }
}

// Closed form: d(Dz) by dB is a parabola across the model, Eq. 17; over the length L it leaves its
// chord by L^2 dB/(4 B H) in the middle. A small dB, so that the exact curve is that of first
// order.
TEST_F(LeberlCommandTest, DifferencesAgainstDistanceShowTheBowOfTheModel) {
  const std::filesystem::path out = folder_ / "bow";
  const std::vector<std::string> more = {
      "--dy-m", "500", "--dz-m", "0", "--db", "0.01", "--far-ground-range-m", "24000"};
  std::vector<std::string> with_files = more;
  with_files.insert(with_files.end(), {"-o", out, "--json"});
  const ProgramRun run = LeberlAt("differences", with_files);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json object = json::parse(run.out);
  EXPECT_NEAR(object["bow"]["ddz_m"].get<double>(), 5e3 * 5e3 * 0.01 / (4.0 * 8e3 * 10e3), 1e-6);
  EXPECT_NEAR(object["bow"]["dy_m"].get<double>(), 2500.0, 51.0);
  ASSERT_EQ(object["profile"].size(), 11u);
  for (const json& row : object["profile"]) {  // Eq. 18 is linear and exact but for dB/B
    const double dy_m = row["dy_m"].get<double>();
    EXPECT_NEAR(row["exact"]["ddy_m"].get<double>(), -dy_m * 0.01 / 8e3, 1e-7);
  }
  test::CsvRows rows(
      out / "differences.csv",
      std::vector<TableColumn>{{"dy_m"}, {"printed_ddz_m"}, {"exact_ddz_m"}, {"exact_bow_m"}});
  int count = 0;
  double last_m = 0.0;
  while (rows.Next()) {
    const double dy_m = rows.Number(0);
    EXPECT_NEAR(rows.Number(1), dy_m * (8e3 - 38e3) / (8e3 * 10e3) * 0.01, 1e-9);  // Eq. 19
    EXPECT_NEAR(rows.Number(3), dy_m * (5e3 - dy_m) * 0.01 / (8e3 * 10e3), 1e-6);
    last_m = rows.Number(2);
    ++count;
  }
  EXPECT_EQ(count, 101);
  EXPECT_NEAR(last_m, -(24e3 * 16e3 - 19e3 * 11e3) * 0.01 / (8e3 * 10e3), 1e-5);  // Eq. 17
  EXPECT_TRUE(std::filesystem::exists(out / "bow.svg"));
  std::istringstream lines(LeberlAt("differences", more).out);
  int length = 0;
  for (std::string line; std::getline(lines, line); ++length) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_EQ(length, 7 + 4 + 11 + 1);
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

// tan of the looks are 1.9 and 1.1; sin(incidence) = (1 + 700/6378.137) sin(look) from an orbit.
TEST_F(LeberlCommandTest, ExaggerationTakesABaseTwoLooksOrAnOrbit) {
  const auto parse = [](const ProgramRun& run) {
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  };
  const json base = parse(LeberlAt("exaggeration", {"--json"}));
  EXPECT_NEAR(base["equivalent_base_m"].get<double>(), 1e8 * 8e3 / 2.09e8, 1e-9);  // H^2 B/(y(y-B))
  EXPECT_NEAR(base["opposite_side_exaggeration"].get<double>(), 5.0 * (1 / 1.9 + 1 / 1.1), 1e-12);
  const json looks = parse(Leberl("exaggeration",
                                  {"--look-1-deg",
                                   fmt::format("{}", std::atan(1.9) * kDegPerRad),
                                   "--look-2-deg",
                                   fmt::format("{}", std::atan(1.1) * kDegPerRad),
                                   "--height-m",
                                   "10000",
                                   "--json"}));
  for (const char* key : {"exaggeration", "equivalent_base_m", "intersection_deg"}) {
    EXPECT_NEAR(looks[key].get<double>(), base[key].get<double>(), 1e-9) << key;
  }
  const json orbit = parse(Leberl("exaggeration",
                                  {"--look-1-deg",
                                   "40",
                                   "--look-2-deg",
                                   "30",
                                   "--orbit-height-km",
                                   "700",
                                   "--body",
                                   "Earth",
                                   "--json"}));
  const auto incidence_deg = [](double look_deg) {
    return std::asin((1.0 + 700.0 / 6378.137) * std::sin(look_deg * kRadPerDeg)) * kDegPerRad;
  };
  EXPECT_NEAR(orbit["first_look_deg"].get<double>(), incidence_deg(40), 1e-9);
  EXPECT_NEAR(orbit["intersection_deg"].get<double>(), incidence_deg(40) - incidence_deg(30), 1e-9);
}

// Twice the viewing scale shows and fuses half as much; 1:M of relief h is q h/M before the eyes.
TEST_F(LeberlCommandTest, ExaggerationSaysWhatIsSeenAndWhatFuses) {
  const auto at = [](const std::string& scale) {
    return json::parse(LeberlAt("exaggeration", {"--viewing-scale", scale, "--json"}).out);
  };
  const json one = at("50000"), two = at("100000");
  for (const char* key : {"least_height_m", "largest_relief_m", "opposite_side_largest_relief_m"}) {
    EXPECT_NEAR(two[key].get<double>(), 2.0 * one[key].get<double>(), 1e-9) << key;
  }
  // first order: d = q h/(25.25 M e), 20 arc seconds
  const double least_m =
      20.0 / 3600.0 * kRadPerDeg * 25.25 * 5e4 * 0.065 / one["exaggeration"].get<double>();
  EXPECT_NEAR(one["least_height_m"].get<double>(), least_m, 1e-3 * least_m);
  EXPECT_NEAR(one["opposite_side_largest_relief_m"].get<double>() *
                  one["opposite_side_exaggeration"].get<double>(),
              one["largest_relief_m"].get<double>() * one["exaggeration"].get<double>(),
              1e-6);
  const ProgramRun text = LeberlAt("exaggeration", {"--viewing-scale", "50000"});
  EXPECT_THAT(text.out, HasSubstr("about 1.9 "));
  EXPECT_THAT(text.out, HasSubstr("hardly fuse"));
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
}

TEST_F(LeberlCommandTest, FiguresAreBesideEachOther) {
  const std::vector<std::string> ground = {"--base-m",
                                           "16",
                                           "--height-m",
                                           "20",
                                           "--ground-range-m",
                                           "38",
                                           "--sigma-range-m",
                                           "0.02",
                                           "--sigma-azimuth-m",
                                           "0.03"};  // a sonar
  std::vector<std::string> as_json = ground;
  as_json.emplace_back("--json");
  const ProgramRun run = Leberl("figures", as_json);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json rows = json::parse(run.out);
  std::set<std::string> figures;
  for (const json& row : rows) figures.insert(row["figure"].get<std::string>());
  EXPECT_EQ(figures, (std::set<std::string>{"3, 4", "5", "8, 9"}));
  EXPECT_EQ(rows[0]["configuration"], "same side");
  // Eq. 25 by hand: 0.02/16 hypot(r', r'') with r'^2 = 1844, r''^2 = 884
  EXPECT_NEAR(rows[0]["sigma_y_m"].get<double>(), 0.02 / 16.0 * std::sqrt(1844.0 + 884.0), 1e-9);
  EXPECT_NEAR(rows[0]["sigma_x_m"].get<double>(), 0.03 / std::sqrt(2.0), 1e-9);
  const ProgramRun text = Leberl("figures", ground);
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_THAT(text.out, HasSubstr("circles-coincide"));
  EXPECT_THAT(text.out, HasSubstr("real apertures"));
  EXPECT_EQ(Leberl("figures", {"--sigma-range-m", "0"}).exit_code, 3);
}

TEST_F(LeberlCommandTest, GroundRangeParallaxOfTheDatumIsTheBase) {
  const std::filesystem::path table =
      Put("in.csv", "ground_range_m,point_height_m\n13000,0\n19000,0\n25000,0\n");
  for (const char* presentation : {"ground", "slant"}) {
    const ProgramRun run = Leberl("parallax",
                                  {"--base-m",
                                   "8000",
                                   "--height-m",
                                   "10000",
                                   "--presentation",
                                   presentation,
                                   "--json",
                                   table});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    for (const json& row : json::parse(run.out)) {
      const double y_m = row["ground_range_m"].get<double>();
      const double slant_m = std::hypot(1e4, y_m) - std::hypot(1e4, y_m - 8e3);  // Eq. 8
      EXPECT_NEAR(row["absolute_parallax_m"].get<double>(),
                  presentation == std::string("ground") ? 8000.0 : slant_m,
                  1e-9);
    }
  }
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
  EXPECT_EQ(run.out, "");
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

}  // namespace
}  // namespace sarblock
