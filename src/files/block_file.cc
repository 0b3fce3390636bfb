// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/block_file.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/geometry/path.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "block/plausibility.h"
#include "block/read_recorded.h"
#include "block_file.h"
#include "core/text.h"
#include "core/threads.h"
#include "tables/open.h"
#include "tables/toml.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sarblock::files {

namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// An id as one that was typed again would be: without blanks (no-break ones too), zeros before
/// digits, and the difference of capitals.
std::string NearKey(std::string_view id) {
  std::string simple;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id.substr(i).starts_with("\xC2\xA0")) {
      ++i;
    } else if (id[i] == '0' && (simple.empty() || !IsDigit(simple.back())) && i + 1 < id.size() &&
               IsDigit(id[i + 1])) {
      continue;
    } else if (id[i] != ' ' && id[i] != '\t') {
      simple += static_cast<char>(std::tolower(static_cast<unsigned char>(id[i])));
    }
  }
  return simple;
}

/// The id in quotes, with words for blanks that do not show.
std::string Shown(std::string_view id) {
  std::string shown(id);
  for (std::size_t at = 0; (at = shown.find("\xC2\xA0", at)) != std::string::npos;) {
    shown.replace(at, 2, "<no-break space>");
  }
  return Quoted(shown);
}

/// Warns of known points without a look whose names are nearly those of points that have looks and
/// do not stand in the table of points, of which there are `listed`.
void WarnOfNearNames(std::size_t listed, BlockReading* reading) {
  const Points& points = reading->result.block.points;
  const Looks& looks = reading->result.block.looks;
  std::map<std::string, std::uint32_t> missing;
  for (const KnownPosition& known : points.known) {
    if (looks.offsets[known.point] != looks.offsets[known.point + 1]) continue;
    missing.emplace(NearKey(points.ids[known.point]), known.point);
  }
  std::vector<std::string> pairs;
  std::size_t found = 0;
  for (std::size_t i = listed; i < points.size() && !missing.empty(); ++i) {
    const auto known = missing.find(NearKey(points.ids[i]));
    if (known == missing.end()) continue;
    constexpr std::size_t kNamed = 5;
    if (++found > kNamed) continue;
    pairs.push_back(Shown(points.ids[known->second]) + " and " + Shown(points.ids[i]));
  }
  if (found == 0) return;
  std::string text = fmt::format("{}", fmt::join(pairs, ", "));
  if (found > pairs.size()) text += fmt::format(" and {} more", found - pairs.size());
  reading->result.warnings.push_back(
      fmt::format("{} known point{} no look, and the observations have nearly the same name{}: {}; "
                  "are they the same points?",
                  found,
                  found == 1 ? " has" : "s have",
                  found == 1 ? "" : "s",
                  text));
}

/// Names that begin with # are comments where they are not quoted: known points would be lost
/// without a word.
void RefuseCommentedPoints(std::size_t listed, const BlockReading& reading) {
  if (!reading.commented_point) return;
  const IdTable& ids = reading.result.block.points.ids;
  for (std::size_t i = listed; i < ids.size(); ++i) {
    if (!ids[i].starts_with('#')) continue;
    throw InputError(*reading.commented_point,
                     "a line that begins with # is a comment, and the observations name a point " +
                         Quoted(ids[i]) +
                         " that no other line gives: names that begin with # "
                         "stand in quotes");
  }
}

void WarnOfRejectedPasses(BlockReading* reading) {
  const Block& block = reading->result.block;
  std::vector<std::size_t> looks(block.passes.size(), 0), taken(block.passes.size(), 0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    ++looks[block.looks.pass[i]];
    taken[block.looks.pass[i]] += block.looks.rejected(i) ? 0U : 1U;
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i] == 0 || taken[i] > 0) continue;
    reading->result.warnings.push_back(
        fmt::format("pass {}: all {} looks are rejected, so it takes no part",
                    Quoted(block.passes[i].id),
                    looks[i]));
  }
}

