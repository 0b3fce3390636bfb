// SPDX-License-Identifier: Apache-2.0
#include "block_tables.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "block_reader.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include "tables/csv.h"
#include "tables/open.h"
#include "tables/toml.h"
#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

enum { kStatePass, kStateTime, kStateX, kStateY, kStateZ, kStateVx, kStateVy, kStateVz };

Eigen::Vector3d Position(const TableReader& reader) {
  Eigen::Vector3d position_m;
  for (std::size_t k = 0; k < 3; ++k) {
    static_cast<void>(reader.RequiredNumber(kStateX + k));
    position_m[static_cast<Eigen::Index>(k)] = LengthNumber(reader, kStateX + k);
  }
  return position_m;
}

Eigen::Vector3d Velocity(const TableReader& reader) {
  Eigen::Vector3d velocity_mps;
  for (std::size_t k = 0; k < 3; ++k) {
    const double value_mps = reader.RequiredNumber(kStateVx + k);
    if (!(std::abs(value_mps) < kSpeedOfLight_mps)) {
      reader.Fail(kStateVx + k,
                  NumberText(value_mps) + " m/s is not allowed, less than the speed of light is");
    }
    velocity_mps[static_cast<Eigen::Index>(k)] = value_mps;
  }
  return velocity_mps;
}

}  // namespace

PathTable ReadPaths(TableReader* reader, const IdTable& pass_ids, const char* holder) {
  PathTable table;
  table.states.resize(pass_ids.size());
  table.lines.resize(pass_ids.size(), 0);
  while (reader->Next()) {
    const std::uint32_t pass = FindPass(*reader, kStatePass, pass_ids, holder);
    std::vector<StateVector>& states = table.states[pass];
    const StateVector state{
        reader->RequiredNumber(kStateTime), Position(*reader), Velocity(*reader)};
    if (!states.empty() && !(state.time_s > states.back().time_s)) {
      const std::string before = "; the state before, on " + reader->NameOfLine(table.lines[pass]) +
                                 ", is at " + NumberText(states.back().time_s) + " s";
      const std::string id = Quoted(pass_ids[pass]);
      reader->Fail(kStateTime,
                   state.time_s == states.back().time_s
                       ? "pass " + id + " has two states at " + NumberText(state.time_s) +
                             " s, one is allowed" + before
                       : "times of pass " + id + " must increase, " + NumberText(state.time_s) +
                             " s does not" + before);
    }
    if (state.velocity_mps.squaredNorm() == 0.0) {
      reader->Fail(kStateVx, "the velocity is zero, the antenna must move");
    }
    states.push_back(state);
    table.lines[pass] = reader->line();
  }
  return table;
}

void ReadTrajectories(BlockReading* reading) {
  const auto reader = reading->source.Require("trajectories", kPathColumns);
  WarnOfUnknownColumns(*reader, &reading->result.warnings);
  PathTable table = ReadPaths(reader.get(), reading->pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    Pass& pass = reading->result.block.passes[i];
    if (table.states[i].empty()) {
      throw InputError(
          reading->pass_places[i],
          "pass " + Quoted(pass.id) + " has no states in trajectories.csv, two or more are needed");
    }
    if (table.states[i].size() == 1) {
      throw InputError(reader->PlaceAt(table.lines[i], kStatePass),
                       "pass " + Quoted(pass.id) + " has one state, two or more are needed");
    }
    pass.path = FlightPath(std::move(table.states[i]));
  }
}

