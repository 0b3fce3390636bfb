// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/result.h"

#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "files/result_fixture.h"
#include "quality/assess.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class ResultReaderTest : public test::ResultFolderTest {
 protected:
  void SetUp() override {
    block_.passes[1].side = LookSide::kRight;
    block_.passes[0].wavelength_m = 0.03125;
    block_.passes[0].epoch_utc = "2022-10-16T01:50:44Z";
    result_.points.intersection_rad = {0.375, kNotGiven};
    result_.points.redundancy = {1.75, kNotGiven};
    result_.looks.reason = {RejectReason::kNone, RejectReason::kBlunder, RejectReason::kNone};
    block_.points.known[0].covariance_enu_m2(2, 2) = 0.0625;
    result_.control_quality = {{0, 2, -0.625, 0.5, -3.25, 1.5}};
    result_.condition = 1234.5;
    result_.remaining_step = 0.03125;
    result_.points.fixed_path_covariance_m2 = {SymmetricEnu{4.0, 1.0, 0.25, 0.5, 0.75, 0.125},
                                               result_.points.covariance_m2[1]};
    result_.checks[0].sigma_enu_m = {1.25, kNotGiven, 2.75};
    StripStation station;
    station.pass = 1;
    station.time_s = 20.5;
    station.strip_time = 0.025;
    station.antenna_m = {7.5, 8.5, 9.5};
    station.far_m = {-1.5, -2.5, -3.5};
    station.correction_m = {0.125, -0.25, 0.375};
    result_.strips = {station};
    result_.selection.candidates = {{"range.bias",
                                     "all",
                                     2,
                                     SelectionTest::kWald,
                                     7.5,
                                     3.75,
                                     0.0625,
                                     -4.5,
                                     12.5,
                                     0.875,
                                     true,
                                     false,
                                     1,
                                     ""},
                                    {"time.bias",
                                     "A",
                                     1,
                                     SelectionTest::kNotTried,
                                     kNotGiven,
                                     kNotGiven,
                                     kNotGiven,
                                     kNotGiven,
                                     kNotGiven,
                                     kNotGiven,
                                     false,
                                     true,
                                     0,
                                     "needs another"}};
    result_.selection.simplifications = {
        {"flat-frame", 0.25, 2.5, 0.125, true, false, kNotGiven, "it gains nothing"}};
    context_.inputs = {{"block.toml", 120, "00ff"}};
    for (const Pass& pass : block_.passes) result_.corrected_paths.push_back(pass.path);
  }
  void Write() const { files::WriteResult(folder_, block_, options_, result_, context_); }
  // A summary that lists no checksums of tables, as those of programs before them.
  static std::string WithoutTables(std::string text) {
    const std::size_t begin = text.find(",\n  \"tables\": ["), end = text.find(']', begin);
    return begin == std::string::npos ? text : text.erase(begin, end + 1 - begin);
  }
  // The message for a result in which `from` of a file became `to`.
  std::string MessageWith(const std::string& name, const std::string& from, const std::string& to) {
    Write();
    std::string text = Content(folder_ / name);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from << " in\n" << text;
    if (at == std::string::npos) return "";
    Put(name, text.replace(at, from.size(), to));
    Put("summary.json", WithoutTables(Content(folder_ / "summary.json")));
    return test::MessageOf<InputError>([this] { return files::ReadResult(folder_); });
  }
};

