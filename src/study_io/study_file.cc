// SPDX-License-Identifier: Apache-2.0
#include "study_file.h"

#include <sstream>

#include "io/toml_document.h"

namespace sarblock {
namespace {

constexpr char kStudyFormat[] = "sarblock-study 1";

}  // namespace

std::string EffectiveStudyText(const std::filesystem::path& path,
                               const std::vector<std::string>& overrides) {
  return TextOf(ParseToml(ReadTomlText(path, "a study"), path.string(), overrides));
}

std::string AsTomlComment(const std::string& text) {
  std::string out;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) out += "\n# " + line;
  return out + "\n";
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
