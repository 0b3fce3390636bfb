// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/id_table.h"
#include "sarblock/files/block_file.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/text.h"
#include "correction_options.h"
#include "model/priors.h"
#include "tables/toml.h"

namespace sarblock::files {
namespace {

struct OptionReading {
  AdjustTable options;
  const std::vector<std::string>& pass_ids;
};

/// How the value of an option is read and how it is written: as TOML, empty where nothing is to be
/// written.
struct OptionUse {
  void (*read)(const AdjustOption& option,
               const TomlValue& value,
               OptionReading* reading) = nullptr;
  std::string (*dump)(const AdjustOption& option, const AdjustTable& options) = nullptr;
};
struct OptionRow {
  AdjustOption option;
  OptionUse use;
};

/// The names of a list "a, b, c".
std::vector<std::string> NamesOf(std::string_view list) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(", ", begin), list.size());
    names.emplace_back(list.substr(begin, end - begin));
    begin = end + 2;
  }
  return names;
}

/// "[a, b]"
std::string ListText(const std::vector<std::string>& entries) {
  std::string text;
  for (const std::string& entry : entries) text += (text.empty() ? "" : ", ") + entry;
  return "[" + text + "]";
}
std::string IdsText(const std::vector<std::string>& ids) {
  std::vector<std::string> texts;
  for (const std::string& id : ids) texts.push_back(TomlText(id));
  return ListText(texts);
}

/// A member of the options, by way of the tables that hold it.
template <auto... kMembers>
auto& At(auto& options) {
  return (options.*....*kMembers);
}

template <auto... kMembers>
void ReadChoice(const AdjustOption& option, const TomlValue& value, OptionReading* reading) {
  auto& choice = At<kMembers...>(reading->options);
  choice =
      static_cast<std::remove_reference_t<decltype(choice)>>(value.OneOf(NamesOf(option.allowed)));
}
template <auto... kMembers>
std::string DumpChoice(const AdjustOption& option, const AdjustTable& options) {
  return TomlText(NamesOf(option.allowed)[static_cast<std::size_t>(At<kMembers...>(options))]);
}
template <auto... kMembers>
constexpr OptionUse kChoice{ReadChoice<kMembers...>, DumpChoice<kMembers...>};

template <auto... kMembers>
void ReadPositive(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  At<kMembers...>(reading->options) = value.Positive();
}
template <auto... kMembers>
std::string DumpNumber(const AdjustOption&, const AdjustTable& options) {
  return NumberText(At<kMembers...>(options));
}
template <auto... kMembers>
std::string DumpAboveZero(const AdjustOption& option, const AdjustTable& options) {
  return At<kMembers...>(options) > 0.0 ? DumpNumber<kMembers...>(option, options) : "";
}
template <auto... kMembers>
constexpr OptionUse kAboveZero{ReadPositive<kMembers...>, DumpAboveZero<kMembers...>};

/// A number between 0 and 1, both excluded.
template <auto... kMembers>
void ReadPart(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  double& part = At<kMembers...>(reading->options);
  part = value.Positive();
  if (!(part < 1.0)) value.Fail("must be a number below 1, got " + NumberText(part));
}
template <auto... kMembers>
constexpr OptionUse kPart{ReadPart<kMembers...>, DumpNumber<kMembers...>};

template <int kLowest, int kHighest, auto... kMembers>
void ReadInteger(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  At<kMembers...>(reading->options) = value.Integer(kLowest, kHighest);
}
template <auto... kMembers>
std::string DumpInteger(const AdjustOption&, const AdjustTable& options) {
  return std::to_string(At<kMembers...>(options));
}
template <int kLowest, int kHighest, auto... kMembers>
constexpr OptionUse kInteger{ReadInteger<kLowest, kHighest, kMembers...>, DumpInteger<kMembers...>};

