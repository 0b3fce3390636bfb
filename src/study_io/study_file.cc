// SPDX-License-Identifier: Apache-2.0
#include "study_file.h"

#include <map>
#include <sstream>
#include <utility>

#include "tables/toml.h"

namespace sarblock {
namespace {

constexpr char kStudyFormat[] = "sarblock-study 1";
constexpr char kAsItRan[] = "# written by sarblock: the study of ";

}  // namespace

std::string EffectiveStudyText(const std::filesystem::path& path,
                               const std::vector<std::string>& overrides) {
  return TextOf(ParseToml(ReadTomlText(path, "a study"), path.string(), overrides));
}

std::string StudyAsItRan(const std::string& table, const std::string& identity) {
  return kAsItRan + table + "\n" + identity;
}

std::string SceneAsComment(const std::string& name, const std::string& text) {
  std::string out;
  std::istringstream stream(name + "\n" + text);
  for (std::string line; std::getline(stream, line);) out += "\n# " + line;
  return out + "\n";
}

std::function<std::string(const std::string& name)> ScenesOf(
    const std::filesystem::path& study_file, const std::string& study_text) {
  std::map<std::string, std::string> carried;
  std::string* scene = nullptr;
  bool after_blank = false;
  std::istringstream stream(study_text.starts_with(kAsItRan) ? study_text : std::string());
  for (std::string line; std::getline(stream, line);) {
    const bool comment = line.starts_with("# ");
    if (comment && after_blank) {
      scene = &carried[line.substr(2)];
    } else if (comment && scene != nullptr) {
      *scene += line.substr(2) + "\n";
    } else {
      scene = nullptr;
    }
    after_blank = line.empty();
  }
  return [carried = std::move(carried),
          beside = SceneTextsBeside(study_file)](const std::string& name) {
    const auto found = carried.find(name);
    return found == carried.end() ? beside(name) : found->second;
  };
}

StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table) {
  StudyHeading heading;
  const auto require = [&](const std::string& key, const std::string& wanted) {
    const std::string problem = "must be \"" + wanted + "\"";
    const auto given = table->Take(key);
    if (!given) throw InputError(table->PlaceOf(key), problem);
    if (given->Text() != wanted) given->Fail(problem);
  };
  require("format", kStudyFormat);
  require("study", kind);
  table->Text("name", &heading.name);
  table->Text("purpose", &heading.purpose);
  table->Count("seed", &heading.seed);
  return heading;
}

}  // namespace sarblock
