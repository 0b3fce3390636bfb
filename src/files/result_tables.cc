// SPDX-License-Identifier: Apache-2.0
#include "result_tables.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "block_file.h"
#include "core/text.h"
#include "quality/assess.h"
#include "quality/covariance.h"
#include "tables/table.h"
#include <nlohmann/json.hpp>

namespace sarblock::files {
namespace {

using Triple = std::array<double, 3>;

/// Errors of a check point.
void WriteCheck(const ResultView& view, std::uint32_t point, NewRow* row) {
  constexpr const auto& kColumns = kResultPointColumns;
  const CheckResult* check = FindCheck(view.result.checks, point);
  if (check == nullptr) return;
  row->Numbers(kColumns("error_e_m", "error_n_m", "error_u_m"), check->error_enu_m);
  row->Number(kColumns("chi_square_3"), check->chi_square);
  row->Numbers(kColumns("error_sigma_e_m", "error_sigma_n_m", "error_sigma_u_m"),
               check->sigma_enu_m);
}

/// Square roots of the first three elements of a covariance.
Triple Sigmas(const SymmetricEnu& covariance_m2) {
  return {std::sqrt(covariance_m2[0]), std::sqrt(covariance_m2[1]), std::sqrt(covariance_m2[2])};
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
                  NewRow* row) {
  constexpr const auto& kColumns = kResidualColumns;
  const LookQuality& quality = view.result.quality;
  if (quality.empty()) return;
  const std::array<BlunderSize, 2> size = sizes.LookSizes(look, point);
  const auto write = [&](std::size_t k, const std::array<std::size_t, 5>& columns) {
    const double tests = static_cast<double>(quality.w[k][look]);
    row->Numbers(columns,
                 std::array{static_cast<double>(quality.redundancy[k][look]),
                            tests,
                            TauOf(tests, view.result),
                            size[k].detectable_m,
                            size[k].influence_m});
  };
  write(0,
        kColumns("range_redundancy", "range_w", "range_tau", "range_mdb_m", "range_influence_m"));
  write(1,
        kColumns("azimuth_redundancy",
                 "azimuth_w",
                 "azimuth_tau",
                 "azimuth_mdb_m",
                 "azimuth_influence_m"));
}

void WritePointRow(const ResultView& view, std::uint32_t i, Batch* batch) {
  constexpr const auto& kColumns = kResultPointColumns;
  const PointResults& points = view.result.points;
  NewRow row(batch);
  row.Id(kColumns("point"), view.block.points.ids, i);
  row.Text(kColumns("role"), NameOf(view.block.points.role[i]));
  row.Text(kColumns("status"), NameOf(points.status[i]));
  row.Integer(kColumns("looks"), points.looks[i]);
  const Eigen::Vector3d& p_m = points.position_m[i];
  if (p_m.allFinite()) {
    row.Numbers(kColumns("x_m", "y_m", "z_m"), p_m);
    if (view.block.frame.kind() == FrameKind::kGeocentric) {
      const Geodetic place = view.block.frame.GeodeticFromFrame(p_m);
      row.Numbers(kColumns("lat_deg", "lon_deg", "h_m"),
                  Triple{place.lat_rad * kDegPerRad, place.lon_rad * kDegPerRad, place.h_m});
    }
  }
  if (!points.covariance_m2.empty()) {
    const SymmetricEnu& c = points.covariance_m2[i];
    row.Numbers(kColumns("sigma_e_m", "sigma_n_m", "sigma_u_m"), Sigmas(c));
    row.Numbers(kColumns("cov_en_m2", "cov_eu_m2", "cov_nu_m2"), Triple{c[3], c[4], c[5]});
  }
  for (const auto& figure : kPointFigures) {
    const std::vector<double>& values = points.*figure.member;
    if (!values.empty()) row.Number(figure.column, values[i] * figure.written);
  }
  WriteCheck(view, i, &row);
  if (!points.fixed_path_covariance_m2.empty()) {
    const SymmetricEnu& c = points.fixed_path_covariance_m2[i];
    row.Numbers(kColumns("sigma_held_e_m", "sigma_held_n_m", "sigma_held_u_m"), Sigmas(c));
    row.Number(kColumns("cov_held_en_m2"), c[3]);
  }
  if (!points.reason.empty()) row.Text(kColumns("reason"), points.reason[i]);
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
  WriteEach(view.result.points.status.size(), table.get(), [&](std::size_t i, Batch* batch) {
    WritePointRow(view, static_cast<std::uint32_t>(i), batch);
  });
  table->Commit();
}

void WriteParameterTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kParameterColumns;
  const auto table = sink->Open("passes", kColumns);
  const std::vector<PriorTest> priors = TestsOfPriors(view.result);
  WriteEach(priors.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const ParameterResult& parameter = view.result.parameters[i];
    NewRow(batch)
        .Text(kColumns("pass"), parameter.owner)
        .Text(kColumns("parameter"), parameter.name)
        .Text(kColumns("unit"), parameter.unit)
        .Number(kColumns("value"), parameter.value)
        .Number(kColumns("sigma"), parameter.sigma)
        .Number(kColumns("prior_sigma"), parameter.prior_sigma)
        .Number(kColumns("significance"), parameter.significance())
        .Text(kColumns("kept"), parameter.kept)
        .Number(kColumns("prior_redundancy"), priors[i].redundancy)
        .Number(kColumns("prior_w"), priors[i].w);
  });
  table->Commit();
}

void WriteSelectionTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kSelectionColumns;
  const auto table = sink->Open("selection", kColumns);
  const std::vector<CandidateResult>& candidates = view.result.selection.candidates;
  WriteEach(candidates.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const CandidateResult& candidate = candidates[i];
    NewRow row(batch);
    row.Text(kColumns("candidate"), candidate.name)
        .Text(kColumns("passes"), candidate.passes)
        .Integer(kColumns("parameters"), candidate.parameters)
        .Text(kColumns("test"), NameOf(candidate.test))
        .Number(kColumns("statistic"), candidate.statistic)
        .Number(kColumns("f"), candidate.f)
        .Number(kColumns("p"), candidate.probability)
        .Number(kColumns("delta_bic"), candidate.delta_bic)
        .Number(kColumns("posterior_prior"), candidate.posterior_prior)
        .Text(kColumns("verdict"), candidate.verdict())
        .Text(kColumns("reason"), candidate.reason);
    // An infinite condition has no number; the reason says what it means.
    if (std::isfinite(candidate.condition)) {
      row.Number(kColumns("condition"), candidate.condition);
    }
    if (candidate.step > 0) row.Integer(kColumns("step"), candidate.step);
  });
  table->Commit();
}

void WriteSimplificationTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kSimplificationColumns;
  const auto table = sink->Open("simplifications", kColumns);
  const std::vector<SimplificationBound>& bounds = view.result.selection.simplifications;
  WriteEach(bounds.size(), table.get(), [&](std::size_t i, Batch* batch) {
    // Measured gains are not written: they would differ from run to run.
    NewRow(batch)
        .Text(kColumns("simplification"), bounds[i].name)
        .Number(kColumns("bound_m"), bounds[i].bound_m)
        .Number(kColumns("sigma_m"), bounds[i].sigma_m)
        .Number(kColumns("fraction"), bounds[i].fraction)
        .Integer(kColumns("allowed"), bounds[i].allowed ? 1 : 0)
        .Integer(kColumns("taken"), bounds[i].taken ? 1 : 0)
        .Text(kColumns("verdict"), bounds[i].verdict);
  });
  table->Commit();
}

void WriteParameterCovariance(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kParameterCovarianceColumns;
  const auto table = sink->Open("passes_covariance", kColumns);
  const std::vector<ParameterCovariance>& entries = view.result.parameter_covariance;
  WriteEach(entries.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const ParameterResult& a = view.result.parameters[entries[i].a];
    const ParameterResult& b = view.result.parameters[entries[i].b];
    NewRow(batch)
        .Text(kColumns("pass_a"), a.owner)
        .Text(kColumns("parameter_a"), a.name)
        .Text(kColumns("pass_b"), b.owner)
        .Text(kColumns("parameter_b"), b.name)
        .Number(kColumns("covariance"), entries[i].covariance);
  });
  table->Commit();
}

void WritePairTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kPairColumns;
  const auto table = sink->Open("pairs", kColumns);
  const std::vector<PairResult>& pairs = view.result.pairs;
  WriteEach(pairs.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const PairResult& pair = pairs[i];
    NewRow row(batch);
    row.Id(kColumns("point_a"), view.block.points.ids, pair.a)
        .Id(kColumns("point_b"), view.block.points.ids, pair.b)
        .Numbers(kColumns("de_m", "dn_m", "du_m"), pair.difference_enu_m)
        .Numbers(kPairCovariance, pair.covariance_m2);
    for (const auto& figure : kPairFigures) row.Number(figure.column, pair.*figure.member);
  });
  table->Commit();
}

void WriteControlTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kControlColumns;
  const auto table = sink->Open("control_quality", kColumns);
  const BlunderSizes sizes(view.block, view.options, view.result, view.result.posterior_factor);
  const std::vector<ControlQuality>& qualities = view.result.control_quality;
  WriteEach(qualities.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const ControlQuality& control = qualities[i];
    const BlunderSize size = sizes.ControlSize(control);
    NewRow(batch)
        .Id(kColumns("point"), view.block.points.ids, control.point)
        .Text(kColumns("component"), kComponents[static_cast<std::size_t>(control.component)])
        .Number(kColumns("residual_m"), control.residual_m)
        .Number(kColumns("sigma_m"), size.sigma_m)
        .Number(kColumns("redundancy"), control.redundancy)
        .Number(kColumns("w"), control.w)
        .Number(kColumns("tau"), TauOf(control.w, view.result))
        .Number(kColumns("mdb_m"), size.detectable_m)
        .Number(kColumns("influence_m"), size.influence_m);
  });
  table->Commit();
}

void WriteStripTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kStripColumns;
  const auto table = sink->Open("strips", kColumns);
  const std::vector<StripStation>& strips = view.result.strips;
  WriteEach(strips.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const StripStation& station = strips[i];
    const bool left = view.block.passes[station.pass].side == LookSide::kLeft;
    const Eigen::Vector3d& sigma_m = station.correction_sigma_m;
    NewRow(batch)
        .Id(kColumns("pass"), view.pass_ids, station.pass)
        .Text(kColumns("look"), left ? "left" : "right")
        .Number(kColumns("time_s"), station.time_s)
        .Number(kColumns("strip_time"), station.strip_time)
        .Numbers(kColumns("x_m", "y_m", "z_m"), station.antenna_m)
        .Numbers(kColumns("near_x_m", "near_y_m", "near_z_m"), station.near_m)
        .Numbers(kColumns("far_x_m", "far_y_m", "far_z_m"), station.far_m)
        .Numbers(kColumns("correction_along_m", "correction_across_m", "correction_up_m"),
                 station.correction_m)
        .Numbers(kColumns("sigma_along_m", "sigma_across_m", "sigma_up_m"), sigma_m);
  });
  table->Commit();
}

namespace {

/// Where a look of a pass with an image was measured in it, and its residuals as steps of the
/// image, computed minus measured. docs/theory/image_coordinates.md, eq. (5).
void WritePixelResiduals(const ResultView& view, std::size_t look, std::size_t point, NewRow* row) {
  constexpr const auto& kColumns = kResidualColumns;
  const Block& block = view.block;
  const LookResults& looks = view.result.looks;
  const Pass& pass = block.passes[block.looks.pass[look]];
  if (!pass.image) return;
  const RadarCoordinates radar = block.Measured(look);
  if (const auto image = ImageFromRadar(*pass.image, radar)) {
    row->Number(kColumns("line"), image->line_px).Number(kColumns("pixel"), image->pixel_px);
  }
  if (looks.range_residual_m.empty() || std::isnan(looks.range_residual_m[look])) return;
  const auto [pixels, lines] =
      InRaster(block,
               look,
               view.result.points.position_m[point],
               {looks.range_residual_m[look], looks.azimuth_residual_m[look]});
  row->Number(kColumns("line_residual_px"), lines).Number(kColumns("pixel_residual_px"), pixels);
}

}  // namespace

void WriteResidualTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kResidualColumns;
  const Block& block = view.block;
  const bool image = std::any_of(block.passes.begin(), block.passes.end(), [](const Pass& pass) {
    return pass.image.has_value();
  });
  constexpr std::array<std::string_view, 4> kOfImages{
      "line", "pixel", "line_residual_px", "pixel_residual_px"};
  const Reductions& reductions = view.result.reductions;
  std::vector<std::string_view> left_out;
  if (!image) left_out.assign(kOfImages.begin(), kOfImages.end());
  if (reductions.range_m.empty()) left_out.emplace_back("reduction_range_m");
  if (reductions.time_s.empty()) left_out.emplace_back("reduction_time_s");
  const auto table = sink->Open("residuals", kColumns, left_out);
  const LookResults& looks = view.result.looks;
  const BlunderSizes sizes(view.block, view.options, view.result, view.result.posterior_factor);
  const std::vector<std::uint32_t> finding = FindingOfLook(view);
  const auto write_look = [&](std::size_t i, std::size_t point, Batch* batch) {
    NewRow row(batch);
    row.Id(kColumns("pass"), view.pass_ids, block.looks.pass[i]);
    row.Id(kColumns("point"), block.points.ids, static_cast<std::uint32_t>(point));
    if (!looks.range_residual_m.empty()) {
      row.Number(kColumns("range_residual_m"), looks.range_residual_m[i]);
    }
    if (!looks.azimuth_residual_m.empty()) {
      row.Number(kColumns("azimuth_residual_m"), looks.azimuth_residual_m[i]);
    }
    WriteQuality(view, sizes, i, point, &row);
    const bool rejected = looks.rejected.empty() ? block.looks.rejected(i) : looks.rejected[i] != 0;
    row.Number(kColumns("weight"),
               looks.weight.empty() ? 1.0 : static_cast<double>(looks.weight[i]));
    row.Integer(kColumns("rejected"), rejected ? 1 : 0);
    if (!looks.reason.empty()) row.Text(kColumns("reason"), sarblock::NameOf(looks.reason[i]));
    if (finding[i] > 0) row.Integer(kColumns("finding"), finding[i]);
    WritePixelResiduals(view, i, point, &row);
    if (!reductions.range_m.empty()) {
      row.Number(kColumns("reduction_range_m"), reductions.range_m[i]);
    }
    if (!reductions.time_s.empty()) {
      row.Number(kColumns("reduction_time_s"), reductions.time_s[i]);
    }
  };
  WriteRows(block.looks.size(), table.get(), [&](std::size_t begin, std::size_t end, Batch* batch) {
    ForLooks(block.looks, begin, end, [&](std::size_t i, std::size_t point) {
      write_look(i, point, batch);
    });
  });
  table->Commit();
}