// Round trip. Standard deviations are squared again and angles go through degrees: a relative
// 1e-15.
TEST_F(ResultReaderTest, WhatWasWrittenIsReadBack) {
  context_.compression = Compression::kGzip;
  Write();
  const files::ResultFile read = files::ReadResult(folder_);
  const files::ResultSummary& summary = read.summary;
  EXPECT_EQ(summary.command, "adjust");
  EXPECT_EQ(summary.block, "tiny");
  EXPECT_EQ(summary.status, "converged");
  EXPECT_EQ(summary.verdict, Verdict::kAccepted);
  EXPECT_EQ(summary.Count("points"), 2.0);
  EXPECT_EQ(summary.Count("looks"), 3.0);
  EXPECT_EQ(summary.Count("observations"), 17.0);
  EXPECT_EQ(summary.Count("redundancy"), 8.0);
  EXPECT_EQ(summary.Count("no such count"), 0.0);
  EXPECT_EQ(summary.sigma0_squared, 4.0);
  ASSERT_TRUE(summary.chi_square.has_value());
  EXPECT_EQ(summary.chi_square->sigma0_squared, 4.0);
  EXPECT_EQ(summary.chi_square->redundancy, 8.0);
  EXPECT_EQ(summary.chi_square->chi_square.upper, 17.5);
  EXPECT_FALSE(summary.chi_square->passed);
  ASSERT_EQ(summary.groups.size(), 2u);
  EXPECT_EQ(summary.groups[0].name, "ranges");
  EXPECT_EQ(summary.groups[0].factor(), 4.0);
  EXPECT_EQ(summary.groups[1].band.upper, 2.25);
  EXPECT_EQ(summary.condition, 1234.5);
  EXPECT_EQ(summary.covariance, "block");
  EXPECT_EQ(summary.stages.size(), 3u);
  EXPECT_EQ(summary.stages[0].stage, "read");
  ASSERT_EQ(summary.inputs.size(), 1u);
  EXPECT_EQ(summary.inputs[0].sha256, "00ff");
  EXPECT_EQ(summary.configuration.back(), (std::pair<std::string, std::string>("threads", "1")));
  EXPECT_EQ(summary.warnings, (std::vector<std::string>{"of reading", "of the result"}));
  EXPECT_EQ(summary.json, Content(folder_ / "summary.json"));

  EXPECT_EQ(read.frame.kind(), FrameKind::kGeocentric);
  EXPECT_EQ(read.frame.ellipsoid().name, "WGS84");
  EXPECT_EQ(read.frame.ellipsoid().a_m, block_.frame.ellipsoid().a_m);
  EXPECT_EQ(read.frame.ellipsoid().flattening, block_.frame.ellipsoid().flattening);
  ASSERT_EQ(read.passes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.passes[i].id, block_.passes[i].id);
    EXPECT_EQ(read.passes[i].side, block_.passes[i].side);
    EXPECT_EQ(read.passes[i].start_s, block_.passes[i].start_s);
    EXPECT_EQ(read.passes[i].end_s, block_.passes[i].end_s);
    EXPECT_EQ(read.passes[i].epoch_utc, block_.passes[i].epoch_utc);
    EXPECT_EQ(read.passes[i].path.states()[1].position_m,
              block_.passes[i].path.states()[1].position_m);
  }
  EXPECT_EQ(read.passes[0].wavelength_m, 0.03125);
  EXPECT_TRUE(std::isnan(read.passes[1].wavelength_m));

  const files::ResultPoints& points = read.points;
  EXPECT_EQ(points.ids[1], "Q,1");
  EXPECT_EQ(points.role[0], PointRole::kCheck);
  EXPECT_EQ(points.results.status, result_.points.status);
  EXPECT_EQ(points.results.reason, result_.points.reason);
  EXPECT_EQ(points.results.looks, result_.points.looks);
  EXPECT_EQ(points.results.position_m[0], result_.points.position_m[0]);
  EXPECT_TRUE(std::isnan(points.results.position_m[1].x()));
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_DOUBLE_EQ(points.results.covariance_m2[0][k], result_.points.covariance_m2[0][k]);
  }
  EXPECT_DOUBLE_EQ(points.results.intersection_rad[0], 0.375);
  EXPECT_EQ(points.results.redundancy[0], 1.75);
  EXPECT_THAT(points.results.sigma_leberl_up_m, IsEmpty());
  ASSERT_EQ(points.checks.size(), 1u);
  EXPECT_EQ(points.checks[0].error_enu_m.z(), -1.5);
  EXPECT_EQ(points.checks[0].components, 2);
  EXPECT_EQ(points.checks[0].chi_square, 3.75);
  EXPECT_EQ(points.checks[0].sigma_enu_m.z(), 2.75);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(points.results.fixed_path_covariance_m2[0][k],
              result_.points.fixed_path_covariance_m2[0][k]);
  }
  EXPECT_TRUE(std::isnan(points.results.fixed_path_covariance_m2[1][0]));

  ASSERT_EQ(read.parameters.size(), 2u);
  EXPECT_EQ(read.parameters[0].owner, "A");
  EXPECT_EQ(read.parameters[0].name, "range.bias");
  EXPECT_EQ(read.parameters[0].unit, "m");
  EXPECT_EQ(read.parameters[0].value, -3.5);
  EXPECT_EQ(read.parameters[0].sigma, 0.5);
  EXPECT_EQ(read.parameters[0].prior_sigma, 20.0);
  EXPECT_TRUE(std::isnan(read.parameters[1].sigma));
  ASSERT_EQ(read.parameter_covariance.size(), 2u);
  EXPECT_EQ(read.parameter_covariance[1].a, 0u);
  EXPECT_EQ(read.parameter_covariance[1].b, 1u);
  EXPECT_EQ(read.parameter_covariance[1].covariance, -0.125);

  EXPECT_EQ(read.looks.pass, (std::vector<std::uint32_t>{0, 1, 0}));
  EXPECT_EQ(read.looks.point, (std::vector<std::uint32_t>{0, 0, 1}));
  EXPECT_EQ(read.looks.azimuth_residual_m[2], 0.5);
  EXPECT_TRUE(std::isnan(read.looks.range_residual_m[1]));
  EXPECT_EQ(read.looks.weight, result_.looks.weight);
  EXPECT_EQ(read.looks.rejected, (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(read.looks.reason, result_.looks.reason);
  EXPECT_THAT(read.looks.quality.w[0], IsEmpty());
  EXPECT_THAT(read.looks.line_px, IsEmpty());
  ASSERT_EQ(read.control.size(), 1u);
  EXPECT_EQ(read.control[0].component, 2);
  EXPECT_EQ(read.control[0].residual_m, -0.625);
  EXPECT_EQ(read.control[0].w, -3.25);
  EXPECT_EQ(read.control[0].sigma_m, 0.25);
  EXPECT_EQ(summary.remaining_step, 0.03125);
  ASSERT_EQ(read.strips.size(), 1u);
  EXPECT_EQ(read.strips[0].pass, 1u);
  EXPECT_EQ(read.strips[0].time_s, 20.5);
  EXPECT_EQ(read.strips[0].strip_time, 0.025);
  EXPECT_EQ(read.strips[0].antenna_m, result_.strips[0].antenna_m);
  EXPECT_TRUE(read.strips[0].near_m.hasNaN());
  EXPECT_EQ(read.strips[0].far_m, result_.strips[0].far_m);
  EXPECT_EQ(read.strips[0].correction_m, result_.strips[0].correction_m);
  ASSERT_EQ(read.candidates.size(), 2u);
  EXPECT_EQ(read.candidates[0].passes, "all");
  EXPECT_EQ(read.candidates[0].parameters, 2);
  EXPECT_EQ(read.candidates[0].test, SelectionTest::kWald);
  EXPECT_EQ(read.candidates[0].f, 3.75);
  EXPECT_EQ(read.candidates[0].probability, 0.0625);
  EXPECT_EQ(read.candidates[0].delta_bic, -4.5);
  EXPECT_EQ(read.candidates[0].condition, 12.5);
  EXPECT_TRUE(read.candidates[0].kept);
  EXPECT_FALSE(read.candidates[1].kept);
  EXPECT_FALSE(read.candidates[0].held);
  EXPECT_TRUE(read.candidates[1].held);
  EXPECT_EQ(read.candidates[1].reason, "needs another");
  ASSERT_EQ(read.simplifications.size(), 1u);
  EXPECT_EQ(read.simplifications[0].bound_m, 0.25);
  EXPECT_EQ(read.simplifications[0].fraction, 0.125);
  EXPECT_TRUE(read.simplifications[0].allowed);
  EXPECT_EQ(read.simplifications[0].verdict, "it gains nothing");
  ASSERT_EQ(read.pairs.size(), 1u);
  EXPECT_EQ(read.pairs[0].b, 1u);
  EXPECT_EQ(read.pairs[0].difference_enu_m, result_.pairs[0].difference_enu_m);
  EXPECT_EQ(read.pairs[0].covariance_m2, result_.pairs[0].covariance_m2);
}

// Round trip of all that one entry each of a list holds, null for what does not exist.
TEST_F(ResultReaderTest, TheListsOfTheSummaryAreReadBack) {
  result_.reductions.terms = {{1, "tide", "m", 0.125, -0.25, 0.375}};
  result_.assessment.differences = {{true, 7, 500.5, 0.0625, 0.1875, 0.3125}};
  BlunderFinding finding;
  finding.point = 1;
  finding.round = 2;
  finding.w = kNotGiven;
  finding.azimuth = true;
  finding.looks = {0};
  finding.control = true;
  finding.note = "it stays";
  result_.snooping = SnoopingReport{3, {finding}, {}};
  VarianceComponent component;
  component.group = "A";
  component.component = 1;
  component.looks = 11;
  component.redundancy = 6.5;
  component.factor = 2.25;
  component.factor_deviation = 0.5;
  component.sigma_before = 0.75;
  component.unit = "s";
  component.estimated = true;
  component.note = "as asked";
  result_.variance_components = VarianceComponentReport{};
  result_.variance_components->components = {component};
  result_.variance_components->before = {3.5, 8.0, {2.5, 17.0}, true};
  result_.montecarlo = MonteCarloReport{};
  result_.montecarlo->runs = 40;
  result_.montecarlo->seed = 5;
  result_.montecarlo->coverage[2] = {0.99, 0.875, 0.5};
  result_.montecarlo->sentence = "they agree";
  Write();
  const files::ResultFile read = files::ReadResult(folder_);
  const files::ResultSummary& summary = read.summary;
  ASSERT_EQ(read.reductions.terms.size(), 1u);
  const ReductionTerm& term = read.reductions.terms[0];
  EXPECT_EQ(std::tie(term.pass, term.term, term.unit), std::make_tuple(1u, "tide", "m"));
  EXPECT_EQ(std::tie(term.mean, term.least, term.largest), std::make_tuple(0.125, -0.25, 0.375));
  ASSERT_EQ(summary.differences.size(), 1u);
  const DifferenceClass& difference = summary.differences[0];
  EXPECT_EQ(std::tie(difference.along, difference.pairs, difference.distance_m),
            std::make_tuple(true, 7u, 500.5));
  EXPECT_EQ(std::tie(difference.sigma_along_m, difference.sigma_across_m, difference.sigma_up_m),
            std::make_tuple(0.0625, 0.1875, 0.3125));
  EXPECT_EQ(summary.snooping_rounds, 3u);
  ASSERT_EQ(summary.findings.size(), 1u);
  const files::ResultFinding& found = summary.findings[0];
  EXPECT_EQ(found.round, 2u);
  EXPECT_EQ(found.point, block_.points.ids[1]);
  EXPECT_EQ(found.passes, std::vector<std::string>{block_.passes[block_.looks.pass[0]].id});
  EXPECT_TRUE(found.control);
  EXPECT_TRUE(std::isnan(found.w));
  EXPECT_FALSE(found.located);
  EXPECT_EQ(std::tie(found.component, found.action, found.note),
            std::make_tuple("azimuth", NameOf(BlunderFinding::Action::kKept), "it stays"));
  ASSERT_EQ(summary.variances.size(), 1u);
  const VarianceComponent& variance = summary.variances[0];
  EXPECT_EQ(std::tie(variance.group, variance.component, variance.looks, variance.unit),
            std::make_tuple("A", 1, 11u, "s"));
  EXPECT_EQ(std::tie(variance.redundancy, variance.factor, variance.factor_deviation),
            std::make_tuple(6.5, 2.25, 0.5));
  EXPECT_EQ(variance.sigma_after(), 1.125);
  EXPECT_TRUE(variance.estimated);
  EXPECT_EQ(variance.note, "as asked");
  ASSERT_TRUE(summary.test_before.has_value());
  EXPECT_EQ(std::tie(summary.test_before->sigma0_squared,
                     summary.test_before->redundancy,
                     summary.test_before->chi_square.lower,
                     summary.test_before->chi_square.upper,
                     summary.test_before->passed),
            std::make_tuple(3.5, 8.0, 2.5, 17.0, true));
  ASSERT_TRUE(summary.repetition.has_value());
  EXPECT_EQ(summary.repetition->runs, 40u);
  EXPECT_EQ(summary.repetition->seed, 5u);
  EXPECT_EQ(summary.repetition->verdict, "they agree");
  ASSERT_EQ(summary.repetition->figures.size(), 7u);
  const files::ResultRepetition::Figure& figure = summary.repetition->figures[6];
  EXPECT_EQ(std::tie(figure.name, figure.expected, figure.mean, figure.agrees),
            std::make_tuple("coverage_99", 0.99, 0.875, true));
  EXPECT_EQ(figure.upper, result_.montecarlo->coverage[2].upper());
}

TEST_F(ResultReaderTest, TheQualityOfALookIsReadByComponent) {
  for (std::size_t k = 0; k < 2; ++k) {
    const float first = k == 0 ? 0.25f : 0.75f;
    result_.quality.redundancy[k] = {first, NAN, 0.5f};
    result_.quality.w[k] = {-2.0f * first, NAN, 1.5f};
    result_.quality.shift_m[k] = {3.0f, NAN, 4.0f};
  }
  Write();
  const files::ResultLooks looks = files::ReadResult(folder_).looks;
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(looks.quality.redundancy[k][0], result_.quality.redundancy[k][0]);
    EXPECT_EQ(looks.quality.w[k][0], result_.quality.w[k][0]);
    EXPECT_EQ(looks.quality.w[k][2], 1.5f);
    EXPECT_TRUE(std::isnan(looks.quality.w[k][1]));
  }
  // Minimal detectable blunders go with 1 / sqrt(redundancy) and the standard deviation.
  EXPECT_FLOAT_EQ(looks.mdb_m[0][2] / looks.mdb_m[0][0], std::sqrt(0.5f));
  EXPECT_FLOAT_EQ(looks.influence_m[1][2] / looks.influence_m[1][0], 4.0f / 3.0f * std::sqrt(1.5f));
}