/// Whether there are corrections of the path, all of them shared by the two passes.
bool SharePathCorrections(const AdjustTable& options,
                          const std::string& pass_a,
                          const std::string& pass_b) {
  std::size_t shared = 0;
  for (const CorrectionGroup& group : options.groups) {
    if (!std::holds_alternative<PositionCorrection>(group.model) &&
        !std::holds_alternative<VelocityCorrection>(group.model)) {
      continue;
    }
    const auto has = [&group](const std::string& id) {
      return group.passes.empty() ||
             std::find(group.passes.begin(), group.passes.end(), id) != group.passes.end();
    };
    const bool a = has(pass_a), b = has(pass_b);
    if (!a && !b) continue;
    if (!(a && b && group.shared)) return false;
    ++shared;
  }
  return shared > 0;
}

}  // namespace

BlockFile ReadBlockFrom(const TableSource& source, const ReadOptions& options) {
  BlockReading reading{source, options, {}, {}, {}, {}, {}};
  ReadBlockToml(&reading);
  ReadTrajectories(&reading);
  ReadPoints(&reading);
  const std::size_t listed = reading.result.block.points.size();
  ReadLooks(&reading);
  RefuseCommentedPoints(listed, reading);
  WarnOfNearNames(listed, &reading);
  WarnOfRejectedPasses(&reading);
  SetStripSpans(reading.strip_spans_s, &reading.result.block);
  RequireReductions(reading.result.block, reading.pass_places);
  if (options.contradictions == Contradictions::kRefuse) {
    RequireAboveGround(reading.result.block);
    RequireBodyFixedStates(reading.result.block);
  }
  for (std::string& warning : ReadRecordedFlights(&reading.result.block, reading.pass_places)) {
    reading.result.warnings.push_back(std::move(warning));
  }
  for (std::string& remark : DoubtsOfReductions(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  for (std::string& remark : ExaminePlausibility(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  const AdjustTable& adjust = reading.result.adjust;
  for (std::string& remark :
       FindSameFlights(reading.result.block, [&](std::size_t a, std::size_t b) {
         return SharePathCorrections(
             adjust, reading.result.block.passes[a].id, reading.result.block.passes[b].id);
       })) {
    reading.result.warnings.push_back(std::move(remark));
  }
  for (std::string& remark : FindSameKnownPoints(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  const Copies copies = FindCopiedPasses(reading.result.block);
  CountOnce(copies, &reading.result.block);
  for (const std::string& remark : copies.remarks) reading.result.warnings.push_back(remark);
  reading.result.block.points.ids.DropIndex();
  return std::move(reading.result);
}

BlockFile ReadBlock(const std::filesystem::path& folder, const ReadOptions& options) {
  const CancellationScope scope(options.progress);
  return ReadBlockFrom(*TablesAt(folder, FolderContent::kBlock), options);
}

BlockFile ReadBlockTexts(const BlockTexts& texts, const ReadOptions& options) {
  return ReadBlockFrom(*TablesOfTexts({{"block.toml", texts.block_toml},
                                       {"trajectories.csv", texts.trajectories_csv},
                                       {"observations.csv", texts.observations_csv},
                                       {"points.csv", texts.points_csv}},
                                      FolderContent::kBlock),
                       options);
}

std::uint32_t IdFinder::Find(const Row& row, std::size_t column) {
  return found_.Of(row, column, [&] {
    const std::string_view id = row.Id(column);
    const std::uint32_t found = ids_.Find(id);
    if (found == IdTable::kNone) {
      row.Fail(column,
               std::string(holder_) + " has no " + noun_ + " " + Quoted(id) +
                   DidYouMean(ids_.Nearest(id)));
    }
    return found;
  });
}

double LengthNumber(const Row& row, std::size_t column) {
  const double value_m = row.Number(column);
  if (std::abs(value_m) > kLargestLength_m) {
    row.Fail(column,
             "must be at most " + NumberText(kLargestLength_m) + " m, got " + NumberText(value_m) +
                 " m");
  }
  return value_m;
}

namespace {

class ArrayReader final : public TableReader {
 public:
  ArrayReader(const ArrayTable& table, Schema schema)
      : TableReader(table.name, schema),
        table_(table),
        rows_(table.columns.empty() ? 0 : table.columns.front().rows()),
        arrays_(schema.size()) {
    for (const ArrayColumn& array : table.columns) {
      const auto known = std::find(names_.begin(), names_.end(), array.name);
      if (known == names_.end()) {
        unknown_.push_back(array.name);
      } else {
        OpenArray(static_cast<std::size_t>(known - names_.begin()), array);
      }
    }
    RequireColumns();
  }

  bool Next(Batch* batch) override {
    if (next_ == rows_) return false;
    batch->first = next_;
    next_ += std::min(rows_ - next_, kRowsAtOnce);
    return true;
  }
  void Parse(Batch* batch) const override {
    batch->Begin(schema_);
    batch->table = this;
    batch->rows = std::min(rows_ - batch->first, kRowsAtOnce);
    for (std::size_t i = 0; i < schema_.size(); ++i) {
      Column& column = batch->columns[i];
      column.texts = Has(i) ? arrays_[i]->texts.get() : nullptr;
      if (!Has(i)) continue;
      const auto copy = [&](const auto& from, auto* to) {
        const auto rows = from.subspan(batch->first, batch->rows);
        to->assign(rows.begin(), rows.end());
      };
      if (column.texts == nullptr) {
        copy(arrays_[i]->cells, &column.numbers);
        continue;
      }
      copy(arrays_[i]->indices, &column.indices);
      if (IsText(schema_[i].kind)) continue;
      for (const std::uint32_t text : column.indices) {  // numbers are asked for
        column.numbers.push_back(NumberOfText((*column.texts)[text], schema_[i].kind));
      }
      column.texts = nullptr;
    }
  }
  std::size_t RowsLeft() const override { return rows_ - next_; }
  std::string TextOfCell(const Row& row, std::size_t column) const override {
    const ArrayColumn& array = *arrays_[column];
    const std::size_t cell = row.line() - 1;
    return array.texts != nullptr ? std::string((*array.texts)[array.indices[cell]])
                                  : NumberText(array.cells[cell]);
  }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    std::string field = file_ + "." + names_[column];
    if (line > 0) field += "[" + std::to_string(line - 1) + "]";
    return {{}, 0, std::move(field)};
  }
  std::string NameOfLine(std::size_t line) const override {
    return "row " + std::to_string(line - 1);
  }

 private:
  void OpenArray(std::size_t column, const ArrayColumn& array) {
    const FilePlace place = PlaceAt(0, column);
    if (Has(column)) throw InputError(place, "is given twice; one column only");
    if (array.rows() != rows_) {
      throw InputError(place,
                       "has " + std::to_string(array.rows()) + " rows where " + file_ + "." +
                           table_.columns.front().name + " has " + std::to_string(rows_) +
                           ", as many are needed");
    }
    arrays_[column] = &array;
    place_[column] = column;
    for (std::size_t row = 0; array.texts != nullptr && row < rows_; ++row) {
      if (array.indices[row] < array.texts->size()) continue;
      throw InputError(PlaceAt(row + 1, column),
                       "must be an index below " + std::to_string(array.texts->size()) +
                           ", the number of texts, got " + std::to_string(array.indices[row]));
    }
    if (array.texts == nullptr && IsText(schema_[column].kind)) {
      throw InputError(place, "holds numbers, texts are needed");
    }
    for (std::size_t row = 0; row < array.cells.size(); ++row) {
      if (!std::isinf(array.cells[row])) continue;
      throw InputError(PlaceAt(row + 1, column),
                       "must be a finite number, got " + NumberText(array.cells[row]));
    }
  }
  std::string ColumnsThere() const override {
    std::string text = "there are ";
    for (const ArrayColumn& column : table_.columns) {
      text += (&column == &table_.columns.front() ? "" : ",") + column.name;
    }
    return text;
  }

  const ArrayTable& table_;
  std::size_t rows_;
  std::vector<const ArrayColumn*> arrays_;  // by column; null: not there
  std::size_t next_ = 0;
};

class ArraySource final : public TableSource {
 public:
  explicit ArraySource(const BlockArrays& arrays)
      : TableSource(FolderContent::kBlock), arrays_(arrays) {}
  std::pair<std::string, std::string> Read(std::string_view file) const override {
    return {std::string(file), std::string(arrays_.block_toml)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table, Schema schema) const override {
    for (const ArrayTable& held : arrays_.tables) {
      if (held.name == table) return std::make_unique<ArrayReader>(held, schema);
    }
    return nullptr;
  }
  std::string NameOf(std::string_view table) const override { return std::string(table); }
  std::string DefaultName() const override { return "block"; }

 private:
  const BlockArrays& arrays_;
};

}  // namespace

BlockFile ReadBlockArrays(const BlockArrays& arrays, const ReadOptions& options) {
  return ReadBlockFrom(ArraySource(arrays), options);
}

namespace {

namespace fs = std::filesystem;

void AppendSigma(const LookSigma& sigma, const std::string& infix, std::string* text) {
  if (!std::isnan(sigma.range_m)) {
    *text += "range" + infix + "_m = " + NumberText(sigma.range_m) + "\n";
  }
  if (!std::isnan(sigma.azimuth)) {
    const AzimuthUnit unit = sigma.azimuth_unit;
    const std::string key = unit == AzimuthUnit::kHertz     ? "doppler" + infix + "_hz"
                            : unit == AzimuthUnit::kSeconds ? "azimuth" + infix + "_s"
                                                            : "azimuth" + infix + "_m";
    *text += key + " = " + NumberText(sigma.azimuth) + "\n";
  }
}

bool SameNumber(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool SameSigma(const LookSigma& a, const LookSigma& b) {
  return SameNumber(a.range_m, b.range_m) && SameNumber(a.azimuth, b.azimuth) &&
         a.azimuth_unit == b.azimuth_unit;
}

bool SameTrajectory(const TrajectoryOptions& a, const TrajectoryOptions& b) {
  return a.through == b.through && SameNumber(a.sigma.position_m, b.sigma.position_m) &&
         SameNumber(a.sigma.velocity_mps, b.sigma.velocity_mps);
}

/// An inline table, empty for what is the default.
std::string TrajectoryText(const TrajectoryOptions& options) {
  if (SameTrajectory(options, {})) return "";
  std::string text = std::string("trajectory = { through = \"") + NameOf(options.through) + "\"";
  if (!std::isnan(options.sigma.position_m)) {
    text += ", sigma_m = " + NumberText(options.sigma.position_m);
  }
  if (!std::isnan(options.sigma.velocity_mps)) {
    text += ", sigma_mps = " + NumberText(options.sigma.velocity_mps);
  }
  return text + " }\n";
}

/// A number for people to read and change: 30, where the nearest double in degrees is not.
std::string ShortText(double value, double factor) {
  const std::string text = Digits(value / factor, 15);
  return std::strtod(text.c_str(), nullptr) * factor == value ? text
                                                              : NumberText(ToUnit(value, factor));
}

std::string SwathText(const Swath& swath) {
  const SwathKey& key = kSwathKeys[static_cast<std::size_t>(swath.kind)];
  return std::string(key.key) + " = [" + ShortText(swath.limits[0], key.factor) + ", " +
         ShortText(swath.limits[1], key.factor) + "]\n";
}

std::string FrameText(const Block& block) {
  if (block.frame.kind() == FrameKind::kLocal) return "[frame]\nkind = \"local\"\n";
  const Ellipsoid& ellipsoid = block.frame.ellipsoid();
  std::string text = "[frame]\nkind = \"geocentric\"\nellipsoid = ";
  const auto& names = EllipsoidNames();
  if (std::find(names.begin(), names.end(), ellipsoid.name) != names.end()) {
    text += TomlText(ellipsoid.name) + "\n";
  } else {
    text += "{ a_m = " + NumberText(ellipsoid.a_m) + ", f = " + NumberText(ellipsoid.flattening) +
            " }\n";
  }
  if (!block.realization.empty()) text += "realization = " + TomlText(block.realization) + "\n";
  if (!std::isnan(block.epoch_year)) text += "epoch = " + NumberText(block.epoch_year) + "\n";
  return text;
}

std::string BlockTomlText(const Block& block, const AdjustTable& adjust) {
  std::string text = "format = \"sarblock-block 1\"\nname = " + TomlText(block.name) + "\n";
  const bool one_trajectory =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameTrajectory(pass.recorded.asked, block.passes.front().recorded.asked);
      });
  if (one_trajectory) text += TrajectoryText(block.passes.front().recorded.asked);
  text += FrameText(block);
  const bool one_sigma =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameSigma(pass.sigma, block.passes.front().sigma);
      });
  if (one_sigma) {
    text += "[sigma]\n";
    AppendSigma(block.passes.front().sigma, "", &text);
  }
  const bool one_reduction =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return pass.reduction == block.passes.front().reduction;
      });
  if (one_reduction) text += ReductionText(block.passes.front().reduction, "reduction");
  text += DumpAdjustTable(adjust);
  for (const Pass& pass : block.passes) {
    text += "[[pass]]\nid = " + TomlText(pass.id) + "\nlook = ";
    text += pass.side == LookSide::kLeft ? "\"left\"\n" : "\"right\"\n";
    if (!std::isnan(pass.wavelength_m)) {
      text += "wavelength_m = " + NumberText(pass.wavelength_m) + "\n";
    }
    if (!one_sigma) AppendSigma(pass.sigma, "_sigma", &text);
    text += "start_s = " + NumberText(pass.start_s) + "\n";
    text += "end_s = " + NumberText(pass.end_s) + "\n";
    if (pass.squint_rad != 0.0) {
      text += "squint_deg = " + ShortText(pass.squint_rad, kRadPerDeg) + "\n";
    }
    if (pass.swath) text += SwathText(*pass.swath);
    if (!pass.epoch_utc.empty()) text += "epoch_utc = " + TomlText(pass.epoch_utc) + "\n";
    if (!one_trajectory) text += TrajectoryText(pass.recorded.asked);
    if (!one_reduction) text += ReductionText(pass.reduction, "pass.reduction");
    if (pass.image) text += ImageTableText(*pass.image);
  }
  return text;
}

void WritePoints(TableSink* sink, const Block& block) {
  constexpr const auto& kColumns = kPointColumns;
  constexpr std::array kSigmas = kColumns("sigma_e_m", "sigma_n_m", "sigma_u_m");
  constexpr std::array kCovariances = kColumns("cov_en_m2", "cov_eu_m2", "cov_nu_m2");
  constexpr std::array kMotion = kColumns("vx_mpy", "vy_mpy", "vz_mpy");
  const Points& points = block.points;
  // Positions are written in the axes of the frame, at its epoch.
  std::vector<std::string_view> left_out{"lat_deg", "lon_deg", "h_m", "frame", "epoch", "geoid"};
  const auto moves = [](const KnownPosition& known) { return !known.velocity_mpy.isZero(0.0); };
  if (std::none_of(points.known.begin(), points.known.end(), moves)) {
    for (const std::size_t column : kMotion) left_out.push_back(kColumns.columns[column].name);
  }
  const auto table = sink->Open("points", kColumns, left_out);
  constexpr const char* kRoles[] = {"tie", "control", "check"};
  WriteEach(points.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const auto index = static_cast<std::uint32_t>(i);
    NewRow row(batch);
    row.Id(kColumns("point"), points.ids, index);
    row.Text(kColumns("role"), kRoles[static_cast<std::size_t>(points.role[i])]);
    row.Numbers(kColumns("x_m", "y_m", "z_m"), points.given_m[i]);
    const KnownPosition* known = points.FindKnown(index);
    if (known == nullptr) return;
    const Eigen::Matrix3d& covariance = known->covariance_enu_m2;
    for (std::size_t k = 0; k < 3; ++k) {
      // A check point taken as exactly known is written without standard deviations.
      const double variance_m2 =
          covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k));
      if (variance_m2 > 0.0) row.Number(kSigmas[k], std::sqrt(variance_m2));
    }
    std::size_t k = 0;
    for (const auto& [a, b] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (covariance(a, b) != 0.0) row.Number(kCovariances[k], covariance(a, b));
      ++k;
    }
    if (moves(*known)) row.Numbers(kMotion, known->velocity_mpy);
  });
  table->Commit();
}

