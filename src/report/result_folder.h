// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"
#include "sarblock/core/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sarblock {

/// What a report reads of a result folder (docs/formats.md), as plain data. Numbers that the files
/// do not give are NaN (here kAbsent); tables that are not there are empty.
inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

/// A test of the variance factor.
struct GlobalTestFigures {
  double sigma0_squared = kAbsent;
  double redundancy = kAbsent;
  double lower = kAbsent, upper = kAbsent;  ///< acceptance of sigma0_squared times redundancy
  double level = 0.95;
  bool passed = false;
  [[nodiscard]] bool given() const { return sigma0_squared == sigma0_squared && lower == lower; }
};

struct CheckFigures {
  double points_1 = 0.0, components_1 = 0.0;
  double error_ratio_1 = kAbsent;  ///< errors in units of what was predicted
  double points_outside_1 = 0.0;
  double level = 0.95;
  bool realistic = false;
  std::string says;  ///< a sentence
};

struct TestFigures {
  double alpha_1 = kAbsent, power_1 = kAbsent, critical_w_1 = kAbsent, delta0_1 = kAbsent;
  double tests_1 = 0.0, expected_above_1 = kAbsent, not_localisable_1 = 0.0;
  std::array<double, 3> above_1{};              ///< range, azimuth, control
  std::array<double, 2> median_redundancy_1{};  ///< range, azimuth
};

struct FindingFigures {
  int round = 0;
  std::string point, passes, component, action, note;
  double w_1 = kAbsent;
  bool located = false;
};

struct VarianceFigures {
  std::string group, component, unit, note;
  bool estimated = false;
  double looks_1 = 0.0, redundancy = kAbsent, factor_1 = kAbsent, factor_sigma_1 = kAbsent;
  double sigma_before = kAbsent, sigma_after = kAbsent, sigma_after_sigma = kAbsent;  ///< in `unit`
};

struct RunFigures {
  std::string name;
  double expected_1 = kAbsent, mean_1 = kAbsent, lower = kAbsent, upper = kAbsent;
  bool agrees = false;
};
struct MonteCarloFigures {
  double runs_1 = 0.0, failed_1 = 0.0;
  std::string seed, verdict;
  std::vector<RunFigures> rows;
};

struct StageFigures {
  std::string name;
  double wall_s = 0.0, peak_mib = 0.0;
};

struct InputFigures {
  std::string file, sha256;
  double bytes_1 = 0.0;
};

/// summary.json.
struct ReportSummary {
  std::string version, command, block, status, covariance;
  bool accepted = false;
  bool geocentric = false;
  std::string ellipsoid;
  double a_m = kAbsent, flattening = kAbsent;
  std::vector<std::pair<std::string, double>> counts;  ///< as they stand there, in their order
  std::vector<std::pair<std::string, double>> point_status;
  double iterations_1 = kAbsent, initial_cost = kAbsent, final_cost = kAbsent;
  double remaining_step = kAbsent, condition = kAbsent;
  bool scaled_by_posterior = false;
  GlobalTestFigures test;
  std::optional<CheckFigures> checks;
  std::optional<TestFigures> tests;
  std::optional<double> snooping_rounds;
  std::vector<FindingFigures> findings;
  std::optional<GlobalTestFigures> test_before;  ///< before variance components were estimated
  std::vector<VarianceFigures> variances;
  std::optional<MonteCarloFigures> montecarlo;
  std::string selected_model;  ///< correction tables chosen, as TOML
  bool selection_settled = true;
  std::vector<StageFigures> stages;
  std::vector<std::string> warnings;
  std::vector<InputFigures> inputs;
  std::vector<std::pair<std::string, std::string>> configuration;  ///< dotted keys, JSON values

  [[nodiscard]] double Count(const std::string& name) const;  ///< 0 where not given
};

enum class ReportRole : std::uint8_t { kTie, kControl, kCheck };