TEST_F(ResultReaderTest, AResultWithoutFiguresHasEmptyColumns) {
  AdjustResult bare;
  bare.status = AdjustStatus::kPredicted;
  bare.points.status = {PointStatus::kNotSeen, PointStatus::kNotSeen};
  bare.points.looks = {0, 0};
  bare.points.position_m.assign(2, Eigen::Vector3d::Constant(kNotGiven));
  options_.pairs = PairChoice::kNone;
  files::WriteResult(folder_, block_, options_, bare, context_);
  const files::ResultFile read = files::ReadResult(folder_);
  EXPECT_FALSE(read.summary.chi_square.has_value());
  EXPECT_TRUE(std::isnan(read.summary.sigma0_squared));
  EXPECT_THAT(read.points.results.covariance_m2, IsEmpty());
  EXPECT_THAT(read.points.results.reason, IsEmpty());
  EXPECT_THAT(read.points.results.redundancy, IsEmpty());
  EXPECT_THAT(read.pairs, IsEmpty());
  EXPECT_THAT(read.parameters, IsEmpty());
}

TEST_F(ResultReaderTest, TablesNotAskedForAreLeftOut) {
  Write();
  std::filesystem::remove(folder_ / "residuals.csv");
  const files::ResultFile read =
      files::ReadResult(folder_, {.looks = false, .pairs = false, .paths = false});
  EXPECT_EQ(read.looks.size(), 0u);
  EXPECT_THAT(read.pairs, IsEmpty());
  EXPECT_THAT(read.passes[0].path.states(), IsEmpty());
  EXPECT_EQ(read.points.size(), 2u);
}

