// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <cmath>
#include <set>

#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kPasses{"A1", "A2", "B7"};

files::AdjustTable OptionsOf(const std::string& text,
                             const std::vector<std::string>& overrides = {}) {
  return files::ReadAdjustTable(text, "block.toml", kPasses, overrides);
}

std::string OptionError(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return test::MessageOf<InputError>([&] { return OptionsOf(text, overrides); });
}

PositionCorrection Position(const std::string& lines) {
  const files::AdjustTable options = OptionsOf("[adjust.correction.position]\n" + lines);
  return std::get<PositionCorrection>(options.groups.at(0).model);
}

TEST(AdjustTableTest, ATableLeftOutMeansTheDefaults) {
  const files::AdjustTable options = OptionsOf("");
  files::AdjustTable defaults;  // of a file without correction tables: none
  defaults.corrections = CorrectionChoice::kNone;
  EXPECT_EQ(files::DumpAdjustTable(options), files::DumpAdjustTable(defaults));
  EXPECT_EQ(OptionsOf("[adjust.correction.time]\nbias = true\n").corrections,
            CorrectionChoice::kGiven);
  EXPECT_EQ(OptionsOf("[adjust]\ncorrections = \"none\"\n[adjust.correction.time]\nbias = true\n")
                .corrections,
            CorrectionChoice::kNone);
}

TEST(AdjustTableTest, ReadsEveryScalar) {
  const files::AdjustTable options = OptionsOf(
      "[adjust]\ncorrections = \"auto\"\nrobust = \"tukey\"\nrobust_scale = 4.25\n"
      "covariance = \"montecarlo\"\npairs = \"mine.csv\"\ndatum = \"inner\"\n"
      "scale_by_posterior = true\nvariance_components = \"per-pass\"\nmax_iterations = 17\n"
      "montecarlo_runs = 70\nmontecarlo_seed = 9\nvariance_groups = [[\"A1\"], [\"A2\"]]\n"
      "engine = \"ceres\"\nceres_solver = \"iterative-schur\"\ntolerance = "
      "2.5e-8\ncovariance_method = \"ceres\"\ntest_level = 0.875\ndiagnose = false\n");
  EXPECT_EQ(options.corrections, CorrectionChoice::kAuto);
  EXPECT_EQ(options.robust, RobustLoss::kTukey);
  EXPECT_EQ(options.robust_scale, 4.25);
  EXPECT_EQ(options.covariance, CovarianceLevel::kMonteCarlo);
  EXPECT_EQ(options.pairs, PairChoice::kList);
  EXPECT_EQ(options.pairs_file, "mine.csv");
  EXPECT_EQ(options.datum, Datum::kInner);
  EXPECT_TRUE(options.scale_by_posterior);
  EXPECT_EQ(options.variance_components, VarianceComponents::kPerPass);
  EXPECT_EQ(options.montecarlo_runs, 70);
  EXPECT_EQ(options.montecarlo_seed, 9U);
  EXPECT_THAT(options.variance_groups, ElementsAre(ElementsAre("A1"), ElementsAre("A2")));
  EXPECT_EQ(options.max_iterations, 17);
  EXPECT_EQ(options.engine, Engine::kCeres);
  EXPECT_EQ(options.ceres_solver, CeresSolver::kIterativeSchur);
  EXPECT_EQ(options.tolerance, 2.5e-8);
  EXPECT_EQ(options.covariance_method, CovarianceMethod::kCeres);
  EXPECT_EQ(options.test_level, 0.875);
  EXPECT_FALSE(options.diagnose);
}

