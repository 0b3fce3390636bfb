// SPDX-License-Identifier: Apache-2.0
#include "product/faulty_row.h"

#include <fmt/core.h>

namespace sarblock {

std::string Describe(const FaultyRow& row) {
  const auto span = [](const double(&bounds)[2]) {
    return fmt::format("{:.1f} to {:.1f} m", bounds[0], bounds[1]);
  };
  std::string text = fmt::format(
      "{}: geolocationGrid line {} (row {}): {} of {} points do not fit the orbit, along track by "
      "{}, in range by {}",
      row.file_line > 0 ? fmt::format("{}:{}", row.file, row.file_line) : row.file,
      row.line,
      row.row,
      row.points,
      row.of,
      span(row.along_m),
      span(row.range_m));
  if (row.same_time) text += "; its azimuth time is that of the row before";
  if (row.fault == GridFault::kPosition) {
    return row.used ? text + "; their looks are rejected" : text;
  }
  text += "; heights changed by " + span(row.height_m) + " would fit";
  return row.used ? text + ", so their heights are not used" : text;
}

}  // namespace sarblock
