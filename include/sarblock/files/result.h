// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/files/block_file.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sarblock::files {

/// One file that a run has read.
struct InputFile {
  std::string name;         ///< within its folder: "observations.csv.gz"
  std::uint64_t bytes = 0;  ///< as stored, compressed or not
  std::string sha256;       ///< of these bytes, 64 hexadecimal digits: what `sha256sum` prints
};

/// SHA-256 (FIPS 180-4) of a file in hexadecimal. Throws InputError if it cannot be read.
[[nodiscard]] std::string Sha256OfFile(const std::filesystem::path& file);

/// The files that an adjustment of a block depends on: block.toml, the tables trajectories,
/// observations and points, or the one file of all, then the lists of pairs and rejections that
/// `options` names. Files that are not there are left out: reading the block says what is missing.
[[nodiscard]] std::vector<InputFile> ListInputFiles(const std::filesystem::path& block,
                                                    const AdjustTable& options);

/// Facts about a run that a result folder holds in addition to the result itself.
struct ResultContext {
  std::string command = "adjust";     ///< adjust, intersect or predict
  std::vector<std::string> warnings;  ///< of reading the block; the result's own come after
  std::vector<InputFile> inputs{};    ///< the files read, with their checksums
  /// Points above which points.geojson leaves out the ellipses' polygons (1.2 kB each) and keeps
  /// their numbers; the summary then has a warning.
  std::size_t ellipse_limit = 100000;
  Compression compression = Compression::kNone;  ///< of the tables
  std::vector<StageCost> stages;                 ///< before the result's own, such as `read`
  std::optional<Diagnosis> diagnosis;            ///< where one was made
};

/// Content of summary.json (docs/formats.md), a newline at the end. Figures that do not exist
/// (NaN) are null.
[[nodiscard]] std::string SummaryJson(const Block& block,
                                      const AdjustTable& options,
                                      const AdjustResult& result,
                                      const ResultContext& context);

/// Writes a result folder, or an HDF5 file (without points.geojson) where the name ends in ".h5":
/// summary.json, points.csv, passes.csv, passes_covariance.csv,
/// residuals.csv, control_quality.csv (with control), selection.csv and simplifications.csv (if
/// corrections were chosen), pairs.csv and montecarlo.csv (if asked for), trajectories.csv,
/// strips.csv, points.geojson (geocentric frames). Each file appears whole or not at all,
/// summary.json last. Returns the summary that was written; its stages end with `write`, the cost
/// of this call. Positions in frame axes [m]; standard deviations and covariances in east, north,
/// up; angles in degrees. What was not computed is an empty cell.
std::string WriteResult(const std::filesystem::path& target,
                        const Block& block,
                        const AdjustTable& options,
                        const AdjustResult& result,
                        const ResultContext& context);

/// One pass of a result: its entries in summary.json, and its path of trajectories.csv.
struct ResultPass {
  std::string id;
  LookSide side = LookSide::kLeft;
  double wavelength_m = kNotGiven;
  double start_s = 0.0;   ///< strip-normalised time -1
  double end_s = 0.0;     ///< strip-normalised time +1
  std::string epoch_utc;  ///< what time_s = 0 is, as the block gives it; empty: not given
  FlightPath path;        ///< corrected; of `intersect` and `predict` the nominal one
};

/// A global test of the variance factor (`chi_square`, `variance_components.before`).
struct ResultTest : GlobalTest {
  double level = 0.95;
};

/// `check_points`.
struct ResultChecks {
  std::size_t points = 0, components = 0;
  double error_ratio = kNotGiven;  ///< errors in units of what was predicted
  bool realistic = false;
  std::string says;  ///< a sentence
};

/// `quality`: the tests of single observations.
struct ResultTests {
  double alpha = kNotGiven, power = kNotGiven, critical_w = kNotGiven;
  double expected_above = kNotGiven;
  std::size_t tests = 0, not_localisable = 0;
  std::array<std::size_t, 3> above{};  ///< range, azimuth, control
  [[nodiscard]] std::size_t above_all() const { return above[0] + above[1] + above[2]; }
};

/// A finding of the search for blunders (`snooping.findings`).
struct ResultFinding {
  std::size_t round = 0;
  std::string point;
  std::vector<std::string> passes;  ///< of its looks
  bool control = false;             ///< the point's known position is among the suspects
  std::string component, action, note;
  double w = kNotGiven;
  bool located = false;
};

/// `montecarlo`: each figure that was compared with what is expected of it.
struct ResultRepetition {
  struct Figure {
    std::string name;
    double expected = kNotGiven, mean = kNotGiven, lower = kNotGiven, upper = kNotGiven;
    bool agrees = false;
  };
  std::size_t runs = 0;
  std::uint64_t seed = 0;
  std::string verdict;
  std::vector<Figure> figures;
};

