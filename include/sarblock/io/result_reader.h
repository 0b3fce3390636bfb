// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/result_file.h"

#include <filesystem>
#include <optional>
#include <string_view>

namespace sarblock {

/// Reads what WriteResult() wrote (docs/formats.md): summary.json, points.csv, passes.csv,
/// passes_covariance.csv, residuals.csv, control_quality.csv, pairs.csv, strips.csv, selection.csv,
/// simplifications.csv and trajectories.csv, each table plain or as `.csv.gz`, or all of an HDF5
/// file (docs/container.md). Covariances are as
/// written: scaled by the posterior variance factor where the result is. montecarlo.csv is not
/// read: its sums stand in the summary. Report, comparison and export read results by this alone.
///
/// Every fault of the files throws InputError with file, line and field, as ReadBlock() does; also
/// tables that contradict each other (a look of a point that points.csv does not have, fewer
/// points than the summary counts: files of two results). Columns not known are ignored. A summary
/// without `frame` or `passes`, of a version before they were written, is refused. Memory: about
/// 300 bytes a point and 100 a look.
[[nodiscard]] ResultFile ReadResult(const std::filesystem::path& path,
                                    const ReadResultOptions& options = {});

/// A result as texts, named like the files they stand for.
struct ResultTexts {
  std::string_view summary_json;
  std::string_view points_csv;
  std::string_view passes_csv;
  std::string_view residuals_csv;
  std::string_view trajectories_csv;
  std::optional<std::string_view> passes_covariance_csv = {};
  std::optional<std::string_view> control_quality_csv = {};
  std::optional<std::string_view> pairs_csv = {};
  std::optional<std::string_view> strips_csv = {};
  std::optional<std::string_view> selection_csv = {};
  std::optional<std::string_view> simplifications_csv = {};
};
/// The same from memory.
[[nodiscard]] ResultFile ReadResultTexts(const ResultTexts& texts,
                                         const ReadResultOptions& options = {});

}  // namespace sarblock
