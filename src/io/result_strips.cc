// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "adjust/held_covariance.h"
#include "adjust/strip_stations.h"
#include "csv_writer.h"
#include "result_tables.h"

namespace sarblock {
namespace {

void WriteVector(const Eigen::Vector3d& v, double factor, CsvWriter* out) {
  for (Eigen::Index k = 0; k < 3; ++k) out->Number(factor * v[k]);
}

}  // namespace

void WriteStripTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"pass",
                 "look",
                 "time_s",
                 "strip_time",
                 "x_m",
                 "y_m",
                 "z_m",
                 "near_x_m",
                 "near_y_m",
                 "near_z_m",
                 "far_x_m",
                 "far_y_m",
                 "far_z_m",
                 "correction_along_m",
                 "correction_across_m",
                 "correction_up_m",
                 "sigma_along_m",
                 "sigma_across_m",
                 "sigma_up_m"},
                view.context.compression);
  for (const StripStation& station :
       SampleStrips(view.block, UsedGroups(view.options, view.result), view.result)) {
    const Pass& pass = view.block.passes[station.pass];
    out.Text(pass.id).Text(pass.side == LookSide::kLeft ? "left" : "right");
    out.Number(station.time_s).Number(station.strip_time_1);
    WriteVector(station.antenna_m, 1.0, &out);
    WriteVector(station.near_m, 1.0, &out);
    WriteVector(station.far_m, 1.0, &out);
    WriteVector(station.correction_m, 1.0, &out);
    WriteVector(station.correction_sigma_m, std::sqrt(view.factor), &out);
    out.EndRow();
  }
  out.Commit();
}

}  // namespace sarblock
