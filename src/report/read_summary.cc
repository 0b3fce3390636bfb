// SPDX-License-Identifier: Apache-2.0
#include "read_summary.h"

#include "sarblock/core/error.h"

#include <fstream>

#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using Json = nlohmann::ordered_json;

/// Null for what is not there or has another type: an older result lacks newer keys.
const Json* Find(const Json& json, const char* key) {
  if (!json.is_object()) return nullptr;
  const auto found = json.find(key);
  return found == json.end() || found->is_null() ? nullptr : &*found;
}

double NumberAt(const Json& json, const char* key, double otherwise = kAbsent) {
  const Json* value = Find(json, key);
  return value != nullptr && value->is_number() ? value->get<double>() : otherwise;
}

std::string TextAt(const Json& json, const char* key) {
  const Json* value = Find(json, key);
  if (value == nullptr) return "";
  return value->is_string() ? value->get<std::string>() : value->dump();
}

bool TrueAt(const Json& json, const char* key) {
  const Json* value = Find(json, key);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

GlobalTestFigures TestOf(const Json& chi_square, double sigma0_squared, double redundancy) {
  GlobalTestFigures test;
  test.sigma0_squared = sigma0_squared;
  test.redundancy = redundancy;
  test.lower = NumberAt(chi_square, "lower");
  test.upper = NumberAt(chi_square, "upper");
  test.level = NumberAt(chi_square, "level", 0.95);
  test.passed = TrueAt(chi_square, "passed");
  return test;
}

void ReadCounts(const Json& summary, ReportSummary* out) {
  const Json* counts = Find(summary, "counts");
  if (counts == nullptr || !counts->is_object()) return;
  for (const auto& [name, value] : counts->items()) {
    if (value.is_number()) out->counts.emplace_back(name, value.get<double>());
  }
  if (const Json* status = Find(*counts, "point_status");
      status != nullptr && status->is_object()) {
    for (const auto& [name, value] : status->items()) {
      if (value.is_number()) out->point_status.emplace_back(name, value.get<double>());
    }
  }
}

void ReadChecks(const Json& json, ReportSummary* out) {
  CheckFigures checks;
  checks.points_1 = NumberAt(json, "points", 0.0);
  checks.components_1 = NumberAt(json, "components", 0.0);
  checks.error_ratio_1 = NumberAt(json, "error_ratio");
  checks.points_outside_1 = NumberAt(json, "points_outside", 0.0);
  checks.level = NumberAt(json, "level", 0.95);
  checks.realistic = TrueAt(json, "realistic");
  checks.says = TextAt(json, "says");
  out->checks = checks;
}

void ReadTests(const Json& json, ReportSummary* out) {
  TestFigures tests;
  tests.alpha_1 = NumberAt(json, "alpha_one");
  tests.power_1 = NumberAt(json, "power");
  tests.critical_w_1 = NumberAt(json, "critical_w");
  tests.delta0_1 = NumberAt(json, "delta0");
  tests.tests_1 = NumberAt(json, "tests", 0.0);
  tests.expected_above_1 = NumberAt(json, "expected_above");
  tests.not_localisable_1 = NumberAt(json, "looks_not_localisable", 0.0);
  if (const Json* above = Find(json, "above_critical")) {
    tests.above_1 = {NumberAt(*above, "range", 0.0),
                     NumberAt(*above, "azimuth", 0.0),
                     NumberAt(*above, "control", 0.0)};
  }
  if (const Json* median = Find(json, "median_redundancy")) {
    tests.median_redundancy_1 = {NumberAt(*median, "range"), NumberAt(*median, "azimuth")};
  }
  out->tests = tests;
}

void ReadSnooping(const Json& json, ReportSummary* out) {
  out->snooping_rounds = NumberAt(json, "rounds", 0.0);
  const Json* findings = Find(json, "findings");
  if (findings == nullptr) return;
  for (const Json& entry : *findings) {
    FindingFigures finding;
    finding.round = static_cast<int>(NumberAt(entry, "round", 0.0));
    finding.point = TextAt(entry, "point");
    if (const Json* passes = Find(entry, "passes"); passes != nullptr && passes->is_array()) {
      for (const Json& pass : *passes) {
        finding.passes += (finding.passes.empty() ? "" : ", ") + pass.get<std::string>();
      }
    }
    if (TrueAt(entry, "control"))
      finding.passes += finding.passes.empty() ? "control" : ", control";
    finding.component = TextAt(entry, "component");
    finding.action = TextAt(entry, "action");
    finding.note = TextAt(entry, "note");
    finding.w_1 = NumberAt(entry, "w");
    finding.located = TrueAt(entry, "located");
    out->findings.push_back(std::move(finding));
  }
}

void ReadVariances(const Json& json, ReportSummary* out) {
  if (const Json* before = Find(json, "before")) {
    out->test_before =
        TestOf(*before, NumberAt(*before, "sigma0_squared"), NumberAt(*before, "redundancy"));
  }
  const Json* components = Find(json, "components");
  if (components == nullptr) return;
  for (const Json& entry : *components) {
    VarianceFigures v;
    v.group = TextAt(entry, "group");
    v.component = TextAt(entry, "component");
    v.unit = TextAt(entry, "unit");
    v.note = TextAt(entry, "note");
    v.estimated = TrueAt(entry, "estimated");
    v.looks_1 = NumberAt(entry, "looks", 0.0);
    v.redundancy = NumberAt(entry, "redundancy");
    v.factor_1 = NumberAt(entry, "factor");
    v.factor_sigma_1 = NumberAt(entry, "factor_sigma");
    v.sigma_before = NumberAt(entry, "sigma_before");
    v.sigma_after = NumberAt(entry, "sigma_after");
    v.sigma_after_sigma = NumberAt(entry, "sigma_after_sigma");
    out->variances.push_back(std::move(v));
  }
}

void ReadMonteCarlo(const Json& json, ReportSummary* out) {
  MonteCarloFigures runs;
  runs.runs_1 = NumberAt(json, "runs", 0.0);
  runs.failed_1 = NumberAt(json, "failed", 0.0);
  runs.seed = TextAt(json, "seed");
  runs.verdict = TextAt(json, "verdict");
  for (const auto& [name, value] : json.items()) {
    if (!value.is_object() || Find(value, "expected") == nullptr) continue;
    runs.rows.push_back({name,
                         NumberAt(value, "expected"),
                         NumberAt(value, "mean"),
                         NumberAt(value, "lower"),
                         NumberAt(value, "upper"),
                         TrueAt(value, "agrees")});
  }
  out->montecarlo = runs;
}

void Flatten(const Json& json, const std::string& prefix, ReportSummary* out) {
  for (const auto& [name, value] : json.items()) {
    const std::string key = prefix.empty() ? name : prefix + "." + name;
    if (value.is_object()) {
      Flatten(value, key, out);
    } else {
      out->configuration.emplace_back(key, value.dump());
    }
  }
}

ReportSummary Interpret(const Json& summary) {
  ReportSummary out;
  out.version = TextAt(summary, "version");
  out.command = TextAt(summary, "command");
  out.block = TextAt(summary, "block");
  out.status = TextAt(summary, "status");
  out.covariance = TextAt(summary, "covariance");
  out.accepted = TrueAt(summary, "accepted");
  if (const Json* frame = Find(summary, "frame")) {
    out.geocentric = TextAt(*frame, "kind") == "geocentric";
    if (const Json* ellipsoid = Find(*frame, "ellipsoid")) {
      out.ellipsoid = TextAt(*ellipsoid, "name");
      out.a_m = NumberAt(*ellipsoid, "a_m");
      out.flattening = NumberAt(*ellipsoid, "f");
    }
  }
  ReadCounts(summary, &out);
  out.iterations_1 = NumberAt(summary, "iterations");
  out.initial_cost = NumberAt(summary, "initial_cost");
  out.final_cost = NumberAt(summary, "final_cost");
  out.remaining_step = NumberAt(summary, "remaining_step");
  out.condition = NumberAt(summary, "condition");
  out.scaled_by_posterior = TrueAt(summary, "sigma_scaled_by_posterior");
  if (const Json* chi_square = Find(summary, "chi_square")) {
    out.test = TestOf(*chi_square, NumberAt(summary, "sigma0_squared"), out.Count("redundancy"));
  }
  if (const Json* checks = Find(summary, "check_points")) ReadChecks(*checks, &out);
  if (const Json* tests = Find(summary, "quality")) ReadTests(*tests, &out);
  if (const Json* snooping = Find(summary, "snooping")) ReadSnooping(*snooping, &out);
  if (const Json* variances = Find(summary, "variance_components")) ReadVariances(*variances, &out);
  if (const Json* runs = Find(summary, "montecarlo"); runs != nullptr && runs->is_object()) {
    ReadMonteCarlo(*runs, &out);
  }
  if (const Json* selection = Find(summary, "selection")) {
    out.selected_model = TextAt(*selection, "model");
    out.selection_settled = TrueAt(*selection, "settled");
  }
  if (const Json* stages = Find(summary, "stages"); stages != nullptr && stages->is_object()) {
    for (const auto& [name, stage] : stages->items()) {
      out.stages.push_back(
          {name, NumberAt(stage, "wall_s", 0.0), NumberAt(stage, "peak_mib", 0.0)});
    }
  }
  if (const Json* warnings = Find(summary, "warnings");
      warnings != nullptr && warnings->is_array()) {
    for (const Json& warning : *warnings) {
      out.warnings.push_back(warning.is_string() ? warning.get<std::string>() : warning.dump());
    }
  }
  if (const Json* inputs = Find(summary, "inputs"); inputs != nullptr && inputs->is_array()) {
    for (const Json& input : *inputs) {
      out.inputs.push_back(
          {TextAt(input, "file"), TextAt(input, "sha256"), NumberAt(input, "bytes", 0.0)});
    }
  }
  if (const Json* configuration = Find(summary, "configuration")) Flatten(*configuration, "", &out);
  return out;
}

}  // namespace

double ReportSummary::Count(const std::string& name) const {
  for (const auto& [key, value] : counts) {
    if (key == name) return value;
  }
  return 0.0;
}

ReportSummary ReadSummary(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file) || !stream) {
    throw InputError(FilePlace{file.string(), 0, ""},
                     "is missing, every result of adjust, intersect or predict has this file");
  }
  Json summary;
  try {
    summary = Json::parse(stream);
  } catch (const Json::exception& error) {
    throw InputError(FilePlace{file.string(), 0, ""}, std::string("is no JSON: ") + error.what());
  }
  const std::string format = TextAt(summary, "format");
  if (!format.starts_with("sarblock-result 1")) {
    throw InputError(FilePlace{file.string(), 0, "format"},
                     "'" + format + "' is not allowed, 'sarblock-result 1' is");
  }
  try {
    return Interpret(summary);
  } catch (const Json::exception& error) {
    throw InputError(FilePlace{file.string(), 0, ""},
                     std::string("is not the summary of a result: ") + error.what());
  }
}

}  // namespace sarblock