namespace {

enum {
  kPointId,
  kPointRole,
  kPointX,
  kPointY,
  kPointZ,
  kPointLat,
  kPointLon,
  kPointHeight,
  kPointSigmaE,
  kPointSigmaN,
  kPointSigmaU,
  kPointCovEN,
  kPointCovEU,
  kPointCovNU
};
// Three cells that are given together or not at all.
bool AllGiven(const TableReader& reader, std::size_t first) {
  int given = 0;
  for (std::size_t i = first; i < first + 3; ++i) given += reader.Given(i) ? 1 : 0;
  for (std::size_t i = first; given > 0 && i < first + 3; ++i) {
    if (!reader.Given(i)) reader.Fail(i, "is empty, all three coordinates are needed or none");
  }
  return given == 3;
}

Eigen::Vector3d ReadPosition(const TableReader& reader, const Frame& frame, PointRole role) {
  const bool cartesian = AllGiven(reader, kPointX), geodetic = AllGiven(reader, kPointLat);
  if (cartesian && geodetic) {
    reader.Fail(kPointLat, "stands beside x_m, y_m, z_m; one kind of coordinates is allowed");
  }
  if (cartesian) {
    return {LengthNumber(reader, kPointX),
            LengthNumber(reader, kPointY),
            LengthNumber(reader, kPointZ)};
  }
  if (geodetic) {
    const double lat_deg = reader.Number(kPointLat), lon_deg = reader.Number(kPointLon);
    if (!(std::abs(lat_deg) <= 90.0)) {
      reader.Fail(kPointLat, NumberText(lat_deg) + " is not allowed, -90 to 90 is");
    }
    if (!(std::abs(lon_deg) <= 360.0)) {
      reader.Fail(kPointLon, NumberText(lon_deg) + " is not allowed, -360 to 360 is");
    }
    return frame.FrameFromGeodetic(
        {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, LengthNumber(reader, kPointHeight)});
  }
  if (role != PointRole::kTie) {
    const bool local = frame.kind() == FrameKind::kLocal;
    reader.Fail(kPointX,
                std::string("is empty, a control or check point needs x_m, y_m, z_m") +
                    (local ? "" : " or lat_deg, lon_deg, h_m"));
  }
  return Eigen::Vector3d::Constant(kNotGiven);
}

void RefuseCovariance(const TableReader& reader, std::size_t column, bool both_held) {
  if (reader.Given(column) && !both_held) {
    reader.Fail(column, "is given without the standard deviations of both components");
  }
}

KnownPosition ReadKnown(const TableReader& reader, PointRole role, std::uint32_t point) {
  KnownPosition known;
  known.point = point;
  Eigen::Matrix3d& covariance = known.covariance_enu_m2;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma_m = PositiveNumber(reader, kPointSigmaE + i);
    known.held[i] = !std::isnan(sigma_m);
    const auto k = static_cast<Eigen::Index>(i);
    if (known.held[i]) covariance(k, k) = sigma_m * sigma_m;
  }
  const bool any = known.held[0] || known.held[1] || known.held[2];
  const auto cross = [&](std::size_t column, std::size_t i, std::size_t j) {
    RefuseCovariance(reader, column, known.held[i] && known.held[j]);
    const double value_m2 = reader.Number(column);
    if (std::isnan(value_m2)) return;
    covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = value_m2;
    covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = value_m2;
  };
  cross(kPointCovEN, 0, 1);
  cross(kPointCovEU, 0, 2);
  cross(kPointCovNU, 1, 2);
  if (!any) {
    if (role == PointRole::kControl) {
      reader.Fail(kPointSigmaE,
                  "a control point without a standard deviation; at least one of sigma_e_m, "
                  "sigma_n_m, sigma_u_m is needed");
    }
    known.held = {true, true, true};  // a check point taken as exactly known
    return known;
  }
  // Free components get a one on the diagonal, so that only the held ones are tested. Scaling to
  // unit variances keeps the test independent of the units.
  Eigen::Matrix3d tested = covariance;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!known.held[static_cast<std::size_t>(i)]) tested(i, i) = 1.0;
  }
  const Eigen::Vector3d scale = tested.diagonal().cwiseSqrt().cwiseInverse();
  tested = scale.asDiagonal() * tested * scale.asDiagonal();
  constexpr double kSmallestEigenvalue = 1e-12;  // of a correlation matrix
  const auto smallest = [&tested] {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tested, Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  };
  if (!tested.allFinite() || !(smallest() > kSmallestEigenvalue)) {
    std::size_t column = kPointSigmaE;
    for (const std::size_t candidate : {kPointCovNU, kPointCovEU, kPointCovEN}) {
      if (reader.Given(candidate)) column = candidate;
    }
    reader.Fail(column,
                "the covariance matrix is not positive definite, |cov| < sigma sigma is needed");
  }
  return known;
}