TEST(AdjustTableTest, ReadsEveryFormOfPositionPriors) {
  EXPECT_THAT(Position("sigma_m = 12.5\n").prior_sigma_m,
              ElementsAre(ElementsAre(12.5), ElementsAre(12.5), ElementsAre(12.5)));
  EXPECT_THAT(Position("").prior_sigma_m, ElementsAre(ElementsAre(), ElementsAre(), ElementsAre()));
  // In the order of `components`, per degree.
  const PositionCorrection two = Position(
      "degree = 1\ncomponents = [\"up\", \"along\"]\nsigma_m = [[30.5, 3.25], \"none\"]\n");
  EXPECT_THAT(two.components, ElementsAre(true, false, true));
  EXPECT_THAT(two.prior_sigma_m,
              ElementsAre(ElementsAre(), ElementsAre(), ElementsAre(30.5, 3.25)));
  // One per axis, although only one is estimated.
  const PositionCorrection one =
      Position("axes = \"frame\"\ncomponents = [\"y\"]\nsigma_m = [1.5, 2.5, 3.5]\n");
  EXPECT_THAT(one.prior_sigma_m, ElementsAre(ElementsAre(), ElementsAre(2.5), ElementsAre()));
}

TEST(AdjustTableTest, ConvertsTheUnitsOfTheFile) {  // hand values
  const files::AdjustTable options = OptionsOf(
      "[adjust.correction.range]\nbias_sigma_m = 5.5\nscale_sigma_ppm = 10\n"
      "[adjust.correction.squint]\nbias_sigma_deg = 0.09\n");
  const auto& range = std::get<RangeCorrection>(options.groups.at(0).model);
  EXPECT_TRUE(range.bias && range.scale);
  EXPECT_DOUBLE_EQ(range.scale_prior_sigma, 10.0 * 1e-6);
  const auto& squint = std::get<SquintCorrection>(options.groups.at(1).model);
  EXPECT_DOUBLE_EQ(squint.bias_prior_sigma_rad, 0.09 * kRadPerDeg);
}

constexpr const char* kRich =
    "[adjust]\nrobust = \"cauchy\"\nrobust_scale = 2.125\ntolerance = 3e-5\n"
    "variance_groups = [[\"B7\", \"A1\"], [\"A2\"]]\nmontecarlo_seed = 12\n"
    "[[adjust.correction.position]]\nbasis = \"spline\"\nknot_spacing_s = 7.3\n"
    "sigma_m = [1.1, \"none\", 3.3]\npasses = [\"A1\"]\n"
    "[[adjust.correction.position]]\ndegree = 3\ncomponents = [\"up\", \"across\"]\n"
    "sigma_m = [0.7, [1, 2, \"none\", 0.1]]\npasses = [\"A2\", \"B7\"]\nshared = true\n"
    "[adjust.correction.velocity]\ncomponents = [\"up\"]\nsigma = 1.3e-4\n"
    "[adjust.correction.range]\nbias = true\nscale_sigma_ppm = 3.3\nshared = true\n"
    "[adjust.correction.time]\nbias_sigma_s = 0.0123\n"
    "[adjust.correction.squint]\nbias_sigma_deg = 0.037\n"
    "[adjust.correction.troposphere]\nzenith = true\nscale_height_m = 6543.2\n";

TEST(AdjustTableTest, WhatIsDumpedReadsBackTheSame) {  // round trip
  for (const char* text : {"", kRich}) {
    const std::string dumped = files::DumpAdjustTable(OptionsOf(text));
    EXPECT_EQ(files::DumpAdjustTable(OptionsOf(dumped)), dumped);
  }
  const files::AdjustTable options = OptionsOf(kRich),
                           again = OptionsOf(files::DumpAdjustTable(options));
  ASSERT_EQ(again.groups.size(), 7u);
  EXPECT_EQ(again.groups[0].name, "position.1");
  EXPECT_EQ(again.groups[3].name, "range");
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(again.groups[i].passes, options.groups[i].passes);
    EXPECT_EQ(again.groups[i].shared, options.groups[i].shared);
    EXPECT_EQ(again.groups[i].model.index(), options.groups[i].model.index());
  }
  const auto& position = std::get<PositionCorrection>(again.groups[1].model);
  EXPECT_THAT(position.prior_sigma_m[1], ElementsAre(1.0, 2.0, testing::IsNan(), 0.1));
  EXPECT_EQ(std::get<SquintCorrection>(again.groups[5].model).bias_prior_sigma_rad,
            std::get<SquintCorrection>(options.groups[5].model).bias_prior_sigma_rad);
  EXPECT_EQ(std::get<RangeCorrection>(again.groups[3].model).scale_prior_sigma,
            std::get<RangeCorrection>(options.groups[3].model).scale_prior_sigma);
}

