// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/adjust_table.h"

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
  {"scale_by_posterior", "flag", "true, false", "false",
   "Scale all printed standard deviations by the a-posteriori sigma0."},
  {"variance_components", "text", "none, range-azimuth, per-pass", "none",
   "Estimate the variances of range and of azimuth from the residuals."},
  {"max_iterations", "integer", "1 to 100000", "50", "Iterations after which the solver gives up."},
  {"engine", "text", "auto, ceres, reduced", "auto", "The solver."},
  {"covariance_method", "text", "auto, reduced, ceres", "auto",
   "How the covariance is formed; ceres is the slow second route, up to 10,000 unknowns."},
  {"test_level", "number", "above 0, below 1", "0.95", "Probability of the global test."},
  {"correction", "table", "position, velocity, range, time, squint, troposphere", "none",
   "Correction groups; each a table, or an array of tables for several of a kind."},
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
const std::vector<std::string>& Names(CovarianceMethod) {
  static const std::vector<std::string> names{"auto", "reduced", "ceres"};
  return names;
}
const std::vector<std::string>& Names(VarianceComponents) {
  static const std::vector<std::string> names{"none", "range-azimuth", "per-pass"};
  return names;
}
const std::vector<std::string>& Names(PairChoice) {
  static const std::vector<std::string> names{"none", "neighbours", "all"};
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
  ReadName(table, "variance_components", &options.variance_components);
  ReadName(table, "engine", &options.engine);
  ReadName(table, "covariance_method", &options.covariance_method);
  if (const auto value = table.FindPositive("robust_scale")) options.robust_scale = *value;
  if (const auto value = table.Find("pairs")) ReadPairs(*value, &options);
  if (const auto value = table.Find("scale_by_posterior"))
    options.scale_by_posterior = value->Flag();
  if (const auto value = table.Find("max_iterations")) {
    options.max_iterations = value->Integer(1, 100000);
  }
  if (const auto value = table.Find("test_level")) {
    options.test_level = value->Positive();
    if (!(options.test_level < 1.0)) {
      value->Fail(NumberText(options.test_level) + " is not allowed, a number below 1 is");
    }
  }
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
  line("scale_by_posterior", options.scale_by_posterior ? "true" : "false");
  line("variance_components", TomlText(NameIn(options.variance_components)));
  line("max_iterations", std::to_string(options.max_iterations));
  line("engine", TomlText(NameIn(options.engine)));
  line("covariance_method", TomlText(NameIn(options.covariance_method)));
  line("test_level", NumberText(options.test_level));
  return text + DumpCorrections(options.groups);
}

}  // namespace sarblock
