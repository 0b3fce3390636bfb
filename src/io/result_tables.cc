// SPDX-License-Identifier: Apache-2.0
#include "result_tables.h"

#include "sarblock/core/units.h"

#include <cmath>

#include "adjust/held_covariance.h"
#include "csv_writer.h"
#include "testing/prior_quality.h"

namespace sarblock {
namespace {

void WriteCovariance(const SymmetricEnu& covariance_m2, double factor, CsvWriter* out) {
  for (const double element_m2 : covariance_m2) out->Number(factor * element_m2);
}

// Check points' errors by point; `next` walks result.checks, which is sorted by point.
void WriteCheck(const ResultView& view, std::uint32_t point, std::size_t* next, CsvWriter* out) {
  const std::vector<CheckResult>& checks = view.result.checks;
  while (*next < checks.size() && checks[*next].point < point) ++*next;
  if (*next == checks.size() || checks[*next].point != point) {
    out->Empty(7);
    return;
  }
  const CheckResult& check = checks[*next];
  for (Eigen::Index k = 0; k < 3; ++k) out->Number(check.error_enu_m[k]);
  out->Number(check.chi_square);
  const PointResults& points = view.result.points;
  const KnownPosition* known = view.block.points.FindKnown(point);
  if (points.covariance_m2.empty() || known == nullptr) {
    out->Empty(3);
    return;
  }
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    out->Number(known->held[axis] ? std::sqrt(view.factor * points.covariance_m2[point][axis] +
                                              known->covariance_enu_m2(k, k))
                                  : kNotGiven);
  }
}

void WriteHeld(const std::vector<SymmetricEnu>& held,
               double factor,
               std::size_t i,
               CsvWriter* out) {
  if (held.empty()) {
    out->Empty(4);
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) out->Number(std::sqrt(factor * held[i][k]));
  out->Number(factor * held[i][3]);
}

void WriteLeberl(const PointResults& points, std::size_t i, CsvWriter* out) {
  if (points.sigma_leberl_across_m.empty()) {
    out->Empty(5);
    return;
  }
  out->Number(points.sigma_leberl_across_m[i]).Number(points.sigma_leberl_up_m[i]);
  out->Number(points.sigma_leberl_path_across_m[i]).Number(points.sigma_leberl_path_up_m[i]);
  out->Number(points.leberl_across_azimuth_rad[i] * kDegPerRad);
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

void WritePointTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"point",
                 "role",
                 "status",
                 "looks",
                 "x_m",
                 "y_m",
                 "z_m",
                 "lat_deg",
                 "lon_deg",
                 "h_m",
                 "sigma_e_m",
                 "sigma_n_m",
                 "sigma_u_m",
                 "cov_en_m2",
                 "cov_eu_m2",
                 "cov_nu_m2",
                 "intersection_deg",
                 "sigma_leberl_across_m",
                 "sigma_leberl_up_m",
                 "sigma_leberl_path_across_m",
                 "sigma_leberl_path_up_m",
                 "leberl_across_azimuth_deg",
                 "redundancy",
                 "error_e_m",
                 "error_n_m",
                 "error_u_m",
                 "chi_square_3",
                 "error_sigma_e_m",
                 "error_sigma_n_m",
                 "error_sigma_u_m",
                 "sigma_held_e_m",
                 "sigma_held_n_m",
                 "sigma_held_u_m",
                 "cov_held_en_m2",
                 "reason"},
                view.context.compression);
  const PointResults& points = view.result.points;
  const bool geocentric = view.block.frame.kind() == FrameKind::kGeocentric;
  std::size_t next_check = 0;
  const std::vector<SymmetricEnu> held = HeldCovariances(view.block, view.options, view.result);
  for (std::uint32_t i = 0; i < points.status.size(); ++i) {
    out.Text(view.block.points.ids[i]).Text(NameOf(view.block.points.role[i]));
    out.Text(NameOf(points.status[i])).Integer(points.looks[i]);
    const Eigen::Vector3d& p = points.position_m[i];
    const bool known = p.allFinite();
    if (known) {
      out.Number(p.x()).Number(p.y()).Number(p.z());
    } else {
      out.Empty(3);
    }
    if (known && geocentric) {
      const Geodetic place = view.block.frame.GeodeticFromFrame(p);
      out.Number(place.lat_rad * kDegPerRad).Number(place.lon_rad * kDegPerRad).Number(place.h_m);
    } else {
      out.Empty(3);
    }
    if (points.covariance_m2.empty()) {
      out.Empty(6);
    } else {
      const SymmetricEnu& c = points.covariance_m2[i];
      for (std::size_t k = 0; k < 3; ++k) out.Number(std::sqrt(view.factor * c[k]));
      for (std::size_t k = 3; k < 6; ++k) out.Number(view.factor * c[k]);
    }
    out.Number(points.intersection_rad.empty() ? kNotGiven
                                               : points.intersection_rad[i] * kDegPerRad);
    WriteLeberl(points, i, &out);
    out.Number(points.redundancy.empty() ? kNotGiven : points.redundancy[i]);
    WriteCheck(view, i, &next_check, &out);
    WriteHeld(held, view.factor, i, &out);
    out.Text(points.reason.empty() ? std::string_view() : points.reason[i]);
    out.EndRow();
  }
  out.Commit();
}

void WriteParameterTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"pass",
                 "parameter",
                 "unit",
                 "value",
                 "sigma",
                 "prior_sigma",
                 "significance",
                 "kept",
                 "prior_redundancy",
                 "prior_w"},
                view.context.compression);
  for (const ParameterResult& parameter : view.result.parameters) {
    const double sigma = std::sqrt(view.factor) * parameter.sigma;
    out.Text(parameter.owner).Text(parameter.name).Text(parameter.unit).Number(parameter.value);
    out.Number(sigma).Number(parameter.prior_sigma);
    out.Number(sigma > 0.0 ? std::abs(parameter.value) / sigma : kNotGiven);
    out.Text(parameter.kept);
    const PriorTest prior = TestOfPrior(view.result, parameter);
    out.Number(prior.redundancy_1).Number(prior.w_1).EndRow();
  }
  out.Commit();
}

void WriteSelectionTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"candidate",
                 "passes",
                 "parameters",
                 "test",
                 "statistic",
                 "f",
                 "p",
                 "delta_bic",
                 "condition",
                 "posterior_prior",
                 "verdict",
                 "reason",
                 "step"},
                view.context.compression);
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

void WriteSimplificationTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"simplification", "bound_m", "sigma_m", "fraction", "allowed", "taken", "verdict"},
                view.context.compression);
  for (const SimplificationBound& bound : view.result.selection.simplifications) {
    out.Text(bound.name).Number(bound.bound_m).Number(bound.sigma_m).Number(bound.fraction_1);
    // Measured gains are not written: they would differ from run to run.
    out.Integer(bound.allowed ? 1 : 0).Integer(bound.taken ? 1 : 0).Text(bound.verdict).EndRow();
  }
  out.Commit();
}

void WriteParameterCovariance(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"pass_a", "parameter_a", "pass_b", "parameter_b", "covariance"},
                view.context.compression);
  for (const ParameterCovariance& entry : view.result.parameter_covariance) {
    const ParameterResult& a = view.result.parameters[entry.a];
    const ParameterResult& b = view.result.parameters[entry.b];
    out.Text(a.owner).Text(a.name).Text(b.owner).Text(b.name);
    out.Number(view.factor * entry.covariance).EndRow();
  }
  out.Commit();
}

void WritePairTable(const std::filesystem::path& file, const ResultView& view) {
  CsvWriter out(file,
                {"point_a",
                 "point_b",
                 "de_m",
                 "dn_m",
                 "du_m",
                 "cov_ee_m2",
                 "cov_nn_m2",
                 "cov_uu_m2",
                 "cov_en_m2",
                 "cov_eu_m2",
                 "cov_nu_m2",
                 "sigma_leberl_across_m",
                 "sigma_leberl_up_m",
                 "sigma_leberl_path_across_m",
                 "sigma_leberl_path_up_m"},
                view.context.compression);
  for (const PairResult& pair : view.result.pairs) {
    out.Text(view.block.points.ids[pair.a]).Text(view.block.points.ids[pair.b]);
    for (Eigen::Index k = 0; k < 3; ++k) out.Number(pair.difference_enu_m[k]);
    WriteCovariance(pair.covariance_m2, view.factor, &out);
    out.Number(pair.sigma_leberl_across_m).Number(pair.sigma_leberl_up_m);
    out.Number(pair.sigma_leberl_path_across_m).Number(pair.sigma_leberl_path_up_m).EndRow();
  }
  out.Commit();
}

}  // namespace sarblock
