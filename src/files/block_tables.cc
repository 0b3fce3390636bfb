// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "block_file.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include "geometry/recorded_states.h"
#include "model/priors.h"
#include "reduction/frames.h"
#include "tables/csv.h"
#include "tables/open.h"
#include "tables/toml.h"
#include <Eigen/Eigenvalues>

namespace sarblock::files {
namespace {

Eigen::Vector3d Position(const Row& row) {
  Eigen::Vector3d position_m;
  Eigen::Index k = 0;
  for (const std::size_t column : kPathColumns("x_m", "y_m", "z_m")) {
    static_cast<void>(row.RequiredNumber(column));
    position_m[k++] = LengthNumber(row, column);
  }
  return position_m;
}

Eigen::Vector3d Velocity(const Row& row) {
  Eigen::Vector3d velocity_mps;
  Eigen::Index k = 0;
  for (const std::size_t column : kPathColumns("vx_mps", "vy_mps", "vz_mps")) {
    const double value_mps = row.RequiredNumber(column);
    if (!(std::abs(value_mps) < kSpeedOfLight_mps)) {
      row.Fail(column,
               "must be less than the speed of light, got " + NumberText(value_mps) + " m/s");
    }
    velocity_mps[k++] = value_mps;
  }
  return velocity_mps;
}

}  // namespace

namespace {

void RefuseCloseStates(const TableReader& reader, const IdTable& pass_ids, const PathTable& table) {
  for (std::uint32_t pass = 0; pass < pass_ids.size(); ++pass) {
    const std::vector<StateVector>& states = table.states[pass];
    const auto close = FindCloseStates(states);
    if (!close) continue;
    const std::size_t second = close->second;
    throw InputError(reader.PlaceAt(table.lines[pass][second], kPathColumns("time_s")),
                     "the states of pass " + Quoted(pass_ids[pass]) + " at " +
                         NumberText(states[second].time_s) + " s and, on " +
                         reader.NameOfLine(table.lines[pass][second - 1]) + ", at " +
                         NumberText(states[second - 1].time_s) + " s are " + Describe(*close));
  }
}

}  // namespace

PathTable ReadPaths(TableReader* reader, const IdTable& pass_ids, const char* holder) {
  PathTable table;
  table.states.resize(pass_ids.size());
  table.lines.resize(pass_ids.size());
  table.not_in_states.resize(pass_ids.size());
  IdFinder passes("pass", pass_ids, holder);
  ForRows(reader, [&](const Row& row) {
    const std::uint32_t pass = passes.Find(row, kPathColumns("pass"));
    std::vector<StateVector>& states = table.states[pass];
    const StateVector state{
        row.RequiredNumber(kPathColumns("time_s")), Position(row), Velocity(row)};
    if (!states.empty() && !(state.time_s > states.back().time_s)) {
      const std::string before = "; the state before, on " +
                                 reader->NameOfLine(table.lines[pass].back()) + ", is at " +
                                 NumberText(states.back().time_s) + " s";
      const std::string id = Quoted(pass_ids[pass]);
      row.Fail(kPathColumns("time_s"),
               state.time_s == states.back().time_s
                   ? "pass " + id + " has two states at " + NumberText(state.time_s) +
                         " s, one is allowed" + before
                   : "times of pass " + id + " must increase, " + NumberText(state.time_s) +
                         " s does not" + before);
    }
    if (state.velocity_mps.squaredNorm() == 0.0) {
      row.Fail(kPathColumns("vx_mps"), "the velocity is zero, the antenna must move");
    }
    states.push_back(state);
    table.lines[pass].push_back(row.line());
    const std::string_view adjusted = row.Text(kPathColumns("adjusted"));
    if (!adjusted.empty() && adjusted != kAllAdjusted && table.not_in_states[pass].empty()) {
      table.not_in_states[pass] = adjusted;
    }
  });
  RefuseCloseStates(*reader, pass_ids, table);
  return table;
}

std::size_t LastLine(const PathTable& table, std::size_t pass) {
  return table.lines[pass].empty() ? 0 : table.lines[pass].back();
}

bool IsOf(const CorrectionGroup& group, const std::string& pass) {
  return group.passes.empty() ||
         std::find(group.passes.begin(), group.passes.end(), pass) != group.passes.end();
}

namespace {

/// Whether the block asks for corrections of the kind of this parameter, such as "range.bias", of
/// a pass: `auto` tries all of them.
bool Corrects(const AdjustTable& options, const std::string& pass, std::string_view parameter) {
  if (options.corrections != CorrectionChoice::kGiven) {
    return options.corrections == CorrectionChoice::kAuto;
  }
  const std::string_view kind = parameter.substr(0, parameter.find('.'));
  return std::any_of(
      options.groups.begin(), options.groups.end(), [&](const CorrectionGroup& group) {
        return IsOf(group, pass) && kCorrectionKinds[group.model.index()] == kind;
      });
}

/// States of a result are no block's where its ranges or times were corrected as well.
void CheckAdjusted(const TableReader& reader, const PathTable& table, BlockReading* reading) {
  for (std::size_t i = 0; i < table.not_in_states.size(); ++i) {
    const std::string& pass = reading->result.block.passes[i].id;
    std::vector<std::string> left;
    std::istringstream names(table.not_in_states[i]);
    for (std::string name; names >> name;) {
      if (!Corrects(reading->result.adjust, pass, name)) left.push_back(name);
    }
    if (left.empty()) continue;
    const std::string text =
        "the adjustment that wrote these states of pass " + Quoted(pass) + " also corrected " +
        ListNames(left) +
        ", which is not in them: measurements of this pass need it as well; ask for it in "
        "[adjust.correction], or empty this column where it is taken off the measurements";
    const FilePlace place = reader.PlaceAt(table.lines[i].front(), kPathColumns("adjusted"));
    const bool measured = reading->options.measurements == Measurements::kRequired;
    if (measured && reading->options.contradictions == Contradictions::kRefuse) {
      throw InputError(place, text);
    }
    reading->result.warnings.push_back(InputError(place, text).what());
  }
}

}  // namespace

void ReadTrajectories(BlockReading* reading) {
  const auto reader = reading->source.Require("trajectories", kPathColumns);
  WarnOfUnknownColumns(*reader, &reading->result.warnings);
  PathTable table = ReadPaths(reader.get(), reading->pass_ids);
  WarnOfDoubts(*reader, &reading->result.warnings);
  CheckAdjusted(*reader, table, reading);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    Pass& pass = reading->result.block.passes[i];
    if (table.states[i].empty()) {
      throw InputError(
          reading->pass_places[i],
          "pass " + Quoted(pass.id) + " has no states in trajectories.csv, two or more are needed");
    }
    if (table.states[i].size() == 1) {
      throw InputError(reader->PlaceAt(table.lines[i].back(), kPathColumns("pass")),
                       "pass " + Quoted(pass.id) + " has one state, two or more are needed");
    }
    pass.path = FlightPath(std::move(table.states[i]));
  }
}