template <auto... kMembers>
void ReadFlag(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  At<kMembers...>(reading->options) = value.Flag();
}
template <auto... kMembers>
std::string DumpFlag(const AdjustOption&, const AdjustTable& options) {
  return At<kMembers...>(options) ? "true" : "false";
}
template <auto... kMembers>
constexpr OptionUse kFlag{ReadFlag<kMembers...>, DumpFlag<kMembers...>};

const std::vector<std::string> kPairNames{"none", "neighbours", "all", "distances"};

void ReadPairs(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  AdjustTable& options = reading->options;
  const std::string text = value.Text();
  if (text.ends_with(".csv") || text.ends_with(".csv.gz")) {
    options.pairs = PairChoice::kList;
    options.pairs_file = text;
    return;
  }
  const auto found = std::find(kPairNames.begin(), kPairNames.end(), text);
  if (found == kPairNames.end()) {
    value.Fail(Quoted(text) + " is not known, " + Listed(kPairNames) +
               " or a file ending in .csv is allowed" + DidYouMean(NearestName(text, kPairNames)));
  }
  options.pairs = static_cast<PairChoice>(found - kPairNames.begin());
}
std::string DumpPairs(const AdjustOption&, const AdjustTable& options) {
  return TomlText(options.pairs == PairChoice::kList
                      ? options.pairs_file
                      : kPairNames[static_cast<std::size_t>(options.pairs)]);
}

void ReadDatumPoints(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  for (const TomlValue& id : value.Entries()) reading->options.datum_points.push_back(id.Text());
}
std::string DumpDatumPoints(const AdjustOption&, const AdjustTable& options) {
  return options.datum_points.empty() ? "" : IdsText(options.datum_points);
}

void ReadVarianceGroups(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  const std::vector<std::string>& pass_ids = reading->pass_ids;
  for (const TomlValue& group : value.Entries()) {
    std::vector<std::string>& ids = reading->options.variance_groups.emplace_back();
    for (const TomlValue& id : group.Entries()) ids.push_back(pass_ids[id.OneOf(pass_ids)]);
    if (ids.empty()) group.Fail("is empty, at least one pass id is needed");
  }
}
std::string DumpVarianceGroups(const AdjustOption&, const AdjustTable& options) {
  std::vector<std::string> groups;
  for (const std::vector<std::string>& ids : options.variance_groups) {
    groups.push_back(IdsText(ids));
  }
  return groups.empty() ? "" : ListText(groups);
}

void ReadSeed(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  reading->options.montecarlo_seed = value.Count();
}
std::string DumpSeed(const AdjustOption&, const AdjustTable& options) {
  return std::to_string(options.montecarlo_seed);
}

void ReadTolerance(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  double& tolerance = reading->options.tolerance;
  tolerance = value.Positive();
  if (tolerance <= kRemainingStepAccepted) return;
  value.Fail("must be at most " + NumberText(kRemainingStepAccepted) + ", got " +
             NumberText(tolerance) + ": no solution is accepted with a larger Newton decrement");
}

void ReadRejections(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  reading->options.rejections_file = value.Text();
}
std::string DumpRejections(const AdjustOption&, const AdjustTable& options) {
  return options.rejections_file.empty() ? "" : TomlText(options.rejections_file);
}

void ReadCandidates(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  if (!reading->options.groups.empty()) {
    value.Fail("excludes correction tables, which would be the candidates; give one of both");
  }
  std::vector<CorrectionKind>& kinds = reading->options.selection.kinds;
  kinds.clear();
  for (const TomlValue& entry : value.Entries()) {
    const auto kind = static_cast<CorrectionKind>(entry.OneOf(CorrectionKinds()));
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) {
      entry.Fail("is given twice");
    }
    kinds.push_back(kind);
  }
  if (kinds.empty()) {
    value.Fail("is empty, at least one of " + Listed(CorrectionKinds()) + " is needed");
  }
  std::sort(kinds.begin(), kinds.end());
}
std::string DumpCandidates(const AdjustOption&, const AdjustTable& options) {
  if (!options.groups.empty()) return "";
  std::vector<std::string> kinds;
  for (const CorrectionKind kind : options.selection.kinds) {
    kinds.push_back(CorrectionKinds()[static_cast<std::size_t>(kind)]);
  }
  return IdsText(kinds);
}

