// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/result_reader.h"

#include "result_summary_reader.h"
#include "result_table_reader.h"
#include "tables/open.h"

namespace sarblock {
namespace {

ResultFile ReadResultFrom(const TableSource& source, const ReadResultOptions& options) {
  ResultReading reading{source, options, {}, {}, 0, 0};
  ReadResultSummary(&reading);
  ReadResultPoints(&reading);
  ReadResultParameters(&reading);
  if (options.paths) ReadResultPaths(&reading);
  if (options.looks) ReadResultLooks(&reading);
  ReadResultControl(&reading);
  if (options.pairs) ReadResultPairs(&reading);
  ReadResultStrips(&reading);
  ReadResultSelection(&reading);
  reading.result.points.ids.DropIndex();
  return std::move(reading.result);
}

}  // namespace

ResultFile ReadResult(const std::filesystem::path& folder, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesAt(folder, FolderContent::kResult), options);
}

ResultFile ReadResultTexts(const ResultTexts& texts, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesOfTexts({{"summary.json", texts.summary_json},
                                        {"points.csv", texts.points_csv},
                                        {"passes.csv", texts.passes_csv},
                                        {"residuals.csv", texts.residuals_csv},
                                        {"trajectories.csv", texts.trajectories_csv},
                                        {"passes_covariance.csv", texts.passes_covariance_csv},
                                        {"control_quality.csv", texts.control_quality_csv},
                                        {"pairs.csv", texts.pairs_csv},
                                        {"strips.csv", texts.strips_csv},
                                        {"selection.csv", texts.selection_csv},
                                        {"simplifications.csv", texts.simplifications_csv}},
                                       FolderContent::kResult),
                        options);
}

}  // namespace sarblock