namespace {

constexpr std::array kPointSigmas = kPointColumns("sigma_e_m", "sigma_n_m", "sigma_u_m");

constexpr std::array kVelocities = kPointColumns("vx_mpy", "vy_mpy", "vz_mpy");

// Three cells that are given together or not at all.
bool AllGiven(const Row& row, const std::array<std::size_t, 3>& columns) {
  const auto given = [&row](std::size_t column) { return row.Given(column); };
  if (std::none_of(columns.begin(), columns.end(), given)) return false;
  for (const std::size_t column : columns) {
    if (!given(column)) row.Fail(column, "is empty, all three components are needed or none");
  }
  return true;
}

Eigen::Vector3d ReadPosition(const Row& row, const Frame& frame, PointRole role) {
  const bool cartesian = AllGiven(row, kPointColumns("x_m", "y_m", "z_m")),
             geodetic = AllGiven(row, kPointColumns("lat_deg", "lon_deg", "h_m"));
  if (cartesian && geodetic) {
    row.Fail(kPointColumns("lat_deg"), "excludes x_m, y_m, z_m; give one kind of coordinates");
  }
  if (cartesian) {
    return {LengthNumber(row, kPointColumns("x_m")),
            LengthNumber(row, kPointColumns("y_m")),
            LengthNumber(row, kPointColumns("z_m"))};
  }
  if (geodetic) {
    const double lat_deg = row.Number(kPointColumns("lat_deg")),
                 lon_deg = row.Number(kPointColumns("lon_deg"));
    if (!(std::abs(lat_deg) <= 90.0)) {
      row.Fail(kPointColumns("lat_deg"), "must be from -90 to 90, got " + NumberText(lat_deg));
    }
    if (!(std::abs(lon_deg) <= 360.0)) {
      row.Fail(kPointColumns("lon_deg"), "must be from -360 to 360, got " + NumberText(lon_deg));
    }
    return frame.FrameFromGeodetic(
        {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, LengthNumber(row, kPointColumns("h_m"))});
  }
  if (role != PointRole::kTie) {
    const bool local = frame.kind() == FrameKind::kLocal;
    row.Fail(kPointColumns("x_m"),
             std::string("is empty, a control or check point needs x_m, y_m, z_m") +
                 (local ? "" : " or lat_deg, lon_deg, h_m"));
  }
  return Eigen::Vector3d::Constant(kNotGiven);
}

void RefuseCovariance(const Row& row, std::size_t column, bool both_fixed) {
  if (row.Given(column) && !both_fixed) {
    row.Fail(column, "is given without the standard deviations of both components");
  }
}

KnownPosition ReadKnown(const Row& row, PointRole role, std::uint32_t point) {
  KnownPosition known;
  known.point = point;
  Eigen::Matrix3d& covariance = known.covariance_enu_m2;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma_m = row.PositiveNumber(kPointSigmas[i]);
    known.fixed[i] = !std::isnan(sigma_m);
    const auto k = static_cast<Eigen::Index>(i);
    if (known.fixed[i]) covariance(k, k) = sigma_m * sigma_m;
  }
  const bool any = known.fixed[0] || known.fixed[1] || known.fixed[2];
  const auto cross = [&](std::size_t column, std::size_t i, std::size_t j) {
    RefuseCovariance(row, column, known.fixed[i] && known.fixed[j]);
    const double value_m2 = row.Number(column);
    if (std::isnan(value_m2)) return;
    covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = value_m2;
    covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = value_m2;
  };
  cross(kPointColumns("cov_en_m2"), 0, 1);
  cross(kPointColumns("cov_eu_m2"), 0, 2);
  cross(kPointColumns("cov_nu_m2"), 1, 2);
  if (!any) {
    if (role == PointRole::kControl) {
      row.Fail(kPointColumns("sigma_e_m"),
               "a control point without a standard deviation; at least one of sigma_e_m, "
               "sigma_n_m, sigma_u_m is needed");
    }
    known.fixed = {true, true, true};  // a check point taken as exactly known
    return known;
  }
  // Free components get a one on the diagonal, so that only the fixed ones are tested. Scaling to
  // unit variances keeps the test independent of the units.
  Eigen::Matrix3d tested = covariance;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!known.fixed[static_cast<std::size_t>(i)]) tested(i, i) = 1.0;
  }
  const Eigen::Vector3d scale = tested.diagonal().cwiseSqrt().cwiseInverse();
  tested = scale.asDiagonal() * tested * scale.asDiagonal();
  constexpr double kSmallestEigenvalue = 1e-12;  // of a correlation matrix
  const auto smallest = [&tested] {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tested, Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  };
  if (!tested.allFinite() || !(smallest() > kSmallestEigenvalue)) {
    std::size_t column = kPointColumns("sigma_e_m");
    for (const std::size_t candidate : kPointColumns("cov_nu_m2", "cov_eu_m2", "cov_en_m2")) {
      if (row.Given(candidate)) column = candidate;
    }
    row.Fail(column,
             "the covariance matrix is not positive definite, |cov| < sigma sigma is needed");
  }
  return known;
}