void RefuseGeodeticInLocal(const TableReader& reader) {
  for (const std::size_t column : {kPointLat, kPointLon, kPointHeight}) {
    if (reader.Has(column)) {
      reader.Fail(column, "a local frame has no geodetic coordinates; x_m, y_m, z_m are allowed");
    }
  }
}

std::optional<PointRole> RoleNamed(std::string_view role) {
  if (role.empty() || role == "tie") return PointRole::kTie;
  if (role == "control") return PointRole::kControl;
  if (role == "check") return PointRole::kCheck;
  return std::nullopt;
}

/// Some rows as a thread has read them.
struct PointPart {
  std::unique_ptr<TableReader> reader;
  std::size_t first = 0;       // number of the first row, where it is known
  bool ids_are_found = false;  // where the file stores each text once
  IdTable ids;                 // else, with their lines
  std::vector<std::size_t> lines;
  std::vector<PointRole> role;
  std::vector<Eigen::Vector3d> given_m;
  std::vector<KnownPosition> known;  // counted from the first row
  std::size_t tie_sigmas = 0;
  std::exception_ptr error;  // of the row behind these
};

/// Adds the points of a part that no row has been read of, if its ids stand once.
void FindPointsAhead(PointPart* part, Points* points) {
  part->ids_are_found = part->reader->LookupAhead(kPointId, [&](std::string_view id) {
    return TableReader::ProblemOfId(id) != nullptr ? TableReader::kUnknown
                                                   : points->ids.FindOrAppend(id);
  });
  static_cast<void>(part->reader->LookupAhead(kPointRole, [](std::string_view name) {
    const auto role = RoleNamed(name);
    return role ? static_cast<std::uint32_t>(*role) : TableReader::kUnknown;
  }));
}

/// By row of a part that no row has been read of: whether it is a tie point that has x, y and z or
/// no coordinates, and nothing else. Empty where the cells are text.
std::vector<std::uint8_t> PlainTiePoints(const TableReader& part) {
  std::vector<std::uint32_t> role;
  const bool roles = part.Has(kPointRole);
  if (part.RowCount() == 0 || (roles && !part.IndicesAhead(kPointRole, &role))) return {};
  std::vector<std::uint8_t> plain(part.RowCount(), 1), given(part.RowCount(), 0);
  for (std::size_t row = 0; row < role.size(); ++row) {
    plain[row] = role[row] == static_cast<std::uint32_t>(PointRole::kTie) ? 1 : 0;
  }
  for (std::size_t column = kPointX; column <= kPointCovNU; ++column) {
    if (part.NoneAhead(column)) continue;
    const std::span<const double> values = part.NumbersAhead(column);
    if (values.size() != plain.size()) return {};
    const bool cartesian = column <= kPointZ;
    for (std::size_t row = 0; row < plain.size(); ++row) {
      const bool number = cartesian && std::abs(values[row]) <= kLargestLength_m;
      if (!number && !std::isnan(values[row])) plain[row] = 0;
      if (number) ++given[row];
    }
  }
  for (std::size_t row = 0; row < plain.size(); ++row) {
    if (given[row] != 0 && given[row] != 3) plain[row] = 0;
  }
  return plain;
}

/// Takes all rows of such a part as whole columns, if all are `plain` and have ids of their own.
bool TakePlainTiePoints(const std::vector<std::uint8_t>& plain, PointPart* part) {
  const TableReader& reader = *part->reader;
  std::vector<std::uint32_t> ids;
  if (plain.empty() || !part->ids_are_found || !reader.IndicesAhead(kPointId, &ids)) return false;
  bool taken = true;
  for (std::size_t row = 0; row < plain.size(); ++row) {
    taken &= plain[row] != 0 && ids[row] == part->first + row;
  }
  if (!taken) return false;
  part->role.assign(plain.size(), PointRole::kTie);
  part->given_m.assign(plain.size(), Eigen::Vector3d::Constant(kNotGiven));
  for (std::size_t k = 0; k < 3; ++k) {
    if (reader.NoneAhead(kPointX + k)) continue;
    const std::span<const double> values_m = reader.NumbersAhead(kPointX + k);
    for (std::size_t row = 0; row < values_m.size(); ++row) {
      part->given_m[row][static_cast<Eigen::Index>(k)] = values_m[row];
    }
  }
  return true;
}