/// Whether the row of a look says its squint: it is not 0, or 0 in a pass with another one.
bool NeedsSquint(const Block& block, std::size_t look) {
  const Looks& looks = block.looks;
  return (!looks.cone.empty() && looks.cone[look] != 0.0) ||
         block.passes[looks.pass[look]].squint_rad != 0.0;
}

/// Columns of looks that a block does not need.
std::vector<std::string_view> ColumnsLeftOut(const Block& block) {
  const Looks& looks = block.looks;
  bool squint = false, doppler = false, range_sigma = false, rejected = false;
  std::array<bool, 3> azimuth{};  // by unit
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const bool by_doppler = (looks.flags[i] & Looks::kDoppler) != 0;
    doppler |= by_doppler;
    squint |= !by_doppler && NeedsSquint(block, i);
    rejected |= looks.rejected(i);
    range_sigma |= !looks.range_sigma_m.empty() && !std::isnan(looks.range_sigma_m[i]);
    if (!looks.azimuth_sigma.empty() && !std::isnan(looks.azimuth_sigma[i])) {
      azimuth[static_cast<std::size_t>(block.SigmaOf(i).azimuth_unit)] = true;
    }
  }
  std::vector<std::string_view> left_out{"line", "pixel", "line_sigma_px", "pixel_sigma_px"};
  for (const auto& [needed, column] :
       {std::pair{squint, "squint_deg"},
        std::pair{doppler, "doppler_hz"},
        std::pair{range_sigma, "range_sigma_m"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kMetres)], "azimuth_sigma_m"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kSeconds)], "time_sigma_s"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kHertz)], "doppler_sigma_hz"},
        std::pair{!looks.range_delay_m.empty(), "range_delay_m"},
        std::pair{!looks.time_shift_s.empty(), "time_shift_s"},
        std::pair{rejected, "rejected"}}) {
    if (!needed) left_out.emplace_back(column);
  }
  return left_out;
}