TEST(AdjustTableTest, OverridesGoBeforeTheFile) {
  const files::AdjustTable options = OptionsOf(kRich,
                                               {"robust=none",
                                                "max_iterations=7",
                                                "correction.position.1.degree=4",
                                                "correction.position.1.sigma_m=2.5",
                                                "adjust.pairs=all",
                                                "correction.range.bias_sigma_m=0.25",
                                                "correction.velocity.components=[\"across\"]"});
  EXPECT_EQ(options.robust, RobustLoss::kNone);
  EXPECT_EQ(options.max_iterations, 7);
  EXPECT_EQ(options.pairs, PairChoice::kAll);
  EXPECT_EQ(std::get<PositionCorrection>(options.groups[1].model).degree, 4);
  EXPECT_THAT(std::get<VelocityCorrection>(options.groups[2].model).components,
              ElementsAre(true, false));
  EXPECT_EQ(std::get<RangeCorrection>(options.groups[3].model).bias_prior_sigma_m, 0.25);
}

TEST(AdjustOptionTableTest, ListsEachKeyOnceWithHelp) {
  std::set<std::string> keys;
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    EXPECT_TRUE(keys.insert(std::string(option.key)).second) << option.key;
    EXPECT_TRUE(option.help.ends_with('.')) << option.key;
  }
}

TEST(AdjustOptionTableTest, EveryKeyItListsIsRead) {  // a value of a type no key takes is refused
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    const std::string key(option.key);
    std::vector<std::string> overrides{key + "=2001-02-03"};
    const auto before = [&overrides](const char* text) {
      overrides.insert(overrides.begin(), text);
    };
    const bool markov = key.ends_with("correlation_time_s");
    if (markov || key.ends_with("start_sigma_m")) {
      before(markov ? "correction.position.process=gauss-markov"
                    : "correction.position.process=random-walk");
      before("correction.position.sigma_m=5");
      before("correction.position.knot_spacing_s=3");
      before("correction.position.basis=spline");
    }
    if (key.ends_with("knot_spacing_s")) before("correction.position.basis=spline");
    if (key.starts_with("correction.range.")) before("correction.range.scale=true");
    if (key.starts_with("correction.range.")) before("correction.range.bias=true");
    if (key.starts_with("correction.time.")) before("correction.time.bias=true");
    if (key.starts_with("correction.squint.")) before("correction.squint.bias=true");
    if (key.starts_with("correction.trop")) before("correction.troposphere.zenith=true");
    EXPECT_THAT(OptionError("", overrides), HasSubstr("adjust." + key + ": is ")) << key;
  }
}

// A value for each option that is not its default; [adjust] tables it needs beside it.
struct OptionSample {
  const char *key, *value;
  std::vector<std::string> beside = {};
};

