// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "study_journal.h"

namespace sarblock {

/// "I/N" with 0 <= I <= N and 1 <= N <= kMostStudyParts: the tasks I modulo N, 0 and N the same, so
/// that job arrays may count from 0 or from 1. Nothing for another text.
inline constexpr std::size_t kMostStudyParts = 1000000;
[[nodiscard]] std::optional<StudyPart> StudyPartOf(const std::string& text);

/// The rows of every task of a study, in their order, from the folders of its parts. Throws
/// InputError naming the folder that holds no part, a part of another study, of another number of
/// parts, a part that is there twice or is not finished, and the parts that are missing.
[[nodiscard]] std::vector<std::vector<StudyRow>> JoinStudyParts(
    const std::vector<std::filesystem::path>& folders, const StudyIdentity& identity);

}  // namespace sarblock