void WriteLooks(TableSink* sink, const Block& block, const IdTable& pass_ids) {
  constexpr const auto& kColumns = kLookColumns;
  const Looks& looks = block.looks;
  const auto table = sink->Open("observations", kColumns, ColumnsLeftOut(block));
  const auto write_look = [&](std::size_t i, std::size_t point, Batch* batch) {
    NewRow row(batch);
    row.Id(kColumns("pass"), pass_ids, looks.pass[i]);
    row.Id(kColumns("point"), block.points.ids, static_cast<std::uint32_t>(point));
    const RadarCoordinates measured = block.Measured(i);
    row.Number(kColumns("time_s"), measured.time_s).Number(kColumns("range_m"), measured.range_m);
    if (!looks.range_delay_m.empty()) {
      row.Number(kColumns("range_delay_m"), looks.range_delay_m[i]);
    }
    if (!looks.time_shift_s.empty()) row.Number(kColumns("time_shift_s"), looks.time_shift_s[i]);
    const double cone = looks.cone.empty() ? 0.0 : looks.cone[i];
    if ((looks.flags[i] & Looks::kDoppler) != 0) {
      row.Number(kColumns("doppler_hz"), cone);
    } else if (NeedsSquint(block, i)) {
      row.Number(kColumns("squint_deg"), ToUnit(cone, kRadPerDeg));
    }
    if (!looks.range_sigma_m.empty()) {
      row.Number(kColumns("range_sigma_m"), looks.range_sigma_m[i]);
    }
    if (!looks.azimuth_sigma.empty()) {
      const AzimuthUnit unit = block.SigmaOf(i).azimuth_unit;
      row.Number(unit == AzimuthUnit::kMetres    ? kColumns("azimuth_sigma_m")
                 : unit == AzimuthUnit::kSeconds ? kColumns("time_sigma_s")
                                                 : kColumns("doppler_sigma_hz"),
                 looks.azimuth_sigma[i]);
    }
    row.Integer(kColumns("rejected"), looks.rejected(i) ? 1 : 0);
  };
  WriteRows(looks.size(), table.get(), [&](std::size_t begin, std::size_t end, Batch* batch) {
    ForLooks(
        looks, begin, end, [&](std::size_t i, std::size_t point) { write_look(i, point, batch); });
  });
  table->Commit();
}

