// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/adjust_table.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/id_table.h"

#include <array>
#include <cmath>
#include <set>

#include "adjust_reader.h"
#include "number.h"

namespace sarblock {
namespace {

// clang-format off
constexpr std::array kOptions = std::to_array<AdjustOption>({
  {"corrections", "text", "given, none, auto", "given where a correction table stands, else none",
   "Which corrections of the passes are estimated; auto adds only what the data need."},
  {"robust", "text", "none, huber, cauchy, tukey", "none", "Robust loss on a look."},
  {"robust_scale", "number", "above 0, in sigmas", "1.345 huber, 2.385 cauchy, 4.685 tukey",
   "Where the loss sets in; the standard value keeps 95 percent efficiency on normal errors."},
  {"covariance", "text", "none, leberl, intersection, block, montecarlo", "block",
   "How faithful the covariance of the points is."},
  {"pairs", "text", "none, neighbours, all, or a CSV file with columns point_a, point_b", "none",
   "Point pairs whose coordinate difference and its covariance are written."},
  {"datum", "text", "given, inner", "given",
   "What holds a block without control: nothing, or inner constraints."},
  {"datum_points", "list", "point ids", "all that are solved",
   "With datum = inner: the points whose coordinates fix the datum."},
  {"scale_by_posterior", "flag", "true, false", "false",
   "Scale all printed standard deviations by the a-posteriori sigma0."},
  {"variance_components", "text", "none, range-azimuth, per-pass", "none",
   "Estimate the variances of range and of azimuth from the residuals, of all passes or of each."},
  {"variance_groups", "list", "lists of pass ids", "one group of all passes",
   "With range-azimuth: passes that share their variances; those named in none share theirs."},
  {"montecarlo_runs", "integer", "30 to 1000000", "200",
   "Adjustments with noise drawn anew that covariance = montecarlo makes."},
  {"montecarlo_seed", "integer", "0 or more", "1", "Seed of these draws."},
  {"max_iterations", "integer", "1 to 100000", "1000",
   "Iterations after which the solver gives up although its steps still shrink."},
  {"tolerance", "number", "above 0, at most 0.001, in sigmas", "1e-6",
   "Step left, over all unknowns together, at which iteration ends."},
  {"engine", "text", "auto, ceres, reduced", "auto", "The solver."},
  {"ceres_solver", "text", "auto, dense-schur, sparse-schur, iterative-schur", "auto",
   "With engine = ceres: how it solves for the corrections once the points are eliminated; auto is "
   "dense up to 600 of them, sparse above."},
  {"covariance_method", "text", "auto, reduced, ceres", "auto",
   "How the covariance is formed; ceres is the slow second route, up to 10,000 unknowns."},
  {"test_level", "number", "above 0, below 1", "0.95", "Probability of the global test."},
  {"rejections", "text", "a CSV file with columns pass, point, rejected", "none",
   "Looks to leave out beside those of the block, such as residuals.csv of an earlier result."},
  {"quality", "table", "the keys of quality below", "all as below",
   "Tests of single observations and the search for blunders."},
  {"selection", "table", "the keys below", "their defaults",
   "How corrections = auto chooses; docs/theory/selection.md. Correction tables beside it are the "
   "candidates, with their priors."},
  {"correction", "table", "position, velocity, range, time, squint, troposphere", "none",
   "Correction groups; each a table, or an array of tables for several of a kind."},
  {"quality.alpha", "number", "above 0, below power", "0.001",
   "Level of the test of one observation, or of all together with family_wise."},
  {"quality.power", "number", "above alpha, below 1", "0.8",
   "Probability with which a minimal detectable blunder is found."},
  {"quality.family_wise", "text", "none, sidak, bonferroni", "none",
   "Make alpha the level of all tests of a solution together."},
  {"quality.test", "text", "w, tau", "w",
   "Test with the standard deviations as given, or with their common factor estimated."},
  {"quality.snooping", "text", "none, iterative, robust", "none",
   "Search for blunders and leave them out: from the least-squares solution or from a robust one."},
  {"quality.separation", "number", "above 0, below 1", "0.95",
   "Probability that the wrong look is among those that are named."},
  {"selection.mode", "text", "common, per-pass", "common",
   "The same corrections for all passes, each with its own values, or every pass for itself, where "
   "standard deviations come out too small."},
  {"selection.significance", "number", "above 0, below 1", "0.05",
   "Level of the F tests of one step, shared by all terms (Bonferroni)."},
  {"selection.candidates", "list", "position, velocity, range, time, squint, troposphere",
   "all but velocity", "Kinds that are tried, without priors; not beside correction tables."},
  {"selection.max_degree", "integer", "0 to 15", "3",
   "Highest degree tried for the position; above 3 no spline is tried."},
  {"selection.knot_spacings_s", "list", "up to 3 numbers above 0, or empty",
   "a quarter and an eighth of the longest strip",
   "Splines tried where a component without a prior needs the highest degree or polynomials leave a "
   "misfit; the finest also with an estimated prior."},
  {"selection.max_condition", "number", "above 1", "1e8",
   "How much of a variance may come from other unknowns before a candidate counts as not "
   "determinable."},
  {"selection.max_posterior_prior", "number", "above 0, at most 1", "0.9",
   "Ratio of posterior to prior standard deviation above which the observations add too little."},
  {"selection.simplify", "number", "above 0, below 1", "0.01",
   "Part of its standard deviation by which simplifications of the model may move a point; those "
   "that save time are then taken; docs/theory/selection.md."},
  {"correction.position.basis", "text", "polynomial, spline", "polynomial",
   "Functions of time of the antenna's displacement: Legendre polynomials or a cubic B-spline."},
  {"correction.position.degree", "integer", "0 to 15", "0", "Highest Legendre degree."},
  {"correction.position.knot_spacing_s", "number", "above 0", "none, a spline needs it",
   "Time between the knots of the spline."},
  {"correction.position.axes", "text", "track, frame", "track", "Axes of the displacement."},
  {"correction.position.components", "list", "along, across, up, or x, y, z in frame axes", "all",
   "Axes that are estimated."},
  {"correction.position.sigma_m", "number or list", "above 0, or none", "no prior",
   "Prior standard deviation: one number, or one entry a component, each a number, none, or a "
   "list with one number a degree."},
  {"correction.position.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.position.shared", "flag", "true, false", "false",
   "One set of parameters for all these passes."},
  {"correction.velocity.components", "list", "across, up", "all", "Axes that are estimated."},
  {"correction.velocity.sigma", "number or list", "above 0, or none", "no prior",
   "Prior standard deviation of the direction error, dimensionless, one entry a component."},
  {"correction.velocity.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.velocity.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.range.bias", "flag", "true, false", "true where bias_sigma_m stands",
   "Estimate a range bias."},
  {"correction.range.bias_sigma_m", "number", "above 0", "no prior", "Its prior."},
  {"correction.range.scale", "flag", "true, false", "true where scale_sigma_ppm stands",
   "Estimate a range scale."},
  {"correction.range.scale_sigma_ppm", "number", "above 0", "no prior", "Its prior."},
  {"correction.range.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.range.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.time.bias", "flag", "true, false", "true where bias_sigma_s stands",
   "Estimate an azimuth time bias."},
  {"correction.time.bias_sigma_s", "number", "above 0", "no prior", "Its prior."},
  {"correction.time.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.time.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.squint.bias", "flag", "true, false", "true where bias_sigma_deg stands",
   "Estimate a squint bias."},
  {"correction.squint.bias_sigma_deg", "number", "above 0", "no prior", "Its prior."},
  {"correction.squint.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.squint.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.troposphere.zenith", "flag", "true, false", "true where zenith_sigma_m stands",
   "Estimate the zenith delay."},
  {"correction.troposphere.zenith_sigma_m", "number", "above 0", "no prior", "Its prior."},
  {"correction.troposphere.scale_height_m", "number", "above 0", "7000",
   "Height over which the delay falls to 1/e."},
  {"correction.troposphere.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.troposphere.shared", "flag", "true, false", "false",
   "One set for all these passes."},
});
// clang-format on

template <typename Enum>
void ReadName(const TomlTable& table, std::string_view key, Enum* value) {
  if (const auto given = table.Find(key)) *value = static_cast<Enum>(given->OneOf(Names(*value)));
}

/// A number between 0 and `below`, both excluded.
void ReadPart(const TomlTable& table, std::string_view key, double below, double* part_1) {
  const auto value = table.Find(key);
  if (!value) return;
  *part_1 = value->Positive();
  if (*part_1 < below) return;
  value->Fail(NumberText(*part_1) + " is not allowed, a number below " + NumberText(below) + " is");
}

void ReadTolerance(const TomlTable& table, double* tolerance_1) {
  const auto value = table.FindPositive("tolerance");
  if (!value) return;
  *tolerance_1 = *value;
  if (*tolerance_1 <= kRemainingStepAccepted_1) return;
  table.Require("tolerance", "")
      .Fail(NumberText(*tolerance_1) + " is not allowed, a number up to " +
            NumberText(kRemainingStepAccepted_1) + " is: no solution is accepted with more left");
}

QualityOptions ReadQuality(const TomlTable& table) {
  table.RefuseOthers(OptionKeys("quality."));
  QualityOptions options;
  ReadPart(table, "power", 1.0, &options.power_1);
  ReadPart(table, "alpha", options.power_1, &options.alpha_1);
  if (!(options.alpha_1 < options.power_1)) {
    table.Require("power", "").Fail("must be above alpha, which is " + NumberText(options.alpha_1));
  }
  ReadPart(table, "separation", 1.0, &options.separation_1);
  ReadName(table, "family_wise", &options.family_wise);
  ReadName(table, "test", &options.test);
  ReadName(table, "snooping", &options.snooping);
  return options;
}

std::string DumpQuality(const QualityOptions& options) {
  return "[adjust.quality]\nalpha = " + NumberText(options.alpha_1) +
         "\npower = " + NumberText(options.power_1) +
         "\nfamily_wise = " + TomlText(NameIn(options.family_wise)) +
         "\ntest = " + TomlText(NameIn(options.test)) +
         "\nsnooping = " + TomlText(NameIn(options.snooping)) +
         "\nseparation = " + NumberText(options.separation_1) + "\n";
}

void ReadPairs(const TomlValue& value, AdjustOptions* options) {
  const std::string text = value.Text();
  if (text.ends_with(".csv") || text.ends_with(".csv.gz")) {
    options->pairs = PairChoice::kList;
    options->pairs_file = text;
    return;
  }
  const std::vector<std::string>& names = Names(PairChoice::kNone);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == text) {
      options->pairs = static_cast<PairChoice>(i);
      return;
    }
  }
  value.Fail(Quoted(text) + " is not known, " + Listed(names) +
             " or a file ending in .csv is "
             "allowed" +
             DidYouMean(NearestName(text, names)));
}

