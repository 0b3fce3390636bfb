// SPDX-License-Identifier: Apache-2.0
// What the commands leave: files, columns and JSON as docs/formats.md promises them to other
// programs. The lists are typed by hand from there, not taken from the writer.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsSupersetOf;

const std::vector<std::string> kPointColumns = {"point",
                                                "role",
                                                "status",
                                                "looks",
                                                "x_m",
                                                "y_m",
                                                "z_m",
                                                "sigma_e_m",
                                                "sigma_n_m",
                                                "sigma_u_m",
                                                "cov_en_m2",
                                                "cov_eu_m2",
                                                "cov_nu_m2",
                                                "redundancy",
                                                "error_e_m",
                                                "error_n_m",
                                                "error_u_m",
                                                "chi_square_3",
                                                "lat_deg",
                                                "lon_deg",
                                                "h_m",
                                                "intersection_deg",
                                                "sigma_leberl_across_m",
                                                "sigma_leberl_up_m"};
const std::map<std::string, std::vector<std::string>> kColumns = {
    {"points.csv", kPointColumns},
    {"passes.csv",
     {"pass", "parameter", "unit", "value", "sigma", "prior_sigma", "significance", "kept"}},
    {"passes_covariance.csv", {"pass_a", "parameter_a", "pass_b", "parameter_b", "covariance"}},
    {"residuals.csv",
     {"pass",
      "point",
      "range_residual_m",
      "azimuth_residual_m",
      "range_redundancy",
      "azimuth_redundancy",
      "range_w",
      "azimuth_w",
      "range_mdb_m",
      "azimuth_mdb_m",
      "range_influence_m",
      "azimuth_influence_m",
      "weight",
      "rejected"}},
    {"trajectories.csv", {"pass", "time_s", "x_m", "y_m", "z_m", "vx_mps", "vy_mps", "vz_mps"}},
    {"pairs.csv",
     {"point_a",
      "point_b",
      "de_m",
      "dn_m",
      "du_m",
      "cov_ee_m2",
      "cov_nn_m2",
      "cov_uu_m2",
      "cov_en_m2",
      "cov_eu_m2",
      "cov_nu_m2",
      "sigma_leberl_across_m",
      "sigma_leberl_up_m"}}};
const std::vector<std::string> kSummaryKeys = {"format",
                                               "version",
                                               "block",
                                               "status",
                                               "accepted",
                                               "counts",
                                               "iterations",
                                               "initial_cost",
                                               "final_cost",
                                               "gradient",
                                               "sigma0_squared",
                                               "chi_square",
                                               "groups",
                                               "covariance",
                                               "condition",
                                               "stages",
                                               "warnings",
                                               "configuration"};

class ResultTest : public test::CliTest {};