void RefuseGeodeticInLocal(const TableReader& table) {
  for (const std::size_t column : kPointColumns("lat_deg", "lon_deg", "h_m")) {
    if (!table.Has(column)) continue;
    throw InputError(table.PlaceAt(0, column),
                     "a local frame has no geodetic coordinates; x_m, y_m, z_m are allowed");
  }
}

std::optional<PointRole> RoleNamed(std::string_view role) {
  if (role.empty() || role == "tie") return PointRole::kTie;
  if (role == "control") return PointRole::kControl;
  if (role == "check") return PointRole::kCheck;
  return std::nullopt;
}

/// Points of a batch.
struct PointRows {
  std::size_t named = 0;  ///< rows whose id is one
  std::vector<PointRole> role;
  std::vector<Eigen::Vector3d> given_m;
  std::vector<KnownPosition> known;  ///< counted from the first row
  std::size_t tie_sigmas = 0;
};

void ReadPointRow(const Row& row, const Frame& frame, PointRows* rows) {
  static_cast<void>(row.Id(kPointColumns("point")));
  ++rows->named;
  const PointRole role = ReadRole(row, kPointColumns("role"));
  rows->given_m.push_back(ReadPosition(row, frame, role));
  rows->role.push_back(role);
  if (role != PointRole::kTie) {
    rows->known.push_back(ReadKnown(row, role, static_cast<std::uint32_t>(row.number())));
  } else if (std::any_of(kPointSigmas.begin(), kPointSigmas.end(), [&row](std::size_t column) {
               return row.Given(column);
             })) {
    ++rows->tie_sigmas;
  }
}