/// points.csv in flat arrays. Triples are east, north, up.
struct ReportPoints {
  IdTable ids;
  std::vector<ReportRole> role;
  std::vector<std::uint8_t> solved;
  std::vector<std::array<double, 3>> position_m;  ///< frame axes
  std::vector<std::array<float, 3>> sigma_m;
  std::vector<float> cov_en_m2;
  std::vector<std::array<float, 3>> sigma_held_m;  ///< paths known exactly
  std::vector<float> cov_held_en_m2;
  /// Leberl (1979): across and up by range noise, then across and up by the priors of the paths.
  std::vector<std::array<float, 4>> leberl_m;
  std::vector<float> leberl_azimuth_deg;
  std::vector<float> intersection_deg;
  std::vector<float> redundancy;
  std::vector<std::uint16_t> looks;
  /// Of check points only, in the order of the table.
  struct Check {
    std::uint32_t point = 0;
    std::array<double, 3> error_m{}, sigma_m{};  ///< error, its standard deviation
    double chi_square = kAbsent;
  };
  std::vector<Check> checks;
  /// Points not solved: status and reason, at most kMostUnsolved; all are in `unsolved_count`.
  struct Unsolved {
    std::uint32_t point = 0;
    std::string status, reason;
  };
  std::vector<Unsolved> unsolved;
  std::size_t unsolved_count = 0;
  static constexpr std::size_t kMostUnsolved = 50;
  [[nodiscard]] std::size_t size() const { return role.size(); }
};

/// passes.csv.
struct ReportParameter {
  std::string pass, name, unit, kept;
  double value = 0.0, sigma = kAbsent, prior_sigma = kAbsent, significance = kAbsent;
};

/// Two parameters that the result cannot tell apart well.
struct ReportCorrelation {
  std::uint32_t a = 0, b = 0;  ///< indices into parameters
  double correlation_1 = 0.0;
};

/// One observation of residuals.csv among those with the largest |w|.
struct ReportLook {
  std::string pass, point, reason;
  bool azimuth = false;
  double residual_m = kAbsent, redundancy = kAbsent, w_1 = kAbsent, tau_1 = kAbsent;
  double mdb_m = kAbsent, influence_m = kAbsent, weight = 1.0;
  bool rejected = false;
};

/// residuals.csv: what a report shows of it.
struct ReportLooks {
  std::array<std::vector<float>, 2> w_1;  ///< range, azimuth; looks in use that have one
  std::array<std::vector<float>, 2> residual_m, redundancy_1, mdb_m, influence_m;
  std::size_t count = 0, rejected = 0;
  std::vector<std::pair<std::string, std::size_t>> rejected_by_reason;
  std::vector<ReportLook> worst;     ///< largest |w| first, at most kMostWorst
  std::vector<ReportLook> left_out;  ///< rejected ones, largest residual first, at most kMostWorst
  static constexpr std::size_t kMostWorst = 25;
};

/// control_quality.csv.
struct ReportControl {
  std::string point;
  int component = 0;  ///< east, north, up
  double residual_m = kAbsent, sigma_m = kAbsent, redundancy = kAbsent, w_1 = kAbsent;
  double mdb_m = kAbsent, influence_m = kAbsent;
};

/// strips.csv: the stations of one pass.
struct ReportStrip {
  std::string pass;
  bool left = true;
  std::vector<double> time_s, strip_time_1;
  std::vector<std::array<double, 3>> antenna_m, near_m, far_m;
  std::vector<std::array<double, 3>> correction_m, correction_sigma_m;  ///< along, across, up
};

/// pairs.csv in short: medians of the standard deviations of differences.
struct ReportPairs {
  std::size_t count = 0;
  std::array<double, 3> median_sigma_m{kAbsent, kAbsent, kAbsent};
  double median_leberl_across_m = kAbsent, median_leberl_up_m = kAbsent;
};

/// selection.csv and simplifications.csv.
struct ReportCandidate {
  std::string name, passes, test, verdict, reason;
  double parameters_1 = kAbsent, f_1 = kAbsent, probability_1 = kAbsent, delta_bic_1 = kAbsent;
  double condition = kAbsent;
};
struct ReportSimplification {
  std::string name;
  double bound_m = kAbsent, sigma_m = kAbsent, fraction = kAbsent;
  std::string verdict;
};

struct ResultFolder {
  std::string path;
  ReportSummary summary;
  ReportPoints points;
  std::vector<ReportParameter> parameters;
  std::vector<ReportCorrelation> correlations;  ///< |.| above kHighCorrelation_1, largest first
  std::size_t correlation_count = 0;            ///< of them in all; the list holds at most 40
  ReportLooks looks;
  std::vector<ReportControl> control;
  std::vector<ReportStrip> strips;
  ReportPairs pairs;
  std::vector<ReportCandidate> candidates;
  std::vector<ReportSimplification> simplifications;
};
inline constexpr double kHighCorrelation_1 = 0.95;

/// Reads summary.json and the tables that stand beside it, plain or gzip. Throws InputError for a
/// folder without summary.json, a file that is not what its name says, or a damaged table. Memory:
/// about 130 bytes a point and 40 a look.
[[nodiscard]] ResultFolder ReadResultFolder(const std::filesystem::path& folder,
                                            ProgressSink* progress = nullptr);

}  // namespace sarblock
