// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "study_journal.h"

namespace sarblock {

/// The rows of every task of a study, in their order, from the folders of its parts. Throws
/// InputError naming the folder that holds no part, a part of another study, of another number of
/// parts, a part that is there twice or is not finished, and the parts that are missing.
[[nodiscard]] std::vector<std::vector<StudyRow>> JoinStudyParts(
    const std::vector<std::filesystem::path>& folders, const StudyIdentity& identity);

}  // namespace sarblock
