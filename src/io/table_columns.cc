// SPDX-License-Identifier: Apache-2.0
#include "table_columns.h"

#include <utility>

namespace sarblock {

std::string_view UnitOfColumn(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kUnits{{{"m", "m"},
                                                                                 {"s", "s"},
                                                                                 {"mps", "m/s"},
                                                                                 {"m2", "m2"},
                                                                                 {"deg", "degree"},
                                                                                 {"hz", "Hz"},
                                                                                 {"px", "pixel"}}};
  const std::size_t at = name.rfind('_');
  for (const auto& [ending, unit] : kUnits) {
    if (at != name.npos && name.substr(at + 1) == ending) return unit;
  }
  return "1";
}

std::span<const TableDescription> TablesOf(FolderContent content) {
  static constexpr std::array<TableDescription, 5> kBlock{{{"trajectories", kPathColumns},
                                                           {"observations", kObservationColumns},
                                                           {"points", kPointColumns},
                                                           {"truth", kTruthColumns},
                                                           {"truth_passes", kPathColumns}}};
  static constexpr std::array<TableDescription, 11> kResult{
      {{"points", kResultPointColumns},
       {"passes", kParameterColumns},
       {"passes_covariance", kParameterCovarianceColumns},
       {"selection", kSelectionColumns},
       {"simplifications", kSimplificationColumns},
       {"strips", kStripColumns},
       {"residuals", kResidualColumns},
       {"control_quality", kControlColumns},
       {"pairs", kPairColumns},
       {"montecarlo", kMonteCarloColumns},
       {"trajectories", kPathColumns}}};
  static constexpr std::array<TableDescription, 2> kPart{
      {{"draws", kDrawColumns}, {"sums", kSumColumns}}};
  if (content == FolderContent::kBlock) return kBlock;
  if (content == FolderContent::kPart) return kPart;
  return kResult;
}

}  // namespace sarblock
