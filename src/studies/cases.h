// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/error.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study.h"
#include "tables/toml.h"

namespace sarblock {

/// The blocks of a study over scenes: axes of values and listed cases, and what makes scenes and
/// options of them (docs/studies.md).

/// Most cases of one study, listed and as products.
inline constexpr std::size_t kMaxStudyCases = 10000;

/// One block of a study.
struct StudyCase {
  std::string layout;   ///< of its control, "corners", ...; "none" without any
  std::string variant;  ///< what else it was chosen by, "tie strips: none"; may be empty
  Scene scene;
  AdjustOptions adjust;
};

/// What one value of an axis, or a listed case, changes in the scene.
struct CaseChoice {
  std::string label;  ///< empty: not given (control layout and count have columns of their own)
  std::optional<std::string> scene;
  std::optional<std::vector<std::string>> flights;
  std::vector<std::string> set;
  FilePlace place;
  std::string value;  ///< of an axis: the value, its label or the name of the case
  double number =
      kNotGiven;  ///< of a value that is a number or a list of one, of a case its `number`

  /// The other's changes after these.
  void Add(const CaseChoice& other);
};

/// One [[axis]]: its values, by `key` or several `keys` that take the same one, or its cases.
struct CaseAxis {
  std::string name;
  std::vector<CaseChoice> choices;
};
[[nodiscard]] CaseAxis ReadAxis(SceneTable table);

/// `set`, `scene` and `flights` of a table.
[[nodiscard]] CaseChoice TakeChanges(SceneTable* table);

/// The product of the axes, the last one fastest. Throws InputError at `place` for more than
/// kMaxStudyCases.
[[nodiscard]] std::vector<CaseChoice> Product(const CaseChoice& base,
                                              const std::vector<CaseAxis>& axes,
                                              const FilePlace& place);

/// Makes cases of choices: reads each scene once, applies the overrides, checks. What cannot be
/// predicted (corrections = "auto", ...) is refused.
class CaseMaker {
 public:
  /// `file` is the study's name for messages, `scene_text` gives the text of a scene by the name
  /// that the study gives.
  CaseMaker(std::string file, std::function<std::string(const std::string&)> scene_text)
      : file_(std::move(file)), scene_text_(std::move(scene_text)) {}

  /// Texts of the scenes so far, by name.
  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }
  [[nodiscard]] StudyCase Make(const CaseChoice& choice);

 private:
  [[nodiscard]] StudyCase MakeUnnamed(const CaseChoice& choice);

  std::string file_;
  std::function<std::string(const std::string&)> scene_text_;
  std::map<std::string, std::string> texts_;
};

/// Whether the block of a row was determined (column `determined`).
[[nodiscard]] bool IsDetermined(const StudyTable& table, std::size_t row);

/// The scene's block as planned: paths as planned, looks at the nominal times, nothing measured.
[[nodiscard]] SimulatedBlock PlannedBlock(const Scene& scene);

}  // namespace sarblock