std::vector<OptionSample> OptionSamples() {
  const std::string automatic = "corrections=auto", range = "correction.range.bias=true";
  const std::vector<std::string> joint{range,
                                       "correction.range.scale=true",
                                       "prior.NAME.parameters=[\"range.bias\", \"range.scale\"]",
                                       "prior.NAME.sigma=[1, 2]"};
  const std::vector<std::string> spline{"correction.position.basis=spline",
                                        "correction.position.knot_spacing_s=3",
                                        "correction.position.sigma_m=5"};
  const auto with_process = [&](const std::string& process, const char* further) {
    std::vector<std::string> out = spline;
    if (!process.empty()) out.push_back("correction.position.process=" + process);
    if (*further != '\0') out.emplace_back(further);
    return out;
  };
  const std::string time = "correction.time.bias=true", squint = "correction.squint.bias=true";
  const std::string zenith = "correction.troposphere.zenith=true";
  return {{"corrections", "\"auto\""},
          {"robust", "\"tukey\""},
          {"robust_scale", "2.5"},
          {"covariance", "\"leberl\""},
          {"pairs", "\"neighbours\""},
          {"datum", "\"inner\""},
          {"datum_points", "[\"P\"]"},
          {"scale_by_posterior", "true"},
          {"variance_components", "\"per-pass\""},
          {"variance_groups", "[[\"A1\", \"B7\"]]"},
          {"montecarlo_runs", "77"},
          {"montecarlo_seed", "99"},
          {"max_iterations", "17"},
          {"tolerance", "1.25e-05"},
          {"engine", "\"ceres\""},
          {"ceres_solver", "\"sparse-schur\""},
          {"covariance_method", "\"reduced\""},
          {"test_level", "0.875"},
          {"diagnose", "false"},
          {"rejections", "\"mine.csv\""},
          {"quality.alpha", "0.0625"},
          {"quality.power", "0.75"},
          {"quality.family_wise", "\"sidak\""},
          {"quality.test", "\"tau\""},
          {"quality.snooping", "\"robust\""},
          {"quality.consensus", "false"},
          {"quality.separation", "0.625"},
          {"selection.mode", "\"per-pass\"", {automatic}},
          {"selection.significance", "0.125", {automatic}},
          {"selection.candidates", "[\"velocity\", \"time\"]", {automatic}},
          {"selection.max_degree", "2", {automatic}},
          {"selection.knot_spacings_s", "[7.5]", {automatic}},
          {"selection.max_condition", "4096", {automatic}},
          {"selection.max_posterior_prior", "0.625", {automatic}},
          {"selection.simplify", "0.375", {automatic}},
          {"correction.position.basis", "\"spline\"", {"correction.position.knot_spacing_s=3"}},
          {"correction.position.degree", "2"},
          {"correction.position.knot_spacing_s", "3.5", {"correction.position.basis=spline"}},
          {"correction.position.process",
           "\"gauss-markov\"",
           with_process("", "correction.position.correlation_time_s=9")},
          {"correction.position.correlation_time_s", "9.5", with_process("gauss-markov", "")},
          {"correction.position.start_sigma_m", "[5, 4, 3]", with_process("random-walk", "")},
          {"correction.position.axes", "\"frame\""},
          {"correction.position.components", "[\"up\"]"},
          {"correction.position.sigma_m", "[1.5, 2.5, 3.5]"},
          {"correction.position.passes", "[\"B7\"]"},
          {"correction.position.shared", "true"},
          {"correction.velocity.components", "[\"up\"]"},
          {"correction.velocity.sigma", "[0.25, 0.5]"},
          {"correction.velocity.passes", "[\"B7\"]"},
          {"correction.velocity.shared", "true"},
          {"correction.range.bias", "true"},
          {"correction.range.bias_sigma_m", "2.5"},
          {"correction.range.scale", "true"},
          {"correction.range.scale_sigma_ppm", "2.5"},
          {"correction.range.passes", "[\"B7\"]", {range}},
          {"correction.range.shared", "true", {range}},
          {"correction.time.bias", "true"},
          {"correction.time.bias_sigma_s", "0.5"},
          {"correction.time.passes", "[\"B7\"]", {time}},
          {"correction.time.shared", "true", {time}},
          {"correction.squint.bias", "true"},
          {"correction.squint.bias_sigma_deg", "0.5"},
          {"correction.squint.passes", "[\"B7\"]", {squint}},
          {"correction.squint.shared", "true", {squint}},
          {"correction.troposphere.zenith", "true"},
          {"correction.troposphere.zenith_sigma_m", "0.5"},
          {"correction.troposphere.scale_height_m", "6500", {zenith}},
          {"correction.troposphere.passes", "[\"B7\"]", {zenith}},
          {"correction.troposphere.shared", "true", {zenith}},
          {"prior.NAME.passes", "[\"B7\"]", joint},
          {"prior.NAME.parameters", "[\"range.scale\", \"range.bias\"]", joint},
          {"prior.NAME.axes", "\"ric\"", joint},
          {"prior.NAME.covariance", "[[4, 1], [1, 2]]", {joint[0], joint[1], joint[2]}},
          {"prior.NAME.sigma", "[4, 0.5]", joint},
          {"prior.NAME.correlation", "[[1, 0.25], [0.25, 1]]", joint}};
}

