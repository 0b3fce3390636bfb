// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/error.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <vector>

#include "geojson.h"
#include "tables/table.h"

namespace sarblock::files {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const IdTable& pass_ids;
  const AdjustOptions& options;
  const AdjustResult& result;
};

/// A figure that a table has as the result has it, angles in degrees: one list for both ways.
template <typename Of, typename Member>
struct TableFigure {
  std::size_t column;
  Member Of::*member;
  double written = 1.0, read = 1.0;  ///< factors
};
inline constexpr std::array<TableFigure<PointResults, std::vector<double>>, 7> kPointFigures{{
    {kResultPointColumns("intersection_deg"),
     &PointResults::intersection_rad,
     kDegPerRad,
     kRadPerDeg},
    {kResultPointColumns("sigma_leberl_across_m"), &PointResults::sigma_leberl_across_m},
    {kResultPointColumns("sigma_leberl_up_m"), &PointResults::sigma_leberl_up_m},
    {kResultPointColumns("sigma_leberl_path_across_m"), &PointResults::sigma_leberl_path_across_m},
    {kResultPointColumns("sigma_leberl_path_up_m"), &PointResults::sigma_leberl_path_up_m},
    {kResultPointColumns("leberl_across_azimuth_deg"),
     &PointResults::leberl_across_azimuth_rad,
     kDegPerRad,
     kRadPerDeg},
    {kResultPointColumns("redundancy"), &PointResults::redundancy},
}};
inline constexpr std::array<TableFigure<PairResult, double>, 4> kPairFigures{{
    {kPairColumns("sigma_leberl_across_m"), &PairResult::sigma_leberl_across_m},
    {kPairColumns("sigma_leberl_up_m"), &PairResult::sigma_leberl_up_m},
    {kPairColumns("sigma_leberl_path_across_m"), &PairResult::sigma_leberl_path_across_m},
    {kPairColumns("sigma_leberl_path_up_m"), &PairResult::sigma_leberl_path_up_m},
}};

/// "score", "wald" or nothing.
[[nodiscard]] const char* NameOf(SelectionTest test);

void WritePointTable(TableSink* sink, const ResultView& view);
void WriteParameterTable(TableSink* sink, const ResultView& view);
void WriteParameterCovariance(TableSink* sink, const ResultView& view);
void WriteSelectionTable(TableSink* sink, const ResultView& view);
void WriteSimplificationTable(TableSink* sink, const ResultView& view);
void WriteResidualTable(TableSink* sink, const ResultView& view);
void WriteControlTable(TableSink* sink, const ResultView& view);
void WritePairTable(TableSink* sink, const ResultView& view);
void WriteStripTable(TableSink* sink, const ResultView& view);

}  // namespace sarblock::files