/// Content of summary.json without the passes. Figures that do not exist (null) are NaN.
struct ResultSummary {
  std::string version;  ///< of the program that wrote it
  std::string command;  ///< adjust, intersect or predict
  std::string block;    ///< name of the block
  std::string status;   ///< converged, not_converged, intersected, predicted
  Verdict verdict = Verdict::kNotAccepted;
  std::vector<std::string> verdict_reasons;  ///< why it is not accepted, the gravest first
  std::vector<std::pair<std::string, double>> counts;        ///< as in the file
  [[nodiscard]] double Count(std::string_view name) const {  ///< 0 where not given
    for (const auto& [key, value] : counts) {
      if (key == name) return value;
    }
    return 0.0;
  }
  std::size_t iterations = 0;
  double initial_cost = kNotGiven;
  double final_cost = kNotGiven;
  double gradient = kNotGiven;
  double remaining_step = kNotGiven;
  double sigma0_squared = kNotGiven;
  bool sigma_scaled_by_posterior = false;
  std::optional<ResultTest> chi_square;
  std::vector<ObservationGroup> groups;  ///< empty where the file has none
  std::vector<DifferenceClass> differences;
  std::optional<ResultChecks> checks;
  std::optional<ResultTests> tests;
  std::optional<std::size_t> snooping_rounds;
  std::vector<ResultFinding> findings;
  std::optional<ResultTest> test_before;     ///< before variance components were estimated
  std::vector<VarianceComponent> variances;  ///< without their passes
  std::optional<ResultRepetition> repetition;
  std::string selected_model;  ///< correction tables chosen, as TOML
  bool selection_settled = true;
  std::string covariance;  ///< level: none, leberl, intersection, block, montecarlo
  double condition = kNotGiven;
  std::vector<StageCost> stages;  ///< in the order of the file, as all lists
  std::vector<std::string> warnings;
  std::vector<InputFile> inputs;
  std::vector<std::pair<std::string, std::string>> configuration;  ///< dotted keys, JSON values
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
/// where a cell is empty; weight, rejected and reason are given of all. Component 0 is the range
/// and 1 the azimuth.
struct ResultLooks : LookResults {
  std::vector<std::uint32_t> pass;
  std::vector<std::uint32_t> point;
  std::vector<std::uint32_t> finding;  ///< number of the blunder search's finding; 0: none
  LookQuality quality;                 ///< without shift_m, which the table has as influence_m
  std::array<std::vector<float>, 2> tau, mdb_m, influence_m;  ///< empty without a covariance
  /// Measured image coordinates and the residuals as steps of the image (computed minus
  /// measured); empty where no pass has an image.
  std::vector<double> line_px, pixel_px, line_residual_px, pixel_residual_px;
  [[nodiscard]] std::size_t size() const { return pass.size(); }
};

/// A row of control_quality.csv; but for point, component and residual NaN where a cell is empty.
struct ResultControl : ControlQuality {  // shift_m is NaN: the table has influence_m
  double sigma_m = kNotGiven;            ///< of the given coordinate
  double tau = kNotGiven;
  double mdb_m = kNotGiven;
  double influence_m = kNotGiven;
};

/// A result folder as it was read.
struct ResultFile {
  ResultSummary summary;
  Frame frame = Frame::Local();
  std::string realization;        ///< Block::realization
  double epoch_year = kNotGiven;  ///< Block::epoch_year
  std::vector<ResultPass> passes;
  ResultPoints points;
  std::vector<ParameterResult> parameters;                ///< passes.csv
  std::vector<ParameterCovariance> parameter_covariance;  ///< indices into `parameters`
  ResultLooks looks;
  Reductions reductions;                             ///< by look of residuals.csv, and `reductions`
  std::vector<ResultControl> control;                ///< empty without control_quality.csv
  std::vector<PairResult> pairs;                     ///< empty without pairs.csv
  std::vector<StripStation> strips;                  ///< by pass and time; empty without strips.csv
  std::vector<CandidateResult> candidates;           ///< empty without selection.csv
  std::vector<SimplificationBound> simplifications;  ///< empty without simplifications.csv
};

/// Which tables are read; the others' members stay empty (a pass keeps an empty path). The looks
/// of a large block are most of its bytes.
struct ReadResultOptions {
  bool looks = true;  ///< residuals.csv
  bool pairs = true;  ///< pairs.csv
  bool paths = true;  ///< trajectories.csv
  ProgressSink* progress = nullptr;
};

/// Reads what WriteResult() wrote (docs/formats.md): summary.json, points.csv, passes.csv,
/// passes_covariance.csv, residuals.csv, control_quality.csv, pairs.csv, strips.csv, selection.csv,
/// simplifications.csv and trajectories.csv, each table plain or as `.csv.gz`, or all of an HDF5
/// file (docs/container.md). Covariances are as
/// written: scaled by the posterior variance factor where the result is. montecarlo.csv is not
/// read: its sums are in the summary. Report, comparison and export read results by this alone.
///
/// Every fault of the files throws InputError with file, line and field, as ReadBlock() does; also
/// tables that contradict each other (a look of a point that points.csv does not have, fewer
/// points than the summary counts: files of two results). Columns not known are ignored. A summary
/// without `frame` or `passes`, of a version before they were written, is refused. Memory: about
/// 300 bytes per point and 100 per look.
[[nodiscard]] ResultFile ReadResult(const std::filesystem::path& path,
                                    const ReadResultOptions& options = {});

/// A result as texts, named like the files they replace.
struct ResultTexts {
  std::string_view summary_json;
  std::string_view points_csv;
  std::string_view passes_csv;
  std::string_view residuals_csv;
  std::string_view trajectories_csv;
  std::optional<std::string_view> passes_covariance_csv = {};
  std::optional<std::string_view> control_quality_csv = {};
  std::optional<std::string_view> pairs_csv = {};
  std::optional<std::string_view> strips_csv = {};
  std::optional<std::string_view> selection_csv = {};
  std::optional<std::string_view> simplifications_csv = {};
};
/// The same from memory.
[[nodiscard]] ResultFile ReadResultTexts(const ResultTexts& texts,
                                         const ReadResultOptions& options = {});

}  // namespace sarblock::files