void WriteTruePoints(TableSink* sink, const Block& block, const Truth& truth) {
  constexpr const auto& kColumns = kTruthColumns;
  const auto table = sink->Open("truth", kColumns);
  WriteEach(truth.points_m.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const Eigen::Vector3d& p_m = truth.points_m[i];
    if (std::isnan(p_m.x())) return;
    NewRow(batch)
        .Id(kColumns("point"), block.points.ids, static_cast<std::uint32_t>(i))
        .Numbers(kColumns("x_m", "y_m", "z_m"), p_m);
  });
  table->Commit();
}

}  // namespace

void WritePaths(TableSink* sink,
                std::string_view name,
                const IdTable& pass_ids,
                const std::vector<FlightPath>& paths,
                const std::vector<std::string>& adjusted) {
  constexpr const auto& kColumns = kPathColumns;
  constexpr std::array<std::string_view, 1> kOfResults{"adjusted"};
  const auto table =
      adjusted.empty() ? sink->Open(name, kColumns, kOfResults) : sink->Open(name, kColumns);
  const auto write = [&](std::size_t begin, std::size_t end, Batch* batch) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const StateVector& state : paths[i].states()) {
        NewRow row(batch);
        row.Id(kColumns("pass"), pass_ids, static_cast<std::uint32_t>(i))
            .Number(kColumns("time_s"), state.time_s)
            .Numbers(kColumns("x_m", "y_m", "z_m"), state.position_m)
            .Numbers(kColumns("vx_mps", "vy_mps", "vz_mps"), state.velocity_mps);
        if (!adjusted.empty()) row.Text(kColumns("adjusted"), adjusted[i]);
      }
    }
  };
  WriteRows(paths.size(), table.get(), write, 1);
  table->Commit();
}

