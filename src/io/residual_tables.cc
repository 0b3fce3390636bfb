// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "csv_writer.h"
#include "pixel_residuals.h"
#include "result_tables.h"
#include "testing/blunder_sizes.h"
#include "testing/quality_summary.h"

namespace sarblock {
namespace {

constexpr std::array<const char*, 3> kComponents = {"e", "n", "u"};

/// By look: the number of the finding of the blunder search that names it, 0 without one.
std::vector<std::uint32_t> FindingOfLook(const ResultView& view) {
  std::vector<std::uint32_t> of_look(view.block.looks.size(), 0);
  if (!view.result.snooping) return of_look;
  std::uint32_t number = 0;
  for (const BlunderFinding& finding : view.result.snooping->findings) {
    ++number;
    for (const std::uint64_t look : finding.looks) of_look[look] = number;
  }
  return of_look;
}

void WriteQuality(const ResultView& view,
                  const BlunderSizes& sizes,
                  std::uint64_t look,
                  std::size_t point,
                  CsvWriter* out) {
  const LookQuality& quality = view.result.quality;
  if (quality.empty()) {
    out->Empty(10);
    return;
  }
  std::array<double, 2> w_1{};
  for (std::size_t k = 0; k < 2; ++k) w_1[k] = static_cast<double>(quality.w_1[k][look]);
  for (const auto& r : quality.redundancy_1) out->Number(static_cast<double>(r[look]));
  for (const double w : w_1) out->Number(w);
  for (const double w : w_1) out->Number(TauOf(w, view.result));
  const std::array<BlunderSize, 2> size = sizes.OfLook(look, point);
  for (const BlunderSize& s : size) out->Number(s.detectable_m);
  for (const BlunderSize& s : size) out->Number(s.influence_m);
}

}  // namespace

void WriteResidualTable(const std::filesystem::path& file, const ResultView& view) {
  std::vector<std::string_view> columns{"pass",
                                        "point",
                                        "range_residual_m",
                                        "azimuth_residual_m",
                                        "range_redundancy",
                                        "azimuth_redundancy",
                                        "range_w",
                                        "azimuth_w",
                                        "range_tau",
                                        "azimuth_tau",
                                        "range_mdb_m",
                                        "azimuth_mdb_m",
                                        "range_influence_m",
                                        "azimuth_influence_m",
                                        "weight",
                                        "rejected",
                                        "reason",
                                        "finding"};
  const PixelResiduals pixels(view);
  pixels.AddColumns(&columns);
  CsvWriter out(file, columns, view.context.compression);
  const Block& block = view.block;
  const LookResults& looks = view.result.looks;
  const BlunderSizes sizes(view.block, view.options, view.result, view.factor);
  const std::vector<std::uint32_t> finding = FindingOfLook(view);
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      out.Text(block.passes[block.looks.pass[i]].id).Text(block.points.ids[point]);
      out.Number(looks.range_residual_m.empty() ? kNotGiven : looks.range_residual_m[i]);
      out.Number(looks.azimuth_residual_m.empty() ? kNotGiven : looks.azimuth_residual_m[i]);
      WriteQuality(view, sizes, i, point, &out);
      const bool rejected =
          looks.rejected.empty() ? block.looks.rejected(i) : looks.rejected[i] != 0;
      out.Number(looks.weight.empty() ? 1.0 : static_cast<double>(looks.weight[i]));
      out.Integer(rejected ? 1 : 0);
      out.Text(looks.reason.empty() ? "" : sarblock::NameOf(looks.reason[i]));
      if (finding[i] > 0) {
        out.Integer(finding[i]);
      } else {
        out.Empty();
      }
      pixels.Write(i, point, &out);
      out.EndRow();
    }
  }
  out.Commit();
}

void WriteControlTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"point",
                 "component",
                 "residual_m",
                 "sigma_m",
                 "redundancy",
                 "w",
                 "tau",
                 "mdb_m",
                 "influence_m"},
                view.context.compression);
  const BlunderSizes sizes(view.block, view.options, view.result, view.factor);
  for (const ControlQuality& control : view.result.control_quality) {
    const BlunderSize size = sizes.OfControl(control);
    out.Text(view.block.points.ids[control.point]);
    out.Text(kComponents[static_cast<std::size_t>(control.component)]);
    out.Number(control.residual_m)
        .Number(size.sigma_m)
        .Number(control.redundancy_1)
        .Number(control.w_1);
    out.Number(TauOf(control.w_1, view.result));
    out.Number(size.detectable_m).Number(size.influence_m).EndRow();
  }
  out.Commit();
}

}  // namespace sarblock