std::vector<std::string> KeysOf(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

TEST_F(ResultTest, AnAdjustmentLeavesEveryFileWithItsColumns) {
  for (const char* scene : {"leberl-aircraft", "earth-same-side"}) {
    const Path block = Simulated(scene, scene);
    const std::string result = std::string("result-") + scene;
    const test::ProgramRun run = Run("adjust", block, result, {"--set", "pairs=neighbours"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    std::set<std::string> expected = {"summary.json"};
    if (std::string(scene) == "earth-same-side") expected.insert("points.geojson");
    for (const auto& [name, columns] : kColumns) expected.insert(name);
    expected.insert("control_quality.csv");
    expected.insert("strips.csv");
    EXPECT_EQ(FilesOf(folder_ / result), expected);
    for (const auto& [name, columns] : kColumns) {
      const auto rows = test::RowsOf(Content(folder_ / result / name));
      ASSERT_GE(rows.size(), 2u) << name;
      EXPECT_THAT(rows[0], IsSupersetOf(columns)) << name;
      EXPECT_EQ(std::set<std::string>(rows[0].begin(), rows[0].end()).size(), rows[0].size());
      for (const auto& row : rows) ASSERT_EQ(row.size(), rows[0].size()) << name;
    }
    const json summary = json::parse(Content(folder_ / result / "summary.json"));
    EXPECT_THAT(KeysOf(summary), IsSupersetOf(kSummaryKeys));
    EXPECT_EQ(summary["status"], "converged");
    EXPECT_EQ(summary["accepted"], true);
    EXPECT_EQ(summary["block"], scene);
  }
}

TEST_F(ResultTest, TheGeoJsonHasEveryPointWithItsSigmas) {
  const Path block = Simulated("earth-asc-desc", "block");
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  const json geo = json::parse(Content(folder_ / "result/points.geojson"));
  EXPECT_EQ(geo["type"], "FeatureCollection");
  const auto rows = test::RowsOf(Content(folder_ / "result/points.csv"));
  std::set<std::string> names, polygons;
  for (const json& feature : geo["features"]) {
    const std::string name = feature["properties"]["point"];
    (feature["geometry"]["type"] == "Point" ? names : polygons).insert(name);
  }
  EXPECT_EQ(names.size(), rows.size() - 1);
  EXPECT_EQ(polygons.size(), rows.size() - 1);
}

// The C library rounds what the table has.
TEST_F(ResultTest, TheGeoJsonHasDegreesWithTwelveDecimals) {
  const Path block = Simulated("earth-asc-desc", "block");
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  const std::string geo = Content(folder_ / "result/points.geojson");
  const auto rows = test::RowsOf(Content(folder_ / "result/points.csv"));
  const std::size_t lon = test::ColumnOf(rows, "lon_deg"), lat = test::ColumnOf(rows, "lat_deg");
  ASSERT_GT(rows.size(), 100u);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    std::array<char, 64> place;
    std::snprintf(place.data(),
                  place.size(),
                  "[%.12f,%.12f,",
                  std::stod(rows[i][lon]),
                  std::stod(rows[i][lat]));
    EXPECT_THAT(geo, HasSubstr(place.data())) << rows[i][0];
  }
}

TEST_F(ResultTest, JsonIsAloneOnStandardOutputAndIsTheSummary) {
  const Path block = Simulated("leberl-aircraft", "block");
  for (const char* command : {"adjust", "intersect", "predict"}) {
    const test::ProgramRun run = Run(command, block, command, {"--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json summary = json::parse(run.out);  // throws at anything before or after it
    EXPECT_THAT(KeysOf(summary), IsSupersetOf(kSummaryKeys)) << command;
    EXPECT_EQ(summary, json::parse(Content(folder_ / command / "summary.json"))) << command;
    EXPECT_EQ(summary["command"], command);
    EXPECT_THAT(
        KeysOf(summary["counts"]),
        IsSupersetOf({"passes", "points", "looks", "parameters", "observations", "redundancy"}));
    for (const char* stage : {"read", "covariance", "write"}) {
      if (std::string(command) == "intersect" && std::string(stage) == "covariance") continue;
      ASSERT_TRUE(summary["stages"].contains(stage)) << command << ' ' << stage;
      EXPECT_GE(summary["stages"][stage]["wall_s"], 0.0);
      EXPECT_GT(summary["stages"][stage]["peak_mib"], 0.0);
    }
  }
}

// Hand count: 344 points with 2 looks of 2 equations, 4 control points of 3 components, 6 priors;
// unknowns 3 a point and 6 corrections.
TEST_F(ResultTest, TheSummaryCountsAsTheBlockIsMade) {
  const Path block = Simulated("leberl-aircraft", "block");
  const test::ProgramRun run = Run("adjust", block, "result", {"--json"});
  const json summary = json::parse(run.out);
  EXPECT_EQ(summary["counts"]["passes"], 2);
  EXPECT_EQ(summary["counts"]["points"], 344);
  EXPECT_EQ(summary["counts"]["looks"], 688);
  EXPECT_EQ(summary["counts"]["observations"], 2 * 688 + 12 + 6);
  EXPECT_EQ(summary["counts"]["parameters"], 3 * 344 + 6);
  EXPECT_EQ(summary["counts"]["redundancy"], 2 * 688 + 12 - 3 * 344);
  for (const char* key : {"value", "redundancy", "lower", "upper", "level", "passed"}) {
    EXPECT_TRUE(summary["chi_square"].contains(key)) << key;
  }
  // The six priors share the redundancy of the block with looks and control.
  const double redundancy = summary["chi_square"]["redundancy"].get<double>();
  EXPECT_GT(redundancy, 350.0);
  EXPECT_LT(redundancy, 356.0);
  EXPECT_NEAR(summary["sigma0_squared"].get<double>() * redundancy,
              summary["chi_square"]["value"].get<double>(),
              1e-9);
}

TEST_F(ResultTest, CheckAndSimulateHaveJsonToo) {
  const test::ProgramRun simulated =
      test::RunProgram({"simulate",
                        std::string(SARBLOCK_DATASETS) + "/scenes/cross-wise.toml",
                        "-o",
                        folder_ / "block",
                        "--json"});
  EXPECT_EQ(json::parse(simulated.out)["looks"], 688);
  const test::ProgramRun check = test::RunProgram({"check", folder_ / "block", "--json"});
  EXPECT_EQ(json::parse(check.out)["control"], 4);
  EXPECT_EQ(FilesOf(folder_ / "block"),
            (std::set<std::string>{"block.toml",
                                   "observations.csv",
                                   "points.csv",
                                   "trajectories.csv",
                                   "truth.csv",
                                   "truth_passes.csv"}));
}

TEST_F(ResultTest, QuietSaysNothingOnStandardError) {
  const Path block = Simulated("leberl-aircraft", "block");
  Edit(block / "observations.csv", "range_m", "range_m,colour");  // a warning: unknown column
  std::string text;
  bool first = true;
  for (const auto& row : test::RowsOf(Content(block / "observations.csv"))) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? "," : "") + row[i];
    text += first ? "\n" : ",red\n";
    first = false;
  }
  Put("block/observations.csv", text);
  const test::ProgramRun loud = Run("adjust", block, "loud");
  EXPECT_EQ(loud.exit_code, 0) << loud.err;
  EXPECT_THAT(loud.err, HasSubstr("colour"));
  for (const char* command : {"adjust", "intersect", "predict"}) {
    const test::ProgramRun run = Run(command, block, "quiet", {"--quiet"});
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_EQ(run.err, "") << command;
  }
  const json summary = json::parse(Content(folder_ / "quiet/summary.json"));
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("colour"));  // not lost
}

// Two routes: options given by --set, and the dump of them in block.toml.
TEST_F(ResultTest, TheDumpedConfigurationReadsBackToTheSameAdjustment) {
  const Path block = Simulated("different-altitudes", "block");
  const std::vector<std::string> sets = {
      "--set",
      "robust_scale=2.9",
      "--set",
      "correction.position.degree=1",
      "--set",
      "correction.position.sigma_m=[[31.7,2.3],[93.1,5],[11.9,4.7]]",
      "--set",
      "correction.range.bias_sigma_m=7.3",
      "--set",
      "test_level=0.99"};
  std::vector<std::string> dumping = sets;
  dumping.push_back("--dump-config");
  const test::ProgramRun dump = Run("adjust", block, "unwritten", dumping);
  ASSERT_EQ(dump.exit_code, 0) << dump.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "unwritten"));
  EXPECT_THAT(dump.out, HasSubstr("robust_scale = 2.9"));
  ASSERT_EQ(Run("adjust", block, "by-set", sets).exit_code, 0);

  // [adjust] and its tables stand between [sigma] and the first [[pass]].
  std::string toml = Content(block / "block.toml");
  const std::size_t begin = toml.find("[adjust]"), end = toml.find("[[pass]]");
  ASSERT_LT(begin, end);
  toml.replace(begin, end - begin, dump.out + "\n");
  Put("block/block.toml", toml);
  ASSERT_EQ(Run("adjust", block, "by-file").exit_code, 0);
  EXPECT_EQ(Content(folder_ / "by-file/points.csv"), Content(folder_ / "by-set/points.csv"));
  EXPECT_EQ(Content(folder_ / "by-file/passes.csv"), Content(folder_ / "by-set/passes.csv"));
  EXPECT_EQ(Run("adjust", block, "unwritten", {"--dump-config"}).out, dump.out);
  EXPECT_EQ(json::parse(Content(folder_ / "by-file/summary.json"))["configuration"],
            json::parse(Content(folder_ / "by-set/summary.json"))["configuration"]);
}

