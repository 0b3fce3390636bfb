// SPDX-License-Identifier: Apache-2.0
#include "scene_table.h"

namespace sarblock {

std::optional<TomlValue> SceneTable::Take(const std::string& key) {
  known_.push_back(key);
  return table_.Find(key);
}

void SceneTable::Number(const std::string& key, double* value, double unit) {
  if (const auto taken = Take(key)) *value = taken->Number() * unit;
}

void SceneTable::Text(const std::string& key, std::string* value) {
  if (const auto taken = Take(key)) *value = taken->Text();
}

void SceneTable::Truth(const std::string& key, bool* value) {
  if (const auto taken = Take(key)) *value = taken->Flag();
}

std::vector<double> SceneTable::NumbersOf(const TomlValue& value, std::size_t count) {
  std::vector<double> numbers;
  for (const TomlValue& entry : value.Entries()) numbers.push_back(entry.Number());
  if (numbers.size() != count) {
    value.Fail("is a list of " + std::to_string(numbers.size()) + ", a list of " +
               std::to_string(count) + " numbers is needed");
  }
  return numbers;
}

std::optional<SceneTable> SceneTable::Table(const std::string& key) {
  const auto taken = Take(key);
  return taken ? std::optional<SceneTable>(TomlTable(*taken)) : std::nullopt;
}

std::vector<SceneTable> SceneTable::Tables(const std::string& key) {
  std::vector<SceneTable> tables;
  const auto taken = Take(key);
  if (!taken) return tables;
  const std::vector<TomlValue> entries = taken->Entries();
  if (entries.empty()) taken->Fail("is empty, a list of tables [[" + key + "]] is needed");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    // Dotted as in --set: flight.0.height_m.
    const TomlValue entry(entries[i].node(), taken->key() + "." + std::to_string(i));
    tables.emplace_back(TomlTable(entry));
  }
  return tables;
}

}  // namespace sarblock