TEST_F(ResultReaderTest, ALocalFrameIsReadAsOne) {
  block_.frame = Frame::Local();
  Write();
  EXPECT_EQ(files::ReadResult(folder_).frame.kind(), FrameKind::kLocal);
}

TEST_F(ResultReaderTest, FaultsAreNamedWithFileLineAndField) {
  result_.reductions.terms = {{1, "tide", "m", 0.125, -0.25, 0.375}};
  result_.assessment.differences = {{true, 7, 500.5, 0.0625, 0.1875, 0.3125}};
  struct Case {
    const char *file, *from, *to, *message;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"summary.json", "\"version\": ", "\"version\" ", "summary.json:3: is not valid JSON"},
           {"summary.json", "sarblock-result 1", "sarblock-result 9", "format: 'sarblock-result"},
           {"summary.json", "\"frame\"", "\"fame\"", "has no frame: an earlier version"},
           {"summary.json", "geocentric", "geodetic", "frame.kind: 'geodetic' is not known"},
           {"summary.json", "6378137.0", "-1.0", "frame.ellipsoid: "},
           {"summary.json", "\"id\": \"B\"", "\"id\": \"A\"", "passes[1].id: 'A' is empty or"},
           {"summary.json", "\"look\": \"left\"", "\"look\": \"up\"", "passes[0].look: 'up'"},
           {"summary.json",
            "\"verdict\": \"",
            "\"verdict\": \"un",
            "verdict: 'unaccepted' is not known"},
           {"summary.json", "\"points\": 2", "\"points\": 3", "points.csv: has 2 points where"},
           {"summary.json", "\"looks\": 3", "\"looks\": 4", "residuals.csv: has 3 looks where"},
           {"summary.json",
            "\"pass\": \"B\",\n      \"term\"",
            "\"pass\": \"C\",\n      \"term\"",
            "reductions[0].pass: 'C' is not known, A or B is allowed"},
           {"summary.json",
            "\"pass\": \"B\",\n      \"term\"",
            "\"term\"",
            "reductions[0].pass: is missing"},
           {"summary.json",
            "\"direction\": \"along\"",
            "\"direction\": \"up\"",
            "differences[0].direction: 'up' is not known, across or along is allowed"},
           {"summary.json",
            "\"direction\": \"along\",",
            "",
            "differences[0].direction: is missing"},
           {"points.csv", "P,check", "P,cheque", "points.csv:2: role: 'cheque' is not known"},
           {"points.csv", "adjusted", "adjuster", "points.csv:2: status: 'adjuster' is not"},
           {"points.csv", "6371000.5", "", "points.csv:2: x_m: is empty, a solved point has"},
           {"points.csv",
            ",3,2,1.5,",
            ",-3,2,1.5,",
            "points.csv:2: sigma_e_m: must be 0 or more, got -3"},
           {"points.csv", ",3,2,1.5,", ",,2,1.5,", "points.csv:2: sigma_e_m: all six figures"},
           {"points.csv", "\"Q,1\"", "P", "points.csv:3: point: 'P' is given twice"},
           {"passes.csv", "B,range", "A,range", "passes.csv:3: parameter: 'range.bias' of"},
           {"passes_covariance.csv", "A,range", "C,range", "passes_covariance.csv:2: parameter_a"},
           {"residuals.csv", "\nB,P", "\nC,P", "residuals.csv:3: pass: summary.json has no pass"},
           {"residuals.csv", "A,P", "A,O", "residuals.csv:2: point: points.csv has no point 'O'"},
           {"residuals.csv", "blunder", "wonder", "residuals.csv:3: reason: 'wonder' is not"},
           {"residuals.csv", "0.75", "1e999", "residuals.csv:2: range_residual_m: "},
           {"control_quality.csv", "P,u", "P,x", "control_quality.csv:2: component: 'x' is"},
           {"pairs.csv", "P,", "R,", "pairs.csv:2: point_a: points.csv has no point 'R'"},
           {"strips.csv", "B,right", "C,right", "strips.csv:2: pass: summary.json has no pass 'C'"},
           {"selection.csv", ",kept,", ",keep,", "selection.csv:2: verdict: 'keep' is not known"},
           {"selection.csv", ",wald,", ",word,", "selection.csv:2: test: 'word' is not known"},
           {"trajectories.csv", "\nB,40", "\nA,50", "trajectories.csv:4: pass: pass 'B' has"},
           {"trajectories.csv", "A,40", "A,-4", "trajectories.csv:3: time_s: times of pass"}}) {
    EXPECT_THAT(MessageWith(c.file, c.from, c.to), HasSubstr(c.message)) << c.file << " " << c.to;
  }
  Write();
  std::filesystem::remove(folder_ / "points.csv");
  EXPECT_THAT(test::MessageOf<InputError>([this] { return files::ReadResult(folder_); }),
              HasSubstr("points.csv: is missing (also as .csv.gz), summary.json lists this table"));
  Put("summary.json", WithoutTables(Content(folder_ / "summary.json")));
  EXPECT_THAT(test::MessageOf<InputError>([this] { return files::ReadResult(folder_); }),
              HasSubstr("points.csv: is missing, every result has this table"));
  EXPECT_THAT(test::MessageOf<InputError>([this] { return files::ReadResult(folder_ / "none"); }),
              HasSubstr("none: does not exist; a result is a folder with summary.json"));
}

}  // namespace
}  // namespace sarblock