namespace {

// Fixed notation: 12 decimals of a degree are 0.1 micrometre, so that small ellipses keep shape.
/// Twelve decimals, correctly rounded; finite, |value| at most 540. By an integer of units of 1e-12
/// degrees, below 2^53: a polygon is 74 of these, and std::to_chars takes six times as long.
void AppendDegrees(double value_deg, std::string* text) {
  constexpr double kUnits = 1e12;
  const double size_deg = std::abs(value_deg), product = size_deg * kUnits;
  auto units = static_cast<std::uint64_t>(std::llround(product));
  // What the product was rounded by decides where it seems half a unit off.
  const double left = (product - static_cast<double>(units)) + std::fma(size_deg, kUnits, -product);
  if (left > 0.5) ++units;
  if (left < -0.5) --units;
  constexpr auto kWhole = static_cast<std::uint64_t>(kUnits);
  std::array<char, 24> digits;
  char* at = digits.data();
  if (std::signbit(value_deg)) *at++ = '-';
  char* const last = digits.data() + digits.size();
  at = std::to_chars(at, last, units / kWhole).ptr;
  char* const point = at;  // the place of a leading 1 that keeps the zeros behind it
  at = std::to_chars(at, last, kWhole + units % kWhole).ptr;
  *point = '.';
  text->append(digits.data(), at);
}

void AppendProperty(const char* key, double value, std::string* text) {
  text->append(",\"").append(key).append("\":");
  if (std::isfinite(value)) {
    AppendNumber(value, text);
  } else {
    text->append("null");
  }
}

std::string JsonText(std::string_view text) {
  return nlohmann::json(std::string(text))
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void AppendPlace(const Geodetic& place, std::string* text) {
  AppendDegrees(place.lon_rad * kDegPerRad, text);
  text->append(",");
  AppendDegrees(place.lat_rad * kDegPerRad, text);
}

/// The features as text, each with a comma and a new line before it.
class Features {
 public:
  explicit Features(const GeoJsonContent& content) : content_(content) {
    if (content.confidence) scale_ = EllipseScale(*content.confidence);
    ellipse_text_ = content.confidence
                        ? NumberText(100.0 * *content.confidence) + " percent, true size"
                        : "1 sigma, true size";
  }

  void Point(std::size_t i, std::string* text) const {
    const PointResults& points = content_.points;
    const Eigen::Vector3d& p_m = points.position_m[i];
    if (!IsSolved(points.status[i]) || !p_m.allFinite()) return;
    const Geodetic place = content_.frame.GeodeticFromFrame(p_m);
    const std::string id = JsonText(content_.ids[i]);
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text->append(",\"role\":\"").append(NameOf(content_.role[i]));
    text->append("\",\"status\":\"").append(NameOf(points.status[i])).append("\"");
    text->append(",\"looks\":").append(std::to_string(points.looks[i]));
    const bool sigmas = !points.covariance_m2.empty() && std::isfinite(points.covariance_m2[i][0]);
    ErrorEllipse ellipse;
    if (sigmas) {
      const SymmetricEnu& c = points.covariance_m2[i];
      ellipse = EllipseOf(c, scale_);
      AppendProperty("sigma_e_m", std::sqrt(c[0]), text);
      AppendProperty("sigma_n_m", std::sqrt(c[1]), text);
      AppendProperty("sigma_u_m", std::sqrt(c[2]), text);
      AppendEllipse(ellipse, text);
    }
    Check(i, text);
    text->append("},\"geometry\":{\"type\":\"Point\",\"coordinates\":[");
    AppendPlace(place, text);
    text->append(",");
    AppendNumber(place.h_m, text);
    text->append("]}}");
    if (sigmas && content_.polygons && std::isfinite(ellipse.major_m))
      Polygon(id, p_m, ellipse, text);
  }

  void Path(const std::string& id, const FlightPath& path, std::string* text) const {
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"pass\":").append(JsonText(id));
    AppendProperty("start_s", path.start_s(), text);
    AppendProperty("end_s", path.end_s(), text);
    text->append("},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[");
    const char* separator = "[";
    for (const StateVector& state : path.states()) {
      const Geodetic place = content_.frame.GeodeticFromFrame(state.position_m);
      text->append(separator);
      AppendPlace(place, text);
      text->append(",");
      AppendNumber(place.h_m, text);
      text->append("]");
      separator = ",[";
    }
    text->append("]}}");
  }

 private:
  static void AppendEllipse(const ErrorEllipse& ellipse, std::string* text) {
    AppendProperty("ellipse_major_m", ellipse.major_m, text);
    AppendProperty("ellipse_minor_m", ellipse.minor_m, text);
    AppendProperty("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad, text);
  }
  // `checks` are sorted by point.
  void Check(std::size_t i, std::string* text) const {
    if (content_.checks == nullptr) return;
    const CheckResult* check = FindCheck(*content_.checks, static_cast<std::uint32_t>(i));
    if (check == nullptr) return;
    AppendProperty("error_e_m", check->error_enu_m.x(), text);
    AppendProperty("error_n_m", check->error_enu_m.y(), text);
    AppendProperty("error_u_m", check->error_enu_m.z(), text);
  }
  void Polygon(const std::string& id,
               const Eigen::Vector3d& p_m,
               const ErrorEllipse& ellipse,
               std::string* text) const {
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text->append(",\"ellipse\":\"").append(ellipse_text_).append("\"");
    AppendEllipse(ellipse, text);
    text->append("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
    const auto ring = EllipseRing(content_.frame, p_m, ellipse);
    for (const Geodetic& corner : ring) {
      text->append("[");
      AppendPlace(corner, text);
      text->append("],");
    }
    text->append("[");
    AppendPlace(ring[0], text);
    text->append("]]]}}");
  }

  const GeoJsonContent& content_;
  double scale_ = 1.0;
  std::string ellipse_text_;
};

}  // namespace

const CheckResult* FindCheck(const std::vector<CheckResult>& checks, std::uint32_t point) {
  const auto found = std::lower_bound(
      checks.begin(), checks.end(), point, [](const CheckResult& check, std::uint32_t wanted) {
        return check.point < wanted;
      });
  return found == checks.end() || found->point != point ? nullptr : &*found;
}

namespace {

constexpr std::size_t kPointsAtOnce = 2048;  // with polygons some megabytes

}  // namespace

void WriteGeoJson(const std::filesystem::path& file, const GeoJsonContent& content) {
  const Features features(content);
  AtomicFile out(file);
  out.Write("{\"type\":\"FeatureCollection\",\"generator\":\"sarblock\",\"name\":" +
            JsonText(content.name) + ",\"features\":[");
  bool first = true;
  const auto write = [&](std::string* text) {  // the first feature has no comma before it
    out.Write(std::string_view(*text).substr(first && !text->empty() ? 1 : 0));
    first &= text->empty();
    text->clear();
  };
  MakeInOrder<std::string>(
      content.points.status.size(),
      kPointsAtOnce,
      [&](std::size_t begin, std::size_t end, std::string* text) {
        for (std::size_t i = begin; i < end; ++i) features.Point(i, text);
      },
      write);
  std::string text;
  for (const auto& [id, path] : content.paths) {
    features.Path(id, *path, &text);
    write(&text);
  }
  out.Write("\n]}\n");
  out.Commit();
}

void WriteMonteCarloTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kMonteCarloColumns;
  const auto table = sink->Open("montecarlo", kColumns);
  const MonteCarloReport& report = *view.result.montecarlo;
  WriteEach(report.square.size(), table.get(), [&](std::size_t point, Batch* batch) {
    if (report.runs == 0 || std::isnan(report.square[point])) return;
    const std::array<double, 6>& sample_m2 = report.sample_m2[point];
    const SymmetricEnu& rigorous_m2 = view.result.points.covariance_m2[point];
    NewRow row(batch);
    row.Id(kColumns("point"), view.block.points.ids, static_cast<std::uint32_t>(point));
    std::array<double, 3> sample_m{}, rigorous_m{}, ratio{}, coverage{};
    for (std::size_t i = 0; i < 3; ++i) {
      sample_m[i] = std::sqrt(sample_m2[i]);
      rigorous_m[i] = std::sqrt(rigorous_m2[i]);
      ratio[i] = std::sqrt(sample_m2[i] / rigorous_m2[i]);
      coverage[i] = static_cast<double>(report.inside[i][point]) / report.runs;
    }
    row.Numbers(kColumns("sample_sigma_e_m", "sample_sigma_n_m", "sample_sigma_u_m"), sample_m);
    row.Numbers(kColumns("sigma_e_m", "sigma_n_m", "sigma_u_m"), rigorous_m);
    row.Numbers(kColumns("ratio_e", "ratio_n", "ratio_u"), ratio);
    row.Number(kColumns("normalised_square"), report.square[point]);
    row.Numbers(kColumns("coverage_50", "coverage_90", "coverage_99"), coverage);
  });
  table->Commit();
}

}  // namespace sarblock::files