/// Takes positions to the realization and the epoch of the block, and heights above a geoid to the
/// ellipsoid.
class PointReference {
 public:
  PointReference(const TableReader& table, const Block& block) : block_(block) {
    for (const std::size_t column :
         kPointColumns("frame", "epoch", "vx_mpy", "vy_mpy", "vz_mpy", "geoid")) {
      any_ = any_ || table.Has(column);
    }
  }

  void Refer(const Batch& batch, PointRows* rows) {
    if (!any_) return;
    auto known = rows->known.begin();
    for (std::size_t i = 0; i < rows->given_m.size(); ++i) {
      const Row row(batch, i);
      if (row.Given(kGeoid)) RaiseByGeoid(row, &rows->given_m[i]);
      if (known == rows->known.end() || known->point != i) continue;
      Refer(row, &rows->given_m[i], &known->velocity_mpy);
      ++known;
    }
  }

 private:
  static constexpr std::size_t kFrame = kPointColumns("frame"), kEpoch = kPointColumns("epoch"),
                               kGeoid = kPointColumns("geoid");

  ReferenceFrames& Frames() {
    if (!frames_) frames_ = std::make_unique<ReferenceFrames>();
    return *frames_;
  }

  template <typename Read>
  static auto Checked(const Row& row, std::size_t column, const Read& read) {
    try {
      return read();
    } catch (const InputError& error) {
      row.Fail(column, error.problem());
    }
  }

  void RaiseByGeoid(const Row& row, Eigen::Vector3d* position_m) {
    if (!row.Given(kPointColumns("h_m"))) row.Fail(kGeoid, "belongs to h_m, which is empty");
    if (!IsEarth(block_.frame)) row.Fail(kGeoid, "belongs to frames of the Earth");
    const Geodetic place = block_.frame.GeodeticFromFrame(*position_m);
    const double geoid_m = Checked(row, kGeoid, [&] {
      return Frames().GeoidHeight_m(row.Text(kGeoid), place.lat_rad, place.lon_rad);
    });
    *position_m =
        block_.frame.FrameFromGeodetic({place.lat_rad, place.lon_rad, place.h_m + geoid_m});
  }

  void Refer(const Row& row, Eigen::Vector3d* position_m, Eigen::Vector3d* velocity_mpy) {
    const bool has_epoch = !std::isnan(block_.epoch_year);
    for (const auto& [column, missing, key] :
         {std::tuple{kFrame, block_.realization.empty(), "realization"},
          std::tuple{kFrame, !has_epoch, "epoch"},
          std::tuple{kEpoch, !has_epoch, "epoch"},
          std::tuple{kVelocities[0], !has_epoch, "epoch"}}) {
      if (missing && row.Given(column)) {
        row.Fail(column, std::string("needs ") + key + " of [frame] in block.toml");
      }
    }
    const bool moves = AllGiven(row, kVelocities);
    MovingPoint point{*position_m};
    if (moves) point.velocity_mpy = Velocity_mpy(row);
    double epoch_year = block_.epoch_year;
    if (row.Given(kEpoch)) {
      epoch_year = row.Number(kEpoch);
      Checked(row, kEpoch, [&] { RequireEpoch(epoch_year); });
    }
    const std::string frame =
        row.Given(kFrame) ? Checked(row, kFrame, [&] { return Frames().Named(row.Text(kFrame)); })
                          : block_.realization;
    const double years = block_.epoch_year - epoch_year;
    // Without a velocity, a point is at rest on its plate where the frame is too.
    const bool rests = !moves && row.Given(kFrame) && Frames().MovesWithPlate(frame);
    if (!moves && !rests && years != 0.0 && has_epoch) {
      row.Fail(kVelocities[0],
               "is empty, a velocity takes the point from " + NumberText(epoch_year) +
                   " to the block's epoch, " + NumberText(block_.epoch_year));
    }
    if (frame != block_.realization) {
      point = Checked(row, kFrame, [&] {
        return Frames().Transform(frame, block_.realization, epoch_year, point);
      });
    }
    if (moves || rests) *velocity_mpy = point.velocity_mpy;
    *position_m = years != 0.0 && has_epoch ? point.After(years).position_m : point.position_m;
  }

