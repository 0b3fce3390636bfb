// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "geojson.h"
#include "result_view.h"

namespace sarblock {

/// "score", "wald" or nothing.
[[nodiscard]] const char* NameOf(SelectionTest test);

void WritePointTable(const std::filesystem::path& file, const ResultView& view);
void WriteParameterTable(const std::filesystem::path& file, const ResultView& view);
void WriteParameterCovariance(const std::filesystem::path& file, const ResultView& view);
void WriteSelectionTable(const std::filesystem::path& file, const ResultView& view);
void WriteSimplificationTable(const std::filesystem::path& file, const ResultView& view);
void WriteResidualTable(const std::filesystem::path& file, const ResultView& view);
void WriteControlTable(const std::filesystem::path& file, const ResultView& view);
void WritePairTable(const std::filesystem::path& file, const ResultView& view);
void WriteStripTable(const std::filesystem::path& file, const ResultView& view);

}  // namespace sarblock