[[noreturn]] void FailTwice(const FilePlace& place, std::string_view id) {
  throw InputError(place, Quoted(id) + " stands twice, one row a point is allowed");
}

void ReadPointRow(const Frame& frame, PointPart* part) {
  const TableReader& reader = *part->reader;
  const PointRole role = ReadRole(reader, kPointRole);
  part->given_m.push_back(ReadPosition(reader, frame, role));
  const auto row = static_cast<std::uint32_t>(part->role.size());
  part->role.push_back(role);
  if (role != PointRole::kTie) {
    part->known.push_back(ReadKnown(reader, role, row));
  } else if (reader.Given(kPointSigmaE) || reader.Given(kPointSigmaN) ||
             reader.Given(kPointSigmaU)) {
    ++part->tie_sigmas;
  }
}

void ReadPointRows(const Frame& frame, PointPart* part) {
  TableReader& reader = *part->reader;
  const std::vector<std::uint8_t> plain = PlainTiePoints(reader);
  if (TakePlainTiePoints(plain, part)) return;
  part->role.reserve(reader.RowCount());
  part->given_m.reserve(reader.RowCount());
  for (std::size_t row = 0; reader.Next(); ++row) {
    if (part->ids_are_found) {
      const auto unknown = [&] { return static_cast<void>(reader.Id(kPointId)), IdTable::kNone; };
      if (reader.Lookup(kPointId, unknown) != part->first + row) {
        FailTwice(reader.Place(kPointId), reader.Id(kPointId));
      }
    } else {
      part->ids.Append(reader.Id(kPointId));
      part->lines.push_back(reader.line());
    }
    if (row < plain.size() && plain[row] != 0) {
      part->role.push_back(PointRole::kTie);
      part->given_m.emplace_back(
          reader.Number(kPointX), reader.Number(kPointY), reader.Number(kPointZ));
    } else {
      ReadPointRow(frame, part);
    }
  }
}

void AppendPoints(const PointPart& part, Points* points) {
  const auto first = static_cast<std::uint32_t>(points->size());
  for (std::size_t row = 0; row < part.ids.size(); ++row) {
    if (points->ids.FindOrAppend(part.ids[row]) != first + row) {
      FailTwice(part.reader->PlaceAt(part.lines[row], kPointId), part.ids[row]);
    }
  }
  if (part.error) std::rethrow_exception(part.error);
  points->role.insert(points->role.end(), part.role.begin(), part.role.end());
  points->given_m.insert(points->given_m.end(), part.given_m.begin(), part.given_m.end());
  for (const KnownPosition& known : part.known) {
    points->known.push_back(known);
    points->known.back().point += first;
  }
}

}  // namespace

PointRole ReadRole(const TableReader& reader, std::size_t column) {
  const std::string_view role = reader.Text(column);
  if (const auto named = RoleNamed(role)) return *named;
  reader.Fail(column,
              Quoted(role) + " is not known, tie, control or check is allowed" +
                  DidYouMean(NearestName(role, {"tie", "control", "check"})));
}