void ReadSpacings(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  std::vector<double>& spacings_s = reading->options.selection.knot_spacings_s.emplace();
  for (const TomlValue& entry : value.Entries()) spacings_s.push_back(entry.Positive());
  if (spacings_s.size() > SelectionOptions::kMaxSpacings) {
    value.Fail("has " + std::to_string(spacings_s.size()) + " entries, at most " +
               std::to_string(SelectionOptions::kMaxSpacings) + " are allowed");
  }
}
std::string DumpSpacings(const AdjustOption&, const AdjustTable& options) {
  if (!options.selection.knot_spacings_s) return "";
  std::vector<std::string> spacings;
  for (const double s : *options.selection.knot_spacings_s) spacings.push_back(NumberText(s));
  return ListText(spacings);
}

double Within(const TomlValue& value, double lowest, double highest, const std::string& allowed) {
  const double number = value.Number();
  if (!(number > lowest && number <= highest)) {
    value.Fail("must be " + allowed + ", got " + NumberText(number));
  }
  return number;
}
void ReadMaxCondition(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  reading->options.selection.max_condition = Within(value, 1.0, 1e300, "a number above 1");
}
void ReadMaxRatio(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  reading->options.selection.max_posterior_prior =
      Within(value, 0.0, 1.0, "a number above 0 and at most 1");
}

void ReadQuality(const AdjustOption&, const TomlValue& value, OptionReading* reading);
void ReadSelection(const AdjustOption&, const TomlValue& value, OptionReading* reading);