  static Eigen::Vector3d Velocity_mpy(const Row& row) {
    constexpr double kFast_mpy = 1.0;
    Eigen::Vector3d velocity_mpy;
    for (std::size_t k = 0; k < 3; ++k) {
      const double value_mpy = row.Number(kVelocities[k]);
      if (!(std::abs(value_mpy) < kFast_mpy)) {
        row.Fail(kVelocities[k], "must be below 1, in metres a year, got " + NumberText(value_mpy));
      }
      velocity_mpy[static_cast<Eigen::Index>(k)] = value_mpy;
    }
    return velocity_mpy;
  }

  const Block& block_;
  bool any_ = false;
  std::unique_ptr<ReferenceFrames> frames_;
};

/// Reads rows up to the first with an error, which the batch keeps.
void ReadPointRows(const Frame& frame, Batch* batch, PointRows* rows) {
  *rows = {};
  try {
    for (std::size_t row = 0; row < batch->rows; ++row) {
      ReadPointRow(Row(*batch, row), frame, rows);
    }
  } catch (const InputError&) {
    batch->error = std::current_exception();
  }
}

void AppendPoints(const Batch& batch, const PointRows& rows, Points* points) {
  const auto first = static_cast<std::uint32_t>(points->size());
  for (std::size_t i = 0; i < rows.named; ++i) {
    AddId(Row(batch, i), kPointColumns("point"), &points->ids);
  }
  points->role.insert(points->role.end(), rows.role.begin(), rows.role.end());
  points->given_m.insert(points->given_m.end(), rows.given_m.begin(), rows.given_m.end());
  for (const KnownPosition& known : rows.known) {
    points->known.push_back(known);
    points->known.back().point += first;
  }
}

}  // namespace

std::uint32_t AddId(const Row& row, std::size_t column, IdTable* ids) {
  const std::size_t count = ids->size();
  const std::string_view id = row.Id(column);
  const std::uint32_t added = ids->FindOrAppend(id);
  if (added != count) row.Fail(column, Quoted(id) + " is given twice; one row per point");
  return added;
}

PointRole ReadRole(const Row& row, std::size_t column) {
  const std::string_view role = row.Text(column);
  if (const auto named = RoleNamed(role)) return *named;
  row.Fail(column,
           Quoted(role) + " is not known, tie, control or check is allowed" +
               DidYouMean(NearestName(role, {"tie", "control", "check"})));
}

void ReadPoints(BlockReading* reading) {
  const auto table = reading->source.Open("points", kPointColumns);
  if (!table) return;
  WarnOfUnknownColumns(*table, &reading->result.warnings);
  const Frame& frame = reading->result.block.frame;
  if (frame.kind() == FrameKind::kLocal) RefuseGeodeticInLocal(*table);
  Points& points = reading->result.block.points;
  ReserveInLargePages(table->RowsLeft(), &points.role);
  ReserveInLargePages(table->RowsLeft(), &points.given_m);
  PointReference reference(*table, reading->result.block);
  std::size_t tie_sigmas = 0;
  ForBatches<PointRows>(
      table.get(),
      [&](Batch* batch, PointRows* rows) { ReadPointRows(frame, batch, rows); },
      [&](Batch* batch, PointRows* rows) {
        reference.Refer(*batch, rows);
        AppendPoints(*batch, *rows, &points);
        tie_sigmas += rows->tie_sigmas;
        Step(reading->options.progress, "read", points.size(), 0, "points");
      });
  WarnOfDoubts(*table, &reading->result.warnings);
  if (const std::size_t line = table->first_commented_row(); line > 0) {
    reading->commented_point = FilePlace{table->file(), line, "point"};
  }
  if (tie_sigmas > 0) {
    reading->result.warnings.push_back(
        table->file() + ": standard deviations of " + std::to_string(tie_sigmas) +
        " tie points are ignored, only control and check points have known positions");
  }
}

