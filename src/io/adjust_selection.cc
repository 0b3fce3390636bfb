// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "adjust_reader.h"
#include "number.h"

namespace sarblock {
namespace {

double Below(const TomlValue& value, double lowest, double highest, const std::string& allowed) {
  const double number = value.Number();
  if (!(number > lowest && number <= highest)) {
    value.Fail(NumberText(number) + " is not allowed, " + allowed);
  }
  return number;
}

std::vector<std::size_t> ReadKinds(const TomlValue& value) {
  std::vector<std::size_t> kinds;
  for (const TomlValue& entry : value.Entries()) {
    const std::size_t kind = entry.OneOf(CorrectionKinds());
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) {
      entry.Fail("stands twice, once is allowed");
    }
    kinds.push_back(kind);
  }
  if (kinds.empty()) {
    value.Fail("is empty, at least one of " + Listed(CorrectionKinds()) + " is needed");
  }
  std::sort(kinds.begin(), kinds.end());
  return kinds;
}

std::vector<double> ReadSpacings(const TomlValue& value) {
  std::vector<double> spacings_s;
  for (const TomlValue& entry : value.Entries()) spacings_s.push_back(entry.Positive());
  if (spacings_s.size() > SelectionOptions::kMostSpacings) {
    value.Fail("has " + std::to_string(spacings_s.size()) + " entries, at most " +
               std::to_string(SelectionOptions::kMostSpacings) + " are allowed");
  }
  return spacings_s;
}

}  // namespace

void ReadSelection(const TomlTable& table, bool groups, SelectionOptions* options) {
  table.RefuseOthers(OptionKeys("selection."));
  if (const auto value = table.Find("mode")) {
    options->mode = static_cast<SelectionOptions::Mode>(value->OneOf(Names(options->mode)));
  }
  for (const auto& [key, part] : {std::pair("significance", &options->significance_1),
                                  std::pair("simplify", &options->simplify_1)}) {
    const auto value = table.Find(key);
    if (!value) continue;
    *part = value->Positive();
    if (!(*part < 1.0)) value->Fail(NumberText(*part) + " is not allowed, a number below 1 is");
  }
  if (const auto value = table.Find("candidates")) {
    if (groups) {
      value->Fail(
          "stands beside correction tables, which are the candidates then; one of both is allowed");
    }
    options->kinds = ReadKinds(*value);
  }
  if (const auto value = table.Find("max_degree")) {
    options->max_degree = value->Integer(0, PositionCorrection::kMaxDegree);
  }
  if (const auto value = table.Find("knot_spacings_s")) {
    options->knot_spacings_s = ReadSpacings(*value);
  }
  if (const auto value = table.Find("max_condition")) {
    options->max_condition_1 = Below(*value, 1.0, 1e300, "a number above 1 is");
  }
  if (const auto value = table.Find("max_posterior_prior")) {
    options->max_posterior_prior_1 = Below(*value, 0.0, 1.0, "a number above 0 and at most 1 is");
  }
}

std::string DumpSelection(const AdjustOptions& options) {
  const SelectionOptions& selection = options.selection;
  std::string text = "[adjust.selection]\n";
  const auto line = [&text](std::string_view key, const std::string& value) {
    text.append(key).append(" = ").append(value).append("\n");
  };
  const auto list = [&line](std::string_view key, const std::vector<std::string>& entries) {
    std::string value;
    for (const std::string& entry : entries) value += (value.empty() ? "" : ", ") + entry;
    line(key, "[" + value + "]");
  };
  line("mode", TomlText(NameIn(selection.mode)));
  line("significance", NumberText(selection.significance_1));
  if (options.groups.empty()) {
    std::vector<std::string> kinds;
    for (const std::size_t kind : selection.kinds) {
      kinds.push_back(TomlText(CorrectionKinds()[kind]));
    }
    list("candidates", kinds);
  }
  line("max_degree", std::to_string(selection.max_degree));
  if (selection.knot_spacings_s) {
    std::vector<std::string> spacings;
    for (const double spacing_s : *selection.knot_spacings_s) {
      spacings.push_back(NumberText(spacing_s));
    }
    list("knot_spacings_s", spacings);
  }
  line("max_condition", NumberText(selection.max_condition_1));
  line("max_posterior_prior", NumberText(selection.max_posterior_prior_1));
  line("simplify", NumberText(selection.simplify_1));
  return text;
}

}  // namespace sarblock
