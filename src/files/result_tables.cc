// SPDX-License-Identifier: Apache-2.0
#include "result_tables.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "block_tables.h"
#include "quality/assess.h"

namespace sarblock {
namespace {

void WriteCovariance(const SymmetricEnu& covariance_m2, double factor, TableWriter* out) {
  for (const double element_m2 : covariance_m2) out->Number(factor * element_m2);
}

// Errors of a check point.
void WriteCheck(const ResultView& view, std::uint32_t point, TableWriter* out) {
  const CheckResult* check = FindCheck(view.result.checks, point);
  if (check == nullptr) {
    out->Empty(7);
    return;
  }
  for (Eigen::Index k = 0; k < 3; ++k) out->Number(check->error_enu_m[k]);
  out->Number(check->chi_square);
  for (Eigen::Index k = 0; k < 3; ++k) out->Number(check->sigma_enu_m[k]);
}

void WriteWithFixedPaths(const PointResults& points,
                         double factor,
                         std::size_t i,
                         TableWriter* out) {
  if (points.fixed_path_covariance_m2.empty()) {
    out->Empty(4);
    return;
  }
  const SymmetricEnu& c = points.fixed_path_covariance_m2[i];
  for (std::size_t k = 0; k < 3; ++k) out->Number(std::sqrt(factor * c[k]));
  out->Number(factor * c[3]);
}

void WriteLeberl(const PointResults& points, std::size_t i, TableWriter* out) {
  if (points.sigma_leberl_across_m.empty()) {
    out->Empty(5);
    return;
  }
  out->Number(points.sigma_leberl_across_m[i]).Number(points.sigma_leberl_up_m[i]);
  out->Number(points.sigma_leberl_path_across_m[i]).Number(points.sigma_leberl_path_up_m[i]);
  out->Number(points.leberl_across_azimuth_rad[i] * kDegPerRad);
}

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
                  TableWriter* out) {
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

void WriteVector(const Eigen::Vector3d& v, double factor, TableWriter* out) {
  for (Eigen::Index k = 0; k < 3; ++k) out->Number(factor * v[k]);
}

void WritePointRow(const ResultView& view, std::uint32_t i, TableWriter* out) {
  const PointResults& points = view.result.points;
  const bool geocentric = view.block.frame.kind() == FrameKind::kGeocentric;
  out->Id(view.block.points.ids[i], i).Text(NameOf(view.block.points.role[i]));
  out->Text(NameOf(points.status[i])).Integer(points.looks[i]);
  const Eigen::Vector3d& p = points.position_m[i];
  const bool known = p.allFinite();
  if (known) {
    out->Number(p.x()).Number(p.y()).Number(p.z());
  } else {
    out->Empty(3);
  }
  if (known && geocentric) {
    const Geodetic place = view.block.frame.GeodeticFromFrame(p);
    out->Number(place.lat_rad * kDegPerRad).Number(place.lon_rad * kDegPerRad).Number(place.h_m);
  } else {
    out->Empty(3);
  }
  if (points.covariance_m2.empty()) {
    out->Empty(6);
  } else {
    const SymmetricEnu& c = points.covariance_m2[i];
    for (std::size_t k = 0; k < 3; ++k) out->Number(std::sqrt(view.factor * c[k]));
    for (std::size_t k = 3; k < 6; ++k) out->Number(view.factor * c[k]);
  }
  out->Number(points.intersection_rad.empty() ? kNotGiven
                                              : points.intersection_rad[i] * kDegPerRad);
  WriteLeberl(points, i, out);
  out->Number(points.redundancy.empty() ? kNotGiven : points.redundancy[i]);
  WriteCheck(view, i, out);
  WriteWithFixedPaths(points, view.factor, i, out);
  out->Text(points.reason.empty() ? std::string_view() : points.reason[i]);
  out->EndRow();
}

}  // namespace

const char* NameOf(PointRole role) {
  switch (role) {
    case PointRole::kTie:
      return "tie";
    case PointRole::kControl:
      return "control";
    case PointRole::kCheck:
      return "check";
  }
  return "";
}

const char* NameOf(SelectionTest test) {
  switch (test) {
    case SelectionTest::kScore:
      return "score";
    case SelectionTest::kWald:
      return "wald";
    case SelectionTest::kNotTried:
      return "";
  }
  return "";
}

void WritePointTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("points", kResultPointColumns);
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      WritePointRow(view, static_cast<std::uint32_t>(i), out);
    }
  };
  WriteRows(view.result.points.status.size(), table->rows_of_part(), table.get(), write);
  table->Commit();
}

void WriteParameterTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("passes", kParameterColumns);
  TableWriter& out = *table;
  const std::vector<PriorTest> priors = TestsOfPriors(view.result);
  for (std::size_t i = 0; i < priors.size(); ++i) {
    const ParameterResult& parameter = view.result.parameters[i];
    ParameterResult scaled = parameter;
    scaled.sigma *= std::sqrt(view.factor);
    out.Text(parameter.owner).Text(parameter.name).Text(parameter.unit).Number(parameter.value);
    out.Number(scaled.sigma).Number(parameter.prior_sigma).Number(scaled.significance_1());
    out.Text(parameter.kept);
    out.Number(priors[i].redundancy_1).Number(priors[i].w_1).EndRow();
  }
  out.Commit();
}

void WriteSelectionTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("selection", kSelectionColumns);
  TableWriter& out = *table;
  for (const CandidateResult& candidate : view.result.selection.candidates) {
    out.Text(candidate.name).Text(candidate.passes);
    out.Integer(candidate.parameters).Text(NameOf(candidate.test));
    out.Number(candidate.statistic_1).Number(candidate.f_1).Number(candidate.probability_1);
    out.Number(candidate.delta_bic_1);
    // An infinite condition has no number; the reason says what it means.
    out.Number(std::isfinite(candidate.condition_1) ? candidate.condition_1 : kNotGiven);
    out.Number(candidate.posterior_prior_1);
    out.Text(candidate.kept ? "kept" : "dropped").Text(candidate.reason);
    if (candidate.step > 0) {
      out.Integer(candidate.step);
    } else {
      out.Empty();
    }
    out.EndRow();
  }
  out.Commit();
}

void WriteSimplificationTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("simplifications", kSimplificationColumns);
  TableWriter& out = *table;
  for (const SimplificationBound& bound : view.result.selection.simplifications) {
    out.Text(bound.name).Number(bound.bound_m).Number(bound.sigma_m).Number(bound.fraction_1);
    // Measured gains are not written: they would differ from run to run.
    out.Integer(bound.allowed ? 1 : 0).Integer(bound.taken ? 1 : 0).Text(bound.verdict).EndRow();
  }
  out.Commit();
}

void WriteParameterCovariance(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("passes_covariance", kParameterCovarianceColumns);
  const std::vector<ParameterCovariance>& entries = view.result.parameter_covariance;
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      const ParameterResult& a = view.result.parameters[entries[i].a];
      const ParameterResult& b = view.result.parameters[entries[i].b];
      out->Text(a.owner).Text(a.name).Text(b.owner).Text(b.name);
      out->Number(view.factor * entries[i].covariance).EndRow();
    }
  };
  WriteRows(entries.size(), table->rows_of_part(), table.get(), write);
  table->Commit();
}

void WritePairTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("pairs", kPairColumns);
  const std::vector<PairResult>& pairs = view.result.pairs;
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      const PairResult& pair = pairs[i];
      out->Id(view.block.points.ids[pair.a], pair.a).Id(view.block.points.ids[pair.b], pair.b);
      for (Eigen::Index k = 0; k < 3; ++k) out->Number(pair.difference_enu_m[k]);
      WriteCovariance(pair.covariance_m2, view.factor, out);
      out->Number(pair.sigma_leberl_across_m).Number(pair.sigma_leberl_up_m);
      out->Number(pair.sigma_leberl_path_across_m).Number(pair.sigma_leberl_path_up_m).EndRow();
    }
  };
  WriteRows(pairs.size(), table->rows_of_part(), table.get(), write);
  table->Commit();
}

