// SPDX-License-Identifier: Apache-2.0
#include "result_corrections.h"

#include "sarblock/core/error.h"
#include "sarblock/io/adjust_table.h"

#include <string>

#include "tables/json.h"
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

// A JSON value as a TOML value on one line: tables are inline, what is null is left out. Texts and
// numbers are written alike in both.
std::string TomlOf(const nlohmann::ordered_json& value) {
  std::string text;
  const auto append = [&text](const std::string& part) {
    text += (text.size() > 1 ? ", " : "") + part;
  };
  if (value.is_object()) {
    text = "{";
    for (const auto& [key, member] : value.items()) {
      if (!member.is_null()) append(nlohmann::ordered_json(key).dump() + " = " + TomlOf(member));
    }
    return text + "}";
  }
  if (value.is_array()) {
    text = "[";
    for (const auto& entry : value) append(TomlOf(entry));
    return text + "]";
  }
  return value.dump();
}

}  // namespace

std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result) {
  constexpr const char* kFile = "summary.json";
  std::vector<std::string> passes;
  for (const ResultPass& pass : result.passes) passes.push_back(pass.id);
  if (!result.summary.selected_model.empty()) {
    return ReadAdjustTable(result.summary.selected_model, kFile, passes).groups;
  }
  const JsonFile json(result.summary.json, kFile);
  const auto configuration = json.Root().Find("configuration");
  if (!configuration) return {};
  const auto chosen = configuration->Find("corrections");
  const auto correction = configuration->Find("correction");
  if (!chosen || chosen->Text() != "given" || !correction) return {};
  return ReadAdjustTable(
             "[adjust]\ncorrection = " + TomlOf(correction->Node()) + "\n", kFile, passes)
      .groups;
}

}  // namespace sarblock