// Every option outside the correction groups, once: a row is all that a new one needs. Those of the
// groups depend on each other and stand with their readers in correction_options.cc.
// clang-format off
const std::array kOptions = std::to_array<OptionRow>({
  {{"corrections", "text", "given, none, auto", "given if there is a correction table, else none",
   "Which corrections of the passes are estimated; auto adds only what the data need."},
   kChoice<&AdjustOptions::corrections>},
  {{"robust", "text", "none, huber, cauchy, tukey", "none", "Robust loss on a look."},
   kChoice<&AdjustOptions::robust>},
  {{"robust_scale", "number", "above 0, in sigmas", "1.345 huber, 2.385 cauchy, 4.685 tukey",
   "Where the loss sets in; the standard value keeps 95 percent efficiency on normal errors."},
   kAboveZero<&AdjustOptions::robust_scale>},
  {{"covariance", "text", "none, leberl, intersection, block, montecarlo", "block",
   "How faithful the covariance of the points is."},
   kChoice<&AdjustOptions::covariance>},
  {{"pairs", "text", "none, neighbours, all, distances, or a CSV file with columns point_a, point_b", "none",
   "Point pairs whose coordinate difference and its covariance are written."},
   {ReadPairs, DumpPairs}},
  {{"datum", "text", "given, inner", "given",
   "What holds a block without control: nothing, or inner constraints."},
   kChoice<&AdjustOptions::datum>},
  {{"datum_points", "list", "point ids", "all that are solved",
   "With datum = inner: the points whose coordinates fix the datum."},
   {ReadDatumPoints, DumpDatumPoints}},
  {{"scale_by_posterior", "flag", "true, false", "false",
   "Scale all printed standard deviations by the a-posteriori sigma0."},
   kFlag<&AdjustOptions::scale_by_posterior>},
  {{"variance_components", "text", "none, range-azimuth, per-pass", "none",
   "Estimate the variances of range and of azimuth from the residuals, of all passes or of each."},
   kChoice<&AdjustOptions::variance_components>},
  {{"variance_groups", "list", "lists of pass ids", "one group of all passes",
   "With range-azimuth: passes that share their variances; those named in none share theirs."},
   {ReadVarianceGroups, DumpVarianceGroups}},
  {{"montecarlo_runs", "integer", "30 to 1000000", "200",
   "Adjustments with noise drawn anew that covariance = montecarlo makes."},
   kInteger<30, 1000000, &AdjustOptions::montecarlo_runs>},
  {{"montecarlo_seed", "integer", "0 or more", "1", "Seed of these draws."},
   {ReadSeed, DumpSeed}},
  {{"max_iterations", "integer", "1 to 100000", "1000",
   "Iterations after which the solver gives up although its steps still shrink."},
   kInteger<1, 100000, &AdjustOptions::max_iterations>},
  {{"tolerance", "number", "above 0, at most 0.001, in sigmas", "1e-6",
   "Step left, over all unknowns together, at which iteration ends."},
   {ReadTolerance, DumpNumber<&AdjustOptions::tolerance>}},
  {{"engine", "text", "auto, ceres, reduced", "auto", "The solver."},
   kChoice<&AdjustOptions::engine>},
  {{"ceres_solver", "text", "auto, dense-schur, sparse-schur, iterative-schur", "auto",
   "With engine = ceres: how it solves for the corrections once the points are eliminated; auto is "
   "dense up to 600 of them, sparse above."},
   kChoice<&AdjustOptions::ceres_solver>},
  {{"covariance_method", "text", "auto, reduced, ceres", "auto",
   "How the covariance is formed; ceres is the slow second route, up to 10,000 unknowns."},
   kChoice<&AdjustOptions::covariance_method>},
  {{"test_level", "number", "above 0, below 1", "0.999", "Probability with which a block without mistakes passes all tests of the verdict."},
   kPart<&AdjustOptions::test_level>},
  {{"diagnose", "flag", "true, false", "true",
   "Look for the mistake behind a block that is not accepted, fails a test or cannot be solved."},
   kFlag<&AdjustTable::diagnose>},
  {{"rejections", "text", "a CSV file with columns pass, point, rejected", "none",
   "Looks to leave out beside those of the block, such as residuals.csv of an earlier result."},
   {ReadRejections, DumpRejections}},
  {{"quality", "table", "the keys of quality below", "all as below",
   "Tests of single observations and the search for blunders."},
   {ReadQuality, nullptr}},
  {{"selection", "table", "the keys below", "their defaults",
   "How corrections = auto chooses; docs/theory/selection.md. Correction tables beside it are the "
   "candidates, with their priors."},
   {ReadSelection, nullptr}},
  {{"correction", "table", "position, velocity, range, time, squint, troposphere", "none",
   "Correction groups; each a table, or an array of tables for several of a kind."}, {}},
  {{"prior", "table", "tables by name", "none",
   "Joint priors: several corrections of a pass with their full covariance."}, {}},
  {{"quality.alpha", "number", "above 0, below power", "0.001",
   "Level of the test of one observation, or of all together with family_wise."},
   {ReadPositive<&AdjustOptions::quality, &QualityOptions::alpha>, DumpNumber<&AdjustOptions::quality, &QualityOptions::alpha>}},
  {{"quality.power", "number", "above alpha, below 1", "0.8",
   "Probability with which a minimal detectable blunder is found."},
   kPart<&AdjustOptions::quality, &QualityOptions::power>},
  {{"quality.family_wise", "text", "none, sidak, bonferroni", "none",
   "Make alpha the level of all tests of a solution together."},
   kChoice<&AdjustOptions::quality, &QualityOptions::family_wise>},
  {{"quality.test", "text", "w, tau", "w",
   "Test with the standard deviations as given, or with their common factor estimated."},
   kChoice<&AdjustOptions::quality, &QualityOptions::test>},
  {{"quality.snooping", "text", "none, iterative, robust", "none",
   "Search for blunders and leave them out: from the least-squares solution or from a robust one."},
   kChoice<&AdjustOptions::quality, &QualityOptions::snooping>},
  {{"quality.consensus", "flag", "true, false", "true",
   "Solve a block that contradicts itself once more by consensus of its looks, and leave out by name "
   "what disagrees."},
   kFlag<&AdjustOptions::quality, &QualityOptions::consensus>},
  {{"quality.separation", "number", "above 0, below 1", "0.95",
   "Probability that the wrong look is among those that are named."},
   kPart<&AdjustOptions::quality, &QualityOptions::separation>},
  {{"selection.mode", "text", "common, per-pass", "common",
   "The same corrections for all passes, each with its own values, or every pass for itself, where "
   "standard deviations come out up to a fifth too small."},
   kChoice<&AdjustOptions::selection, &SelectionOptions::mode>},
  {{"selection.significance", "number", "above 0, below 1", "0.05",
   "Level of the F tests of one step, shared by all terms (Bonferroni)."},
   kPart<&AdjustOptions::selection, &SelectionOptions::significance>},
  {{"selection.candidates", "list", "position, velocity, range, time, squint, troposphere",
   "all but velocity", "Kinds that are tried, without priors; not beside correction tables."},
   {ReadCandidates, DumpCandidates}},
  {{"selection.max_degree", "integer", "0 to 15", "3",
   "Highest degree tried for the position; above 3 no spline is tried."},
   kInteger<0, PositionCorrection::kMaxDegree, &AdjustOptions::selection, &SelectionOptions::max_degree>},
  {{"selection.knot_spacings_s", "list", "up to 3 numbers above 0, or empty",
   "a quarter and an eighth of the longest strip",
   "Splines tried where a component without a prior needs the highest degree or polynomials leave a "
   "misfit; the finest also with an estimated prior."},
   {ReadSpacings, DumpSpacings}},
  {{"selection.max_condition", "number", "above 1", "1e8",
   "How much of a variance may come from other unknowns before a candidate counts as not "
   "determinable."},
   {ReadMaxCondition, DumpNumber<&AdjustOptions::selection, &SelectionOptions::max_condition>}},
  {{"selection.max_posterior_prior", "number", "above 0, at most 1", "0.9",
   "Ratio of posterior to prior standard deviation above which the observations add too little."},
   {ReadMaxRatio, DumpNumber<&AdjustOptions::selection, &SelectionOptions::max_posterior_prior>}},
  {{"selection.simplify", "number", "above 0, below 1", "0.01",
   "Part of its standard deviation by which simplifications of the model may move a point; those "
   "that save time are then taken; docs/theory/selection.md."},
   kPart<&AdjustOptions::selection, &SelectionOptions::simplify>},
});
// clang-format on