void ReadPoints(BlockReading* reading) {
  auto opened = reading->source.Open("points", kPointColumns);
  if (!opened) return;
  TableReader& reader = *opened;
  WarnOfUnknownColumns(reader, &reading->result.warnings);
  const Frame& frame = reading->result.block.frame;
  if (frame.kind() == FrameKind::kLocal) RefuseGeodeticInLocal(reader);
  Points& points = reading->result.block.points;
  ReserveInLargePages(reader.RowCount(), &points.role);
  ReserveInLargePages(reader.RowCount(), &points.given_m);
  std::size_t tie_sigmas = 0, begun = 0;
  std::vector<PointPart> parts(ItemsAtOnce());
  const auto next = [&](std::size_t place) {
    PointPart part;
    part.reader = reader.Part();
    if (part.reader == nullptr) return false;
    part.first = begun;
    begun += part.reader->RowCount();
    FindPointsAhead(&part, &points);
    parts[place] = std::move(part);
    return true;
  };
  const auto read = [&](std::size_t place) {
    try {
      ReadPointRows(frame, &parts[place]);
    } catch (const InputError&) {
      parts[place].error = std::current_exception();
    }
  };
  const auto append = [&](std::size_t place) {
    AppendPoints(parts[place], &points);
    tie_sigmas += parts[place].tie_sigmas;
    parts[place] = {};
    Step(reading->options.progress, "read", points.size(), 0, "points");
  };
  PipeInOrder(parts.size(), next, read, append);
  if (tie_sigmas > 0) {
    reading->result.warnings.push_back(
        reader.file() + ": standard deviations of " + std::to_string(tie_sigmas) +
        " tie points are ignored, only control and check points have known positions");
  }
}

namespace {

void ReadTruePoints(TableReader* reader, const Block& block, Truth* truth) {
  truth->points_m.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  while (reader->Next()) {
    Eigen::Vector3d& position_m = truth->points_m[FindPoint(*reader, 0, block.points.ids)];
    if (!std::isnan(position_m.x())) {
      reader->Fail(0, Quoted(reader->Text(0)) + " stands twice, one row a point is allowed");
    }
    position_m = {reader->RequiredNumber(1), reader->RequiredNumber(2), reader->RequiredNumber(3)};
  }
}

void ReadTruePaths(TableReader* reader, const Block& block, Truth* truth) {
  IdTable pass_ids;
  for (const Pass& pass : block.passes) pass_ids.Append(pass.id);
  PathTable table = ReadPaths(reader, pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(reader->PlaceAt(table.lines[i], 0),
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
  constexpr std::array<TableColumn, 2> columns{
      {{"point_a", ColumnNeed::kRequired}, {"point_b", ColumnNeed::kRequired}}};
  CsvReader reader(FolderOf(folder) / file, columns);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  while (reader.Next()) {
    pairs.emplace_back(FindPoint(reader, 0, block.points.ids),
                       FindPoint(reader, 1, block.points.ids));
    if (pairs.back().first == pairs.back().second) {
      reader.Fail(1, Quoted(reader.Text(1)) + " is point_a too, two different points are needed");
    }
  }
  return pairs;
}

std::size_t ApplyRejections(const std::filesystem::path& folder,
                            const std::string& file,
                            Block* block) {
  constexpr std::array<TableColumn, 3> columns{{{"pass", ColumnNeed::kRequired},
                                                {"point", ColumnNeed::kRequired},
                                                {"rejected", ColumnNeed::kRequired}}};
  IdTable pass_ids;
  for (const Pass& pass : block->passes) pass_ids.Append(pass.id);
  CsvReader reader(FolderOf(folder) / file, columns);
  Looks& looks = block->looks;
  std::size_t rejected = 0;
  while (reader.Next()) {
    if (!reader.Flag(2)) continue;
    const std::uint32_t pass = FindPass(reader, 0, pass_ids);
    const std::uint32_t point = FindPoint(reader, 1, block->points.ids);
    const auto begin = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point]);
    const auto end = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point + 1]);
    const auto at = std::find(begin, end, pass);
    if (at == end) {
      reader.Fail(1,
                  "pass " + Quoted(reader.Text(0)) + " has no look of point " +
                      Quoted(reader.Text(1)) + " in this block");
    }
    std::uint8_t& flags = looks.flags[static_cast<std::size_t>(at - looks.pass.begin())];
    if ((flags & Looks::kRejected) == 0) ++rejected;
    flags = static_cast<std::uint8_t>(flags | Looks::kRejected);
  }
  block->points.ids.DropIndex();
  return rejected;
}

}  // namespace sarblock