TEST_F(ResultTest, SetOverridesTheBlockAndTheScene) {
  const Path block = Simulated("leberl-aircraft", "block", {"--set", "points.count=57"});
  const test::ProgramRun run =
      Run("adjust",
          block,
          "result",
          {"--json", "--set", "corrections=none", "--set", "covariance=none"});
  const json summary = json::parse(run.out);
  EXPECT_EQ(summary["counts"]["points"], 57 + 4 + 40);
  EXPECT_EQ(summary["counts"]["parameters"], 3 * (57 + 4 + 40));
  EXPECT_EQ(summary["configuration"]["corrections"], "none");
  EXPECT_EQ(summary["covariance"], "none");
  const auto rows = test::RowsOf(Content(folder_ / "result/points.csv"));
  const std::size_t sigma = test::ColumnOf(rows, "sigma_e_m");
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(rows[i][sigma], "");
}

// The paths' errors of this scene are 100 m, their priors say 20 m: the global test must fail, by
// less than what is accepted in no case.
TEST_F(ResultTest, StrictEndsWithOneWhereATestFails) {
  const Path block = Simulated("leberl-aircraft", "block");
  const std::vector<std::string> wrong_priors = {"--set", "correction.position.sigma_m=[20,20,20]"};
  EXPECT_EQ(Run("adjust", block, "lenient", wrong_priors).exit_code, 0);
  std::vector<std::string> strict = wrong_priors;
  strict.push_back("--strict");
  const test::ProgramRun run = Run("adjust", block, "strict", strict);
  EXPECT_EQ(run.exit_code, 1);
  const json summary = json::parse(Content(folder_ / "strict/summary.json"));
  EXPECT_EQ(summary["verdict"], "converged, tests failed");
  EXPECT_EQ(Run("adjust", block, "good", {"--strict"}).exit_code, 0);
}