std::string IdsText(const std::vector<std::string>& ids) {
  std::string text;
  for (const std::string& id : ids) text += (text.empty() ? "" : ", ") + TomlText(id);
  return "[" + text + "]";
}

std::string GroupsText(const std::vector<std::vector<std::string>>& groups) {
  std::string text;
  for (const std::vector<std::string>& ids : groups) {
    text += (text.empty() ? "" : ", ") + IdsText(ids);
  }
  return "[" + text + "]";
}

}  // namespace

// clang-format off
const std::vector<std::string>& Names(CorrectionChoice) {
  static const std::vector<std::string> names{"given", "none", "auto"};
  return names;
}
const std::vector<std::string>& Names(RobustLoss) {
  static const std::vector<std::string> names{"none", "huber", "cauchy", "tukey"};
  return names;
}
const std::vector<std::string>& Names(CovarianceLevel) {
  static const std::vector<std::string> names{
      "none", "leberl", "intersection", "block", "montecarlo"};
  return names;
}
const std::vector<std::string>& Names(Datum) {
  static const std::vector<std::string> names{"given", "inner"};
  return names;
}
const std::vector<std::string>& Names(Engine) {
  static const std::vector<std::string> names{"auto", "ceres", "reduced"};
  return names;
}
const std::vector<std::string>& Names(CeresSolver) {
  static const std::vector<std::string> names{
      "auto", "dense-schur", "sparse-schur", "iterative-schur"};
  return names;
}
const std::vector<std::string>& Names(CovarianceMethod) {
  static const std::vector<std::string> names{"auto", "reduced", "ceres"};
  return names;
}
const std::vector<std::string>& Names(VarianceComponents) {
  static const std::vector<std::string> names{"none", "range-azimuth", "per-pass"};
  return names;
}
const std::vector<std::string>& Names(BlunderTest) {
  static const std::vector<std::string> names{"w", "tau"};
  return names;
}
const std::vector<std::string>& Names(FamilyWise) {
  static const std::vector<std::string> names{"none", "sidak", "bonferroni"};
  return names;
}
const std::vector<std::string>& Names(Snooping) {
  static const std::vector<std::string> names{"none", "iterative", "robust"};
  return names;
}
const std::vector<std::string>& Names(PairChoice) {
  static const std::vector<std::string> names{"none", "neighbours", "all"};
  return names;
}
const std::vector<std::string>& Names(SelectionOptions::Mode) {
  static const std::vector<std::string> names{"common", "per-pass"};
  return names;
}
const std::vector<std::string>& CorrectionKinds() {
  static const std::vector<std::string> kinds{
      "position", "velocity", "range", "time", "squint", "troposphere"};
  return kinds;
}
// clang-format on