std::vector<FlightPath> NominalPaths(const Block& block) {
  std::vector<FlightPath> paths;
  for (const Pass& pass : block.passes) {
    if (pass.recorded.states.empty()) {
      paths.push_back(pass.path);
      continue;
    }
    std::vector<StateVector> states;
    for (const double time_s : PathTimes_s(pass)) {
      const std::optional<Motion> motion = pass.path.At(time_s);
      if (motion) states.push_back({time_s, motion->position_m, motion->velocity_mps});
    }
    paths.emplace_back(std::move(states));
  }
  return paths;
}

IdTable PassIds(const Block& block) {
  IdTable ids;
  for (const Pass& pass : block.passes) ids.Append(pass.id);
  return ids;
}

void WriteBlock(const fs::path& target,
                const Block& block,
                const AdjustTable& adjust,
                const Truth* truth,
                Compression compression) {
  const IdTable passes = PassIds(block);
  const BlockIds ids{&passes, &block.points.ids};
  WriteTables(FolderContent::kBlock, target, compression, ids, [&](TableSink* sink) {
    std::vector<FlightPath> recorded;
    for (const Pass& pass : block.passes) recorded.emplace_back(pass.RecordedStates());
    WritePaths(sink, "trajectories", passes, recorded);
    WriteLooks(sink, block, passes);
    WritePoints(sink, block);
    if (truth != nullptr && !truth->points_m.empty()) WriteTruePoints(sink, block, *truth);
    if (truth != nullptr && !truth->paths.empty()) {
      WritePaths(sink, "truth_passes", passes, truth->paths);
    }
    sink->WriteText("block.toml", kWrittenBySarblock + BlockTomlText(block, adjust));
  });
}

}  // namespace sarblock::files
