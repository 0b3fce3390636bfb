// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/core/stage_timer.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// One pass of a result: what summary.json says of it, and its path of trajectories.csv.
struct ResultPass {
  std::string id;
  LookSide side = LookSide::kLeft;
  double wavelength_m = kNotGiven;
  double start_s = 0.0;   ///< strip-normalised time -1
  double end_s = 0.0;     ///< strip-normalised time +1
  std::string epoch_utc;  ///< what time_s = 0 is, as the block gives it; empty: not given
  FlightPath path;        ///< corrected; of `intersect` and `predict` the nominal one
};

/// The global test of summary.json (`chi_square`).
struct ResultTest {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  double level = 0.0;
  bool passed = false;
};

/// The essentials of summary.json. Figures that do not exist (null) are NaN.
struct ResultSummary {
  std::string version;  ///< of the program that wrote it
  std::string command;  ///< adjust, intersect or predict
  std::string block;    ///< name of the block
  std::string status;   ///< converged, not_converged, intersected, predicted
  bool accepted = false;
  std::size_t points = 0;
  std::size_t looks = 0;
  std::size_t looks_used = 0;
  std::size_t parameters = 0;
  std::size_t observations = 0;
  double redundancy = kNotGiven;
  std::size_t iterations = 0;
  double initial_cost = kNotGiven;
  double final_cost = kNotGiven;
  double gradient = kNotGiven;
  double sigma0_squared = kNotGiven;
  bool sigma_scaled_by_posterior = false;
  std::optional<ResultTest> chi_square;
  std::string covariance;  ///< level: none, leberl, intersection, block, montecarlo
  double condition = kNotGiven;
  std::vector<StageCost> stages;  ///< by name
  std::vector<std::string> warnings;
  std::string json;  ///< the whole text, for who wants more of it
};

/// points.csv, by point: `results` as the adjustment had them in memory, but for rounding where
/// the table has another form (angles in degrees, standard deviations for variances).
struct ResultPoints {
  IdTable ids;
  std::vector<PointRole> role;
  PointResults results;
  std::vector<CheckResult> checks;  ///< sorted by point
  [[nodiscard]] std::size_t size() const { return role.size(); }
};

/// residuals.csv in flat arrays, in the order of the table: by point and, within it, by pass. NaN
/// where a cell is empty. Component 0 is the range and 1 the azimuth.
struct ResultLooks {
  std::vector<std::uint32_t> pass;
  std::vector<std::uint32_t> point;
  std::vector<double> range_residual_m;
  std::vector<double> azimuth_residual_m;
  std::vector<float> weight;
  std::vector<std::uint8_t> rejected;
  std::vector<RejectReason> reason;
  std::vector<std::uint32_t> finding;  ///< number of the blunder search's finding; 0: none
  /// Quality of observations; empty without a covariance.
  std::array<std::vector<float>, 2> redundancy_1, w_1, tau_1, mdb_m, influence_m;
  /// Measured image coordinates and the residuals as steps of the image (computed minus
  /// measured); empty where no pass has an image.
  std::vector<double> line_px, pixel_px, line_residual_px, pixel_residual_px;
  [[nodiscard]] std::size_t size() const { return pass.size(); }
};

/// A row of control_quality.csv.
struct ResultControl {
  std::uint32_t point = 0;
  int component = 0;          ///< 0 east, 1 north, 2 up
  double residual_m = 0.0;    ///< adjusted minus given
  double redundancy_1 = 0.0;  ///< these five: NaN where the cell is empty
  double w_1 = 0.0;
  double tau_1 = 0.0;
  double mdb_m = 0.0;
  double influence_m = 0.0;
};

/// A result folder as it was read.
struct ResultFile {
  ResultSummary summary;
  Frame frame = Frame::Local();
  std::vector<ResultPass> passes;
  ResultPoints points;
  std::vector<ParameterResult> parameters;                ///< passes.csv
  std::vector<ParameterCovariance> parameter_covariance;  ///< indices into `parameters`
  ResultLooks looks;
  std::vector<ResultControl> control;  ///< empty without control_quality.csv
  std::vector<PairResult> pairs;       ///< empty without pairs.csv
};

/// Which tables are read; the others' members stay empty (a pass keeps an empty path). The looks
/// of a large block are most of its bytes.
struct ReadResultOptions {
  bool looks = true;  ///< residuals.csv
  bool pairs = true;  ///< pairs.csv
  bool paths = true;  ///< trajectories.csv
  ProgressSink* progress = nullptr;
};

}  // namespace sarblock