void WriteResidualTable(TableSink* sink, const ResultView& view) {
  const PixelResiduals pixels(view);
  const auto table = sink->Open(
      "residuals",
      std::span(kResidualColumns)
          .first(kResidualColumns.size() - (pixels.present() ? 0 : kImageResidualColumns)));
  const Block& block = view.block;
  const LookResults& looks = view.result.looks;
  const BlunderSizes sizes(view.block, view.options, view.result, view.factor);
  const std::vector<std::uint32_t> finding = FindingOfLook(view);
  const auto write_look = [&](std::size_t i, std::size_t point, TableWriter* out) {
    out->Id(block.passes[block.looks.pass[i]].id, block.looks.pass[i]);
    out->Id(block.points.ids[point], static_cast<std::uint32_t>(point));
    out->Number(looks.range_residual_m.empty() ? kNotGiven : looks.range_residual_m[i]);
    out->Number(looks.azimuth_residual_m.empty() ? kNotGiven : looks.azimuth_residual_m[i]);
    WriteQuality(view, sizes, i, point, out);
    const bool rejected = looks.rejected.empty() ? block.looks.rejected(i) : looks.rejected[i] != 0;
    out->Number(looks.weight.empty() ? 1.0 : static_cast<double>(looks.weight[i]));
    out->Integer(rejected ? 1 : 0);
    out->Text(looks.reason.empty() ? "" : sarblock::NameOf(looks.reason[i]));
    if (finding[i] > 0) {
      out->Integer(finding[i]);
    } else {
      out->Empty();
    }
    pixels.Write(i, point, out);
    out->EndRow();
  };
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    ForLooks(block.looks, begin, end, [&](std::size_t i, std::size_t point) {
      write_look(i, point, out);
    });
  };
  WriteRows(block.looks.size(), table->rows_of_part(), table.get(), write);
  table->Commit();
}

void WriteControlTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("control_quality", kControlColumns);
  TableWriter& out = *table;
  const BlunderSizes sizes(view.block, view.options, view.result, view.factor);
  for (const ControlQuality& control : view.result.control_quality) {
    const BlunderSize size = sizes.OfControl(control);
    out.Id(view.block.points.ids[control.point], control.point);
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

void WriteStripTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("strips", kStripColumns);
  TableWriter& out = *table;
  for (const StripStation& station : view.result.strips) {
    const Pass& pass = view.block.passes[station.pass];
    out.Id(pass.id, station.pass).Text(pass.side == LookSide::kLeft ? "left" : "right");
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

namespace {

// e_d as a time over the line interval. The nominal path serves: a correction of 10 m changes the
// rate by a hundred-thousandth.
double LineResidual(const Block& block,
                    std::size_t look,
                    const Eigen::Vector3d& p_m,
                    double azimuth_residual_m) {
  const Pass& pass = block.passes[block.looks.pass[look]];
  const auto motion = pass.path.At(block.looks.time_s[look]);
  if (!motion) return kNotGiven;
  const double rate_mps = EvaluateCone(*motion, p_m, block.ConeOf(look)).rate_mps;
  return azimuth_residual_m / -rate_mps / pass.image->line_interval_s;
}

}  // namespace

PixelResiduals::PixelResiduals(const ResultView& view) : view_(view) {
  present_ = std::any_of(view.block.passes.begin(), view.block.passes.end(), [](const Pass& pass) {
    return pass.image.has_value();
  });
}

void PixelResiduals::Write(std::size_t look, std::size_t point, TableWriter* out) const {
  if (!present_) return;
  const Block& block = view_.block;
  const LookResults& looks = view_.result.looks;
  const Pass& pass = block.passes[block.looks.pass[look]];
  if (!pass.image) {
    out->Empty(4);
    return;
  }
  const RadarCoordinates radar{block.looks.time_s[look], block.looks.range_m[look]};
  const auto image = ImageFromRadar(*pass.image, radar);
  out->Number(image ? image->line_px : kNotGiven).Number(image ? image->pixel_px : kNotGiven);
  if (looks.range_residual_m.empty() || std::isnan(looks.range_residual_m[look])) {
    out->Empty(2);
    return;
  }
  out->Number(LineResidual(
      block, look, view_.result.points.position_m[point], looks.azimuth_residual_m[look]));
  const auto pixel_m = SlantRangePerPixel_m(*pass.image, radar);
  out->Number(pixel_m ? looks.range_residual_m[look] / *pixel_m : kNotGiven);
}

}  // namespace sarblock