TEST_F(ResultTest, PairsOfNeighboursOfAllAndOfAFile) {
  const Path block = Simulated("leberl-aircraft", "block", {"--set", "points.count=17"});
  Put("block/wanted.csv", "point_a,point_b\nK1,C2\nC1,C4\n");
  const auto pairs_of = [&](const std::string& pairs, const std::string& command) {
    const std::string name = command + "-" + pairs.substr(0, 3);
    const test::ProgramRun run = Run(command, block, name, {"--set", "pairs=" + pairs});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return test::RowsOf(Content(folder_ / name / "pairs.csv"));
  };
  for (const std::string command : {"adjust", "predict"}) {
    EXPECT_EQ(pairs_of("all", command).size(), 1u + 61 * 60 / 2) << command;  // 17 + 4 + 40 points
    const auto neighbours = pairs_of("neighbours", command);
    EXPECT_GE(neighbours.size(), 1u + 31) << command;  // every point stands in one or more
    EXPECT_LE(neighbours.size(), 1u + 61) << command;
    const auto wanted = pairs_of("wanted.csv", command);
    ASSERT_EQ(wanted.size(), 3u) << command;
    EXPECT_EQ(wanted[1][0] + wanted[1][1] + wanted[2][0] + wanted[2][1], "K1C2C1C4");
  }
  // Second route: differences of the positions in points.csv, a local frame, Table by hand.
  const auto points = test::RowsOf(Content(folder_ / "adjust-all/points.csv"));
  const auto pairs = test::RowsOf(Content(folder_ / "adjust-all/pairs.csv"));
  std::map<std::string, double> y_m;
  for (std::size_t i = 1; i < points.size(); ++i) {
    y_m[points[i][0]] = std::strtod(points[i][test::ColumnOf(points, "y_m")].c_str(), nullptr);
  }
  const std::size_t dn = test::ColumnOf(pairs, "dn_m");
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    EXPECT_NEAR(std::strtod(pairs[i][dn].c_str(), nullptr),
                y_m.at(pairs[i][1]) - y_m.at(pairs[i][0]),
                1e-9);  // coordinates of 3e4 m round at 4e-12 m
  }
}

}  // namespace
}  // namespace sarblock
