// SPDX-License-Identifier: Apache-2.0
#include "study_io/stability_file.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "study_file.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

/// The values of a [[family]] table instead of the family's own.
void ReadValues(const TomlValue& values, StabilityFamily* family) {
  const auto [least, most] = std::minmax_element(family->values.begin(), family->values.end());
  std::vector<double> read;
  for (const TomlValue& entry : values.Entries()) {
    const double value = entry.Number();
    // The defaults are powers, rounded in their last digits.
    if (!(value >= *least * (1.0 - 1e-12) && value <= *most * (1.0 + 1e-12))) {
      std::ostringstream range;
      range << "must lie between " << *least << " and " << *most << ", where " << family->name
            << " is a block";
      entry.Fail(range.str());
    }
    if (family->whole && value != std::floor(value)) entry.Fail("must be a whole number");
    read.push_back(value);
  }
  if (read.empty()) values.Fail("must not be empty");
  family->values = std::move(read);
}

}  // namespace

StabilityStudy ParseStability(std::string_view text,
                              const std::string& file,
                              const std::vector<std::string>& overrides) {
  const toml::table parsed = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(parsed, "")};
  StabilityStudy study;
  study.heading = TakeStudyHeading("stability", &table);
  if (const auto seed = table.Take("seed")) {
    seed->Fail("is not used here: every family has its own noise");
  }
  const std::vector<StabilityFamily> all = StabilityFamilies();
  std::vector<std::string> names;
  for (const StabilityFamily& family : all) names.push_back(family.name);
  std::set<std::string> taken;
  const auto named = [&](const TomlValue& name) {
    const StabilityFamily& family = all[name.OneOf(names)];
    if (!taken.insert(family.name).second) name.Fail("stands there twice");
    return family;
  };
  if (const auto listed = table.Take("families")) {
    for (const TomlValue& entry : listed->Entries()) study.families.push_back(named(entry));
  }
  for (SceneTable& given : table.Tables("family")) {
    const auto name = given.Take("name");
    if (!name) throw InputError(given.PlaceOf("name"), "must be given");
    StabilityFamily family = named(*name);
    if (const auto values = given.Take("values")) ReadValues(*values, &family);
    given.Finish();
    study.families.push_back(std::move(family));
  }
  table.Finish();
  if (study.families.empty()) study.families = all;
  return study;
}

StabilityStudy ReadStability(const std::filesystem::path& path,
                             const std::vector<std::string>& overrides) {
  return ParseStability(ReadTomlText(path, "a study"), path.string(), overrides);
}

std::vector<std::string> StabilityKeys() { return {"name", "purpose", "families"}; }

}  // namespace sarblock
