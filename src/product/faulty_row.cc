// SPDX-License-Identifier: Apache-2.0
#include "sarblock/product/faulty_row.h"

#include <fmt/core.h>

namespace sarblock {

std::string Describe(const FaultyRow& row) {
  const auto span = [](const double(&bounds)[2]) {
    return fmt::format("{:.1f} to {:.1f} m", bounds[0], bounds[1]);
  };
  std::string text = fmt::format(
      "{}:{}: geolocationGrid line {} (row {}): {} of {} points do not fit the orbit, along track "
      "by "
      "{}, in range by {}",
      row.file,
      row.file_line,
      row.line,
      row.row,
      row.points,
      row.of,
      span(row.along_m),
      span(row.range_m));
  if (row.fault == GridFault::kPosition) return text + "; their looks are rejected";
  return text + "; heights changed by " + span(row.height_m) +
         " would fit, so their heights are not used";
}

}  // namespace sarblock