std::span<const AdjustOption> AdjustOptionTable() { return kOptions; }

std::vector<std::string> OptionKeys(std::string_view prefix) {
  std::vector<std::string> keys;
  for (const AdjustOption& option : kOptions) {
    if (!option.key.starts_with(prefix)) continue;
    const std::string_view rest = option.key.substr(prefix.size());
    if (rest.find('.') == std::string_view::npos) keys.emplace_back(rest);
  }
  return keys;
}

double InUnit(double value, double factor) {
  double best = value / factor;
  double candidate = std::nextafter(std::nextafter(best, -HUGE_VAL), -HUGE_VAL);
  for (int i = 0; i < 5; ++i, candidate = std::nextafter(candidate, HUGE_VAL)) {
    if (candidate * factor == value && best * factor != value) best = candidate;
  }
  return best;
}

AdjustOptions ReadAdjust(const TomlTable& block_toml, const std::vector<std::string>& pass_ids) {
  AdjustOptions options;
  const auto given = block_toml.Find("adjust");
  if (!given) return options;
  const TomlTable table(*given);
  table.RefuseOthers(OptionKeys(""));
  if (const auto correction = table.Find("correction")) {
    options.groups = ReadCorrections(TomlTable(*correction), pass_ids);
    if (!options.groups.empty()) options.corrections = CorrectionChoice::kGiven;
  }
  ReadName(table, "corrections", &options.corrections);
  ReadName(table, "robust", &options.robust);
  ReadName(table, "covariance", &options.covariance);
  ReadName(table, "datum", &options.datum);
  if (const auto value = table.Find("datum_points")) {
    for (const TomlValue& id : value->Entries()) options.datum_points.push_back(id.Text());
  }
  ReadName(table, "variance_components", &options.variance_components);
  ReadName(table, "engine", &options.engine);
  ReadName(table, "ceres_solver", &options.ceres_solver);
  ReadName(table, "covariance_method", &options.covariance_method);
  if (const auto value = table.FindPositive("robust_scale")) options.robust_scale = *value;
  if (const auto value = table.Find("pairs")) ReadPairs(*value, &options);
  if (const auto value = table.Find("variance_groups")) {
    for (const TomlValue& group : value->Entries()) {
      std::vector<std::string>& ids = options.variance_groups.emplace_back();
      for (const TomlValue& id : group.Entries()) ids.push_back(pass_ids[id.OneOf(pass_ids)]);
      if (ids.empty()) group.Fail("is empty, at least one pass id is needed");
    }
  }
  if (const auto value = table.Find("montecarlo_runs")) {
    options.montecarlo_runs = value->Integer(30, 1000000);
  }
  if (const auto value = table.Find("montecarlo_seed")) options.montecarlo_seed = value->Count();
  if (const auto value = table.Find("scale_by_posterior"))
    options.scale_by_posterior = value->Flag();
  if (const auto value = table.Find("selection")) {
    ReadSelection(TomlTable(*value), !options.groups.empty(), &options.selection);
  }
  if (const auto value = table.Find("max_iterations")) {
    options.max_iterations = value->Integer(1, 100000);
  }
  ReadTolerance(table, &options.tolerance_1);
  ReadPart(table, "test_level", 1.0, &options.test_level);
  if (const auto value = table.Find("rejections")) options.rejections_file = value->Text();
  if (const auto value = table.Find("quality")) options.quality = ReadQuality(TomlTable(*value));
  return options;
}

