// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/result_files.h"

#include <filesystem>

#include "geojson.h"

namespace sarblock {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const AdjustOptions& options;
  const AdjustResult& result;
  const ResultContext& context;
  double factor = 1.0;  ///< on covariances
};

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