// What is read of every option is what is written of it, in the table that its key names.
TEST(AdjustOptionTableTest, EveryKeyItListsIsWrittenAsItIsRead) {
  std::set<std::string> left;
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    if (option.type != "table") left.insert(std::string(option.key));
  }
  const std::string defaults = files::DumpAdjustTable(OptionsOf(""));
  for (const OptionSample& sample : OptionSamples()) {
    EXPECT_EQ(left.erase(sample.key), 1u) << sample.key;
    std::vector<std::string> overrides = sample.beside;
    overrides.push_back(std::string(sample.key) + "=" + sample.value);
    const std::string dump = files::DumpAdjustTable(OptionsOf("", overrides));
    const std::string key = std::string("adjust.") + sample.key;
    const std::size_t dot = key.rfind('.');
    const std::size_t table = dump.find("[" + key.substr(0, dot) + "]\n");
    ASSERT_NE(table, std::string::npos) << key << " in\n" << dump;
    const std::string line = "\n" + key.substr(dot + 1) + " = " + sample.value + "\n";
    const std::size_t at = dump.find(line, table);
    ASSERT_NE(at, std::string::npos) << line << " in\n" << dump;
    EXPECT_LT(at, dump.find("\n[", table)) << dump;
    EXPECT_EQ(defaults.find(line), std::string::npos) << key << " is a default";
    EXPECT_EQ(files::DumpAdjustTable(OptionsOf(dump)), dump);
  }
  EXPECT_THAT(left, testing::IsEmpty()) << "options without a sample in this test";
}

TEST(AdjustTableTest, ReadsTheSelectionAndWritesItBack) {
  const files::AdjustTable options = OptionsOf(
      "[adjust]\ncorrections = \"auto\"\n[adjust.selection]\nmode = \"per-pass\"\n"
      "significance = 0.0125\ncandidates = [\"range\", \"position\"]\nmax_degree = 2\n"
      "knot_spacings_s = [7.5, 3]\nmax_condition = 3e5\nmax_posterior_prior = 0.75\n"
      "simplify = 0.0625\n");
  const SelectionOptions& selection = options.selection;
  EXPECT_EQ(selection.mode, SelectionOptions::Mode::kPerPass);
  EXPECT_EQ(selection.significance, 0.0125);
  EXPECT_EQ(selection.kinds, (std::vector{CorrectionKind::kPosition, CorrectionKind::kRange}));
  EXPECT_EQ(selection.max_degree, 2);
  ASSERT_TRUE(selection.knot_spacings_s.has_value());
  EXPECT_EQ(*selection.knot_spacings_s, (std::vector<double>{7.5, 3.0}));
  EXPECT_EQ(selection.max_condition, 3e5);
  EXPECT_EQ(selection.max_posterior_prior, 0.75);
  EXPECT_EQ(selection.simplify, 0.0625);
  const std::string dump = files::DumpAdjustTable(options);
  EXPECT_EQ(files::DumpAdjustTable(OptionsOf(dump)), dump);
  EXPECT_THAT(dump, testing::HasSubstr("knot_spacings_s = [7.5, 3"));
}

}  // namespace
}  // namespace sarblock
