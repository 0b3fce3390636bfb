// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/diagnose/diagnosis.h"
#include "sarblock/io/input_files.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// What a result folder says about the run beside the result itself.
struct ResultContext {
  std::string command = "adjust";     ///< adjust, intersect or predict
  std::vector<std::string> warnings;  ///< of reading the block; the result's own come after
  std::vector<InputFile> inputs{};    ///< the files read, with their checksums
  /// Points above which points.geojson leaves out the ellipses' polygons (1.2 kB each) and keeps
  /// their numbers; the summary then has a warning.
  std::size_t ellipse_limit = 100000;
  Compression compression = Compression::kNone;  ///< of the tables
  std::vector<StageCost> stages;                 ///< before the result's own, such as `read`
  std::optional<Diagnosis> diagnosis;            ///< where one was made
};

/// Content of summary.json (docs/formats.md), a newline at the end. Figures that do not exist
/// (NaN) are null.
[[nodiscard]] std::string SummaryJson(const Block& block,
                                      const AdjustOptions& options,
                                      const AdjustResult& result,
                                      const ResultContext& context);

/// Writes a result folder, or an HDF5 file (without points.geojson) where the name ends in ".h5":
/// summary.json, points.csv, passes.csv, passes_covariance.csv,
/// residuals.csv, control_quality.csv (with control), selection.csv and simplifications.csv (if
/// corrections were chosen), pairs.csv and montecarlo.csv (if asked for), trajectories.csv,
/// strips.csv, points.geojson (geocentric frames). Each file appears whole or not at all,
/// summary.json last. Returns the summary that was written; its stages end with `write`, the cost
/// of this call. Positions in frame axes [m]; standard deviations and covariances in east, north,
/// up, times CovarianceFactor(); angles in degrees. What was not computed is an empty cell.
std::string WriteResult(const std::filesystem::path& target,
                        const Block& block,
                        const AdjustOptions& options,
                        const AdjustResult& result,
                        const ResultContext& context);

}  // namespace sarblock