/// The last part of a key of the section `prefix` ("", "quality."); empty for a key elsewhere.
std::string_view KeyWithin(std::string_view key, std::string_view prefix) {
  if (!key.starts_with(prefix)) return {};
  key.remove_prefix(prefix.size());
  return key.find('.') == key.npos ? key : std::string_view();
}

void ReadSection(const TomlTable& table, std::string_view prefix, OptionReading* reading) {
  table.RefuseOthers(KeysWithin(AdjustOptionTable(), prefix));
  for (const OptionRow& row : kOptions) {
    const std::string_view key = KeyWithin(row.option.key, prefix);
    if (key.empty() || row.use.read == nullptr) continue;
    if (const auto value = table.Find(key)) row.use.read(row.option, *value, reading);
  }
}

void ReadQuality(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  const TomlTable table(value);
  ReadSection(table, "quality.", reading);
  const QualityOptions& options = reading->options.quality;
  if (options.alpha < options.power) return;
  if (const auto alpha = table.Find("alpha")) {
    alpha->Fail("must be below " + NumberText(options.power) + ", got " +
                NumberText(options.alpha));
  }
  table.Require("power", "").Fail("must be above alpha, which is " + NumberText(options.alpha));
}

void ReadSelection(const AdjustOption&, const TomlValue& value, OptionReading* reading) {
  ReadSection(TomlTable(value), "selection.", reading);
}

