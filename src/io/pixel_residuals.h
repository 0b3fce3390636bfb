// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "result_view.h"
#include "tables/table.h"

namespace sarblock {

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
