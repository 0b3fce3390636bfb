// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>

#include "geojson.h"
#include "tables/table.h"

namespace sarblock {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const AdjustOptions& options;
  const AdjustResult& result;
  double factor = 1.0;  ///< on covariances
};

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

/// The columns `line`, `pixel`, `line_residual_px` and `pixel_residual_px` of residuals.csv: where
/// the look was measured in the image, and its residuals as steps of the image, computed minus
/// measured. They stand there if a pass has an image; cells of looks of other passes are empty.
/// docs/theory/image_coordinates.md, eq. (5).
class PixelResiduals {
 public:
  explicit PixelResiduals(const ResultView& view);

  [[nodiscard]] bool present() const { return present_; }
  void Write(std::size_t look, std::size_t point, TableWriter* out) const;

 private:
  const ResultView& view_;
  bool present_ = false;
};

}  // namespace sarblock