std::string DumpSection(std::string_view prefix, const AdjustTable& options) {
  std::string text;
  for (const OptionRow& row : kOptions) {
    const std::string_view key = KeyWithin(row.option.key, prefix);
    if (key.empty() || row.use.dump == nullptr) continue;
    const std::string value = row.use.dump(row.option, options);
    if (!value.empty()) text.append(key).append(" = ").append(value).append("\n");
  }
  return text;
}

const OptionRow& RowOf(std::string_view key) {
  return *std::find_if(kOptions.begin(), kOptions.end(), [&](const OptionRow& row) {
    return row.option.key == key;
  });
}

}  // namespace

std::span<const AdjustOption> AdjustOptionTable() {
  static const std::vector<AdjustOption> options = [] {
    std::vector<AdjustOption> out;
    for (const OptionRow& row : kOptions) out.push_back(row.option);
    out.insert(out.end(), CorrectionOptions().begin(), CorrectionOptions().end());
    out.insert(out.end(), PriorOptions().begin(), PriorOptions().end());
    return out;
  }();
  return options;
}

std::string NameOfChoice(std::string_view key, const AdjustTable& options) {
  const OptionRow& row = RowOf(key);
  const std::string text = row.use.dump(row.option, options);
  return text.substr(1, text.size() - 2);  // without its quotes
}

AdjustTable ReadAdjust(const TomlTable& block_toml, const std::vector<std::string>& pass_ids) {
  OptionReading reading{{}, pass_ids};
  reading.options.corrections = CorrectionChoice::kNone;  // unless tables stand below
  const auto given = block_toml.Find("adjust");
  if (!given) return reading.options;
  const TomlTable table(*given);
  table.RefuseOthers(KeysWithin(AdjustOptionTable(), ""));
  if (const auto correction = table.Find("correction")) {
    reading.options.groups = ReadCorrections(TomlTable(*correction), pass_ids);
    if (!reading.options.groups.empty()) reading.options.corrections = CorrectionChoice::kGiven;
  }
  ReadSection(table, "", &reading);
  if (reading.options.corrections == CorrectionChoice::kAuto) {
    for (const CorrectionGroup& group : reading.options.groups) {
      if (!HasProcess(group)) continue;
      table.Find("correction")->Fail("the process of '" + group.name + "' " + kNoAutomaticPriors);
    }
  }
  if (const auto prior = table.Find("prior")) {
    const TomlTable tables(*prior);
    AdjustTable& options = reading.options;
    options.priors = ReadPriors(tables);
    RequireFitting(tables, pass_ids, options.groups, options.priors);
    if (!options.priors.empty() && options.corrections == CorrectionChoice::kAuto) {
      prior->Fail(kNoAutomaticPriors);
    }
  }
  return reading.options;
}

AdjustTable ReadAdjustTable(std::string_view toml_text,
                            const std::string& file,
                            const std::vector<std::string>& pass_ids,
                            const std::vector<std::string>& overrides) {
  toml::table table = ParseToml(toml_text, file);
  ApplyOverrides(overrides, &table);
  return ReadAdjust(TomlTable(table, ""), pass_ids);
}

std::string DumpAdjustTable(const AdjustTable& options) {
  std::string text = "[adjust]\n" + DumpSection("", options);
  text += "[adjust.quality]\n" + DumpSection("quality.", options);
  if (options.corrections == CorrectionChoice::kAuto) {
    text += "[adjust.selection]\n" + DumpSection("selection.", options);
  }
  return text + DumpCorrections(options.groups) + DumpPriors(options.priors);
}

}  // namespace sarblock::files