namespace {

void ReadTruePoints(TableReader* reader, const Block& block, Truth* truth) {
  truth->points_m.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  IdFinder points("point", block.points.ids, "the block");
  constexpr std::size_t kId = kTruthColumns("point");
  ForRows(reader, [&](const Row& row) {
    Eigen::Vector3d& position_m = truth->points_m[points.Find(row, kId)];
    if (!std::isnan(position_m.x())) {
      row.Fail(kId, Quoted(row.Text(kId)) + " is given twice; one row per point");
    }
    position_m = {row.RequiredNumber(kTruthColumns("x_m")),
                  row.RequiredNumber(kTruthColumns("y_m")),
                  row.RequiredNumber(kTruthColumns("z_m"))};
  });
}

void ReadTruePaths(TableReader* reader, const Block& block, Truth* truth) {
  const IdTable pass_ids = PassIds(block);
  PathTable table = ReadPaths(reader, pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(reader->PlaceAt(LastLine(table, i), kPathColumns("pass")),
                       "pass " + Quoted(block.passes[i].id) + " has " +
                           std::to_string(table.states[i].size()) +
                           " states, two or more are needed");
    }
    truth->paths.emplace_back(std::move(table.states[i]));
  }
}

}  // namespace

Truth ReadTruth(const std::filesystem::path& folder, const Block& block) {
  Truth truth;
  const auto source = TablesAt(folder, FolderContent::kBlock);
  if (const auto reader = source->Open("truth", kTruthColumns)) {
    ReadTruePoints(reader.get(), block, &truth);
  }
  if (const auto reader = source->Open("truth_passes", kPathColumns)) {
    ReadTruePaths(reader.get(), block, &truth);
  }
  return truth;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> ReadPairs(const std::filesystem::path& folder,
                                                               const std::string& file,
                                                               const Block& block) {
  constexpr Columns kColumns{{
      {"point_a", ColumnNeed::kRequired, CellKind::kPoint},
      {"point_b", ColumnNeed::kRequired, CellKind::kPoint},
  }};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  IdFinder first("point", block.points.ids, "the block"), second = first;
  ForRows(ReadCsv(FolderOf(folder) / file, kColumns).get(), [&](const Row& row) {
    pairs.emplace_back(first.Find(row, kColumns("point_a")), second.Find(row, kColumns("point_b")));
    if (pairs.back().first == pairs.back().second) {
      row.Fail(kColumns("point_b"),
               Quoted(row.Text(kColumns("point_b"))) +
                   " is point_a too, two different points are needed");
    }
  });
  return pairs;
}

std::size_t ApplyRejections(const std::filesystem::path& folder,
                            const std::string& file,
                            Block* block) {
  constexpr Columns kColumns{{
      {"pass", ColumnNeed::kRequired, CellKind::kPass},
      {"point", ColumnNeed::kRequired, CellKind::kPoint},
      {"rejected", ColumnNeed::kRequired, CellKind::kFlag},
  }};
  const IdTable pass_ids = PassIds(*block);
  IdFinder passes("pass", pass_ids, "block.toml"), points("point", block->points.ids, "the block");
  Looks& looks = block->looks;
  std::size_t rejected = 0;
  ForRows(ReadCsv(FolderOf(folder) / file, kColumns).get(), [&](const Row& row) {
    if (!row.Flag(kColumns("rejected"))) return;
    const std::uint32_t pass = passes.Find(row, kColumns("pass"));
    const std::uint32_t point = points.Find(row, kColumns("point"));
    const auto begin = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point]);
    const auto end = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point + 1]);
    const auto at = std::find(begin, end, pass);
    if (at == end) {
      row.Fail(kColumns("point"),
               "pass " + Quoted(row.Text(kColumns("pass"))) + " has no look of point " +
                   Quoted(row.Text(kColumns("point"))) + " in this block");
    }
    std::uint8_t& flags = looks.flags[static_cast<std::size_t>(at - looks.pass.begin())];
    if ((flags & Looks::kRejected) == 0) ++rejected;
    flags = static_cast<std::uint8_t>(flags | Looks::kRejected);
  });
  block->points.ids.DropIndex();
  return rejected;
}

}  // namespace sarblock::files