AdjustOptions ReadAdjustTable(std::string_view toml_text,
                              const std::string& file,
                              const std::vector<std::string>& pass_ids,
                              const std::vector<std::string>& overrides) {
  toml::table table = ParseToml(toml_text, file);
  ApplyOverrides(overrides, &table);
  return ReadAdjust(TomlTable(table, ""), pass_ids);
}

std::string DumpAdjustTable(const AdjustOptions& options) {
  std::string text = "[adjust]\n";
  const auto line = [&text](std::string_view key, const std::string& value) {
    text.append(key).append(" = ").append(value).append("\n");
  };
  line("corrections", TomlText(NameIn(options.corrections)));
  line("robust", TomlText(NameIn(options.robust)));
  if (options.robust_scale > 0.0) line("robust_scale", NumberText(options.robust_scale));
  line("covariance", TomlText(NameIn(options.covariance)));
  line("pairs",
       TomlText(options.pairs == PairChoice::kList ? options.pairs_file : NameIn(options.pairs)));
  line("datum", TomlText(NameIn(options.datum)));
  if (!options.datum_points.empty()) line("datum_points", IdsText(options.datum_points));
  line("scale_by_posterior", options.scale_by_posterior ? "true" : "false");
  line("variance_components", TomlText(NameIn(options.variance_components)));
  if (!options.variance_groups.empty()) {
    line("variance_groups", GroupsText(options.variance_groups));
  }
  line("montecarlo_runs", std::to_string(options.montecarlo_runs));
  line("montecarlo_seed", std::to_string(options.montecarlo_seed));
  line("max_iterations", std::to_string(options.max_iterations));
  line("tolerance", NumberText(options.tolerance_1));
  line("engine", TomlText(NameIn(options.engine)));
  line("ceres_solver", TomlText(NameIn(options.ceres_solver)));
  line("covariance_method", TomlText(NameIn(options.covariance_method)));
  line("test_level", NumberText(options.test_level));
  if (!options.rejections_file.empty()) line("rejections", TomlText(options.rejections_file));
  text += DumpQuality(options.quality);
  if (options.corrections == CorrectionChoice::kAuto) text += DumpSelection(options);
  return text + DumpCorrections(options.groups);
}

}  // namespace sarblock
