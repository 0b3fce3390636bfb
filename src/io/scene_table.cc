// SPDX-License-Identifier: Apache-2.0
#include "scene_table.h"

#include "sarblock/core/id_table.h"

#include <cstdint>

namespace sarblock {

FilePlace PlaceOf(const toml::node& node, const std::string& file, const std::string& field) {
  const toml::source_region& source = node.source();
  return {source.path ? *source.path : file, source.begin.line, field};
}

SceneTable::SceneTable(const toml::table& table, std::string prefix, std::string file)
    : table_(&table), prefix_(std::move(prefix)), file_(std::move(file)) {}

const toml::node* SceneTable::Take(const std::string& key) {
  known_.push_back(key);
  return table_->get(key);
}

void SceneTable::Fail(const toml::node& node,
                      const std::string& key,
                      const std::string& problem) const {
  throw InputError(PlaceOf(node, file_, prefix_ + key), problem);
}

void SceneTable::Number(const std::string& key, double* value, double unit) {
  const toml::node* node = Take(key);
  if (node == nullptr) return;
  const std::optional<double> number = node->value<double>();
  if (!number || !node->is_number()) Fail(*node, key, "must be a number");
  *value = *number * unit;
}

std::size_t SceneTable::CountOf(const toml::node& node, const std::string& key) const {
  const std::optional<std::int64_t> number = node.value_exact<std::int64_t>();
  if (!number || *number < 0) Fail(node, key, "must be a whole number, 0 or more");
  return static_cast<std::size_t>(*number);
}

void SceneTable::Text(const std::string& key, std::string* value) {
  const toml::node* node = Take(key);
  if (node == nullptr) return;
  const std::optional<std::string> text = node->value_exact<std::string>();
  if (!text) Fail(*node, key, "must be a text in quotes");
  *value = *text;
}

void SceneTable::Truth(const std::string& key, bool* value) {
  const toml::node* node = Take(key);
  if (node == nullptr) return;
  const std::optional<bool> truth = node->value_exact<bool>();
  if (!truth) Fail(*node, key, "must be true or false");
  *value = *truth;
}

std::vector<double> SceneTable::NumbersOf(const toml::node& node,
                                          const std::string& key,
                                          std::size_t count) const {
  const toml::array* array = node.as_array();
  const std::string problem = "must be a list of " + std::to_string(count) + " numbers";
  if (array == nullptr || array->size() != count) Fail(node, key, problem);
  std::vector<double> values;
  for (const toml::node& element : *array) {
    const std::optional<double> number = element.value<double>();
    if (!number || !element.is_number()) Fail(element, key, problem);
    values.push_back(*number);
  }
  return values;
}

std::size_t SceneTable::ChoiceOf(const toml::node& node,
                                 const std::string& key,
                                 const std::vector<std::string>& names) const {
  const std::optional<std::string> text = node.value_exact<std::string>();
  const auto found = text ? std::find(names.begin(), names.end(), *text) : names.end();
  if (found == names.end()) {
    std::string allowed;
    for (const std::string& name : names) allowed += (allowed.empty() ? "" : ", ") + name;
    Fail(node,
         key,
         (text ? "'" + *text + "' is not known" : "must be a text") + ", allowed are " + allowed);
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::vector<std::string> SceneTable::Texts(const std::string& key) {
  std::vector<std::string> texts;
  const toml::node* node = Take(key);
  if (node == nullptr) return texts;
  const toml::array* array = node->as_array();
  if (array == nullptr) Fail(*node, key, "must be a list of texts");
  for (const toml::node& element : *array) {
    const std::optional<std::string> text = element.value_exact<std::string>();
    if (!text) Fail(element, key, "must be a list of texts");
    texts.push_back(*text);
  }
  return texts;
}

const toml::table* SceneTable::Table(const std::string& key) {
  const toml::node* node = Take(key);
  if (node != nullptr && !node->is_table()) Fail(*node, key, "must be a table");
  return node == nullptr ? nullptr : node->as_table();
}

const toml::array* SceneTable::Tables(const std::string& key) {
  const toml::node* node = Take(key);
  if (node == nullptr) return nullptr;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty() || !array->is_homogeneous(toml::node_type::table)) {
    Fail(*node, key, "must be a list of tables, [[" + key + "]]");
  }
  return array;
}

void SceneTable::Finish() const {
  for (const auto& [key, node] : *table_) {
    const std::string name(key.str());
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    Fail(node,
         name,
         "is not a key of a scene here; did you mean " + NearestName(name, known_) + "?");
  }
}

}  // namespace sarblock
