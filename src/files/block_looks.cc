// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <utility>
#include <vector>

#include "block_reader.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"

namespace sarblock {
namespace {

enum {
  kObservedPass,
  kObservedPoint,
  kObservedTime,
  kObservedRange,
  kObservedSquint,
  kObservedDoppler,
  kObservedRangeSigma,
  kObservedAzimuthSigma,
  kObservedTimeSigma,
  kObservedDopplerSigma,
  kObservedRejected,
  kObservedLine,
  kObservedPixel,
  kObservedLineSigma,
  kObservedPixelSigma
};

// The table, with columns for what was measured: time and range, or line and pixel.
std::unique_ptr<TableReader> OpenLooks(const BlockReading& reading) {
  auto reader = reading.source.Require("observations", kObservationColumns);
  const bool image = reader->Has(kObservedLine) && reader->Has(kObservedPixel);
  if (!image && reading.options.measurements == Measurements::kRequired) {
    reader->RequireColumn(kObservedTime);
    reader->RequireColumn(kObservedRange);
  }
  return reader;
}

// Appends to a column that begins to exist with its first value other than `standard`.
void Append(double value, double standard, std::size_t row, std::vector<double>* column) {
  const bool is_standard = value == standard || (std::isnan(value) && std::isnan(standard));
  if (column->empty() && is_standard) return;
  column->resize(row, standard);
  column->push_back(value);
}

// Time and range as they stand; NaN where a plan gives none.
RadarCoordinates ReadRadar(const TableReader& reader, Measurements measurements) {
  const bool required = measurements == Measurements::kRequired;
  const RadarCoordinates radar{
      required ? reader.RequiredNumber(kObservedTime) : reader.Number(kObservedTime),
      PositiveNumber(reader, kObservedRange)};
  if (required && std::isnan(radar.range_m))
    reader.Fail(kObservedRange, "is empty, a number is needed");
  static_cast<void>(LengthNumber(reader, kObservedRange));
  return radar;
}

RadarCoordinates ReadImage(const TableReader& reader, const Pass& pass) {
  for (const std::size_t column : {kObservedTime, kObservedRange}) {
    if (reader.Given(column)) {
      reader.Fail(column, "stands beside line and pixel, one of both is allowed");
    }
  }
  if (!pass.image) {
    reader.Fail(kObservedLine,
                "pass " + Quoted(pass.id) +
                    " has no [pass.image] in block.toml, which line and pixel need");
  }
  const ImageCoordinates image{reader.RequiredNumber(kObservedLine),
                               reader.RequiredNumber(kObservedPixel)};
  const auto radar = RadarFromImage(*pass.image, image);
  if (!radar) {
    reader.Fail(kObservedPixel,
                NumberText(image.pixel_px) + " has no slant range in the image of pass " +
                    Quoted(pass.id) + ": ranges must be above 0 and grow with the pixel there");
  }
  return *radar;
}

RadarCoordinates ReadMeasured(const TableReader& reader,
                              const Pass& pass,
                              const ReadOptions& options) {
  const bool image = reader.Given(kObservedLine) || reader.Given(kObservedPixel);
  const RadarCoordinates radar =
      image ? ReadImage(reader, pass) : ReadRadar(reader, options.measurements);
  if (options.contradictions == Contradictions::kKeep) return radar;
  if (radar.time_s < pass.path.start_s() || radar.time_s > pass.path.end_s()) {
    reader.Fail(image ? kObservedLine : kObservedTime,
                (image ? "time " : "") + NumberText(radar.time_s) +
                    " is outside the flight path of pass " + Quoted(pass.id) +
                    ", which goes from " + NumberText(pass.path.start_s()) + " to " +
                    NumberText(pass.path.end_s()) + " s");
  }
  return radar;
}

double ReadSquint(const TableReader& reader) {
  const double squint_deg = reader.Number(kObservedSquint);
  if (!(std::abs(squint_deg) < 90.0)) {
    reader.Fail(kObservedSquint,
                NumberText(squint_deg) + " is not allowed, -90 < squint_deg < 90 is");
  }
  return squint_deg * kRadPerDeg;
}

double ReadDoppler(const TableReader& reader, const Pass& pass, double time_s) {
  const double doppler_hz = reader.Number(kObservedDoppler);
  if (std::isnan(pass.wavelength_m)) {
    reader.Fail(kObservedDoppler,
                "pass " + Quoted(pass.id) +
                    " has no wavelength_m in block.toml, which a Doppler "
                    "centroid needs");
  }
  if (std::isnan(time_s)) return doppler_hz;
  if (const auto motion = pass.path.At(time_s)) {
    const double largest_hz = 2.0 * motion->velocity_mps.norm() / pass.wavelength_m;
    if (!(std::abs(doppler_hz) < largest_hz)) {
      reader.Fail(kObservedDoppler,
                  NumberText(doppler_hz) + " is not allowed, less than 2 |v| / wavelength = " +
                      NumberText(largest_hz) + " in magnitude is");
    }
  }
  return doppler_hz;
}

// Squint [rad] or Doppler [Hz], and the flag that tells which.
double ReadCone(const TableReader& reader, const Pass& pass, double time_s, std::uint8_t* flags) {
  const bool squint = reader.Given(kObservedSquint), doppler = reader.Given(kObservedDoppler);
  if (squint && doppler) {
    reader.Fail(kObservedDoppler, "stands beside squint_deg, one of both is allowed");
  }
  if (doppler) *flags |= Looks::kDoppler;
  return doppler ? ReadDoppler(reader, pass, time_s) : squint ? ReadSquint(reader) : 0.0;
}

// The one number above 0 that the row gives among `columns`; its column, or nothing.
template <std::size_t kCount>
std::optional<std::size_t> OneOfColumns(const TableReader& reader,
                                        const std::array<std::size_t, kCount>& columns,
                                        double* value) {
  std::optional<std::size_t> found;
  for (const std::size_t column : columns) {
    if (!reader.Has(column)) continue;
    const double number = PositiveNumber(reader, column);
    if (std::isnan(number)) continue;
    if (found) {
      reader.Fail(column,
                  "stands beside " + reader.Place(*found).field + ", one of both is allowed");
    }
    found = column;
    *value = number;
  }
  return found;
}

const ImageGrid& RequireImage(const TableReader& reader, const Pass& pass, std::size_t column) {
  if (!pass.image) {
    reader.Fail(column,
                "pass " + Quoted(pass.id) +
                    " has no [pass.image] in block.toml, which a standard deviation in pixels "
                    "needs");
  }
  return *pass.image;
}

double ReadAzimuthSigma(const TableReader& reader, const Pass& pass, std::uint8_t* flags) {
  double sigma = kNotGiven;
  static constexpr std::array<std::size_t, 4> kColumns{
      kObservedAzimuthSigma, kObservedTimeSigma, kObservedDopplerSigma, kObservedLineSigma};
  const auto column = OneOfColumns(reader, kColumns, &sigma);
  if (!column && std::isnan(pass.sigma.azimuth)) {
    reader.Fail(kObservedAzimuthSigma,
                "no standard deviation of azimuth: neither this row, pass " + Quoted(pass.id) +
                    " nor [sigma] of block.toml gives one");
  }
  if (column == kObservedLineSigma)
    sigma *= RequireImage(reader, pass, kObservedLineSigma).line_interval_s;
  if (column == kObservedTimeSigma || column == kObservedLineSigma)
    *flags |= Looks::kAzimuthSeconds;
  if (column == kObservedDopplerSigma) *flags |= Looks::kAzimuthHertz;
  const bool measured =
      column ? column == kObservedDopplerSigma : pass.sigma.azimuth_unit == AzimuthUnit::kHertz;
  if (measured && (*flags & Looks::kDoppler) == 0) {
    reader.Fail(kObservedDoppler,
                "is empty, but " +
                    (column ? "doppler_sigma_hz stands in this row"
                            : "the standard deviation of azimuth of pass " + Quoted(pass.id) +
                                  " is one of Doppler") +
                    ": give the measured Doppler, or the standard deviation as azimuth_sigma_m or "
                    "time_sigma_s");
  }
  return sigma;
}

double ReadRangeSigma(const TableReader& reader,
                      const Pass& pass,
                      double pass_pixel_sigma_px,
                      const RadarCoordinates& radar) {
  double sigma = kNotGiven;
  static constexpr std::array<std::size_t, 2> kColumns{kObservedRangeSigma, kObservedPixelSigma};
  auto column = OneOfColumns(reader, kColumns, &sigma);
  if (!column && !std::isnan(pass_pixel_sigma_px)) {
    column = kObservedPixelSigma;
    sigma = pass_pixel_sigma_px;
  }
  if (!column && std::isnan(pass.sigma.range_m)) {
    reader.Fail(kObservedRangeSigma,
                "no standard deviation of range: neither this row, pass " + Quoted(pass.id) +
                    " nor [sigma] of block.toml gives one");
  }
  if (column != kObservedPixelSigma) return sigma;
  const auto pixel_m = SlantRangePerPixel_m(RequireImage(reader, pass, kObservedPixelSigma), radar);
  if (!pixel_m) {
    reader.Fail(kObservedPixelSigma,
                "the size of a pixel of this look is not known: its range is not given or not in "
                "the image of pass " +
                    Quoted(pass.id));
  }
  return sigma * *pixel_m;
}

/// A look at a point that its pass has seen before, and that first look; rows of the table.
struct Duplicate {
  std::size_t first = 0, second = std::numeric_limits<std::size_t>::max(), point = 0;
};

// The one whose second look comes first in the table.
Duplicate FindDuplicate(const Block& block, const std::vector<std::uint32_t>& old_of_new) {
  constexpr std::size_t kPointsAtOnce = 65536;
  const Looks& looks = block.looks;
  const auto old_of = [&](std::size_t look) {
    return old_of_new.empty() ? look : old_of_new[look];
  };
  std::vector<Duplicate> pieces((block.points.size() + kPointsAtOnce - 1) / kPointsAtOnce);
  const auto find = [&](std::size_t piece, std::size_t begin, std::size_t end) {
    Duplicate& found = pieces[piece];
    for (std::size_t point = begin; point < end; ++point) {
      for (std::size_t i = looks.offsets[point] + 1; i < looks.offsets[point + 1]; ++i) {
        if (looks.pass[i] != looks.pass[i - 1] || old_of(i) >= found.second) continue;
        found = {old_of(i - 1), old_of(i), point};
      }
    }
  };
  ParallelForChunks(block.points.size(), kPointsAtOnce, find);
  Duplicate least;
  for (const Duplicate& found : pieces) {
    if (found.second < least.second) least = found;
  }
  return least;
}

// A point seen twice by a pass is refused; `old_of_new` is of SortLooksByPoint(). The lines are
// looked up only then, in a second scan.
void RefuseDuplicates(const BlockReading& reading, const std::vector<std::uint32_t>& old_of_new) {
  const Block& block = reading.result.block;
  const auto [first, second, point] = FindDuplicate(block, old_of_new);
  if (second == std::numeric_limits<std::size_t>::max()) return;
  const auto reader = OpenLooks(reading);
  std::size_t first_line = 0;
  for (std::size_t row = 0; row <= second && reader->Next(); ++row) {
    if (row == first) first_line = reader->line();
  }
  reader->Fail(kObservedPoint,
               "pass " + Quoted(reader->Text(kObservedPass)) + " sees point " +
                   Quoted(block.points.ids[point]) + " twice, first on " +
                   reader->NameOfLine(first_line) + "; one look per pass and point is allowed");
}

/// Rows of the table: looks without their offsets and the point of each.
struct LookRows {
  Looks looks;
  std::vector<std::uint32_t> point;
  IdTable new_points;  // that the block did not have when the rows were read
};

/// Columns of which a row that gives nothing is as the pass says.
constexpr std::array<std::size_t, 8> kOwn{kObservedSquint,
                                          kObservedDoppler,
                                          kObservedRangeSigma,
                                          kObservedAzimuthSigma,
                                          kObservedTimeSigma,
                                          kObservedDopplerSigma,
                                          kObservedLineSigma,
                                          kObservedPixelSigma};

/// By pass: times of rows that give time and range alone and need no more. None where the standard
/// deviations of the pass depend on the row or are missing.
using PlainTimes = std::vector<std::array<double, 2>>;

PlainTimes PlainTimesOf(const BlockReading& reading) {
  constexpr double kMost = std::numeric_limits<double>::max();
  PlainTimes times;
  for (std::size_t i = 0; i < reading.result.block.passes.size(); ++i) {
    const Pass& pass = reading.result.block.passes[i];
    const bool plain = std::isnan(reading.pixel_sigma_px[i]) && !std::isnan(pass.sigma.range_m) &&
                       !std::isnan(pass.sigma.azimuth) &&
                       pass.sigma.azimuth_unit != AzimuthUnit::kHertz;
    const bool any = reading.options.contradictions == Contradictions::kKeep;
    times.push_back(!plain ? std::array{kMost, -kMost}
                    : any  ? std::array{-kMost, kMost}
                           : std::array{pass.path.start_s(), pass.path.end_s()});
  }
  return times;
}

/// Rows that give time and range and nothing else, as whole columns of a part that no row has been
/// read of.
struct PlainRows {
  std::span<const double> time_s, range_m;  // in the part
  std::vector<std::uint32_t> pass, point;
  std::vector<std::uint8_t> flags;
};

bool GivesNothing(const TableReader& part, std::size_t column) {
  if (part.NoneAhead(column)) return true;
  const std::span<const double> values = part.NumbersAhead(column);
  return values.size() == part.RowCount() &&
         std::all_of(values.begin(), values.end(), [](double value) { return std::isnan(value); });
}

/// False, with the rows left as they were, where they are not plain or one of them is to be
/// refused: ReadRows() then reads them cell by cell and says why.
bool TakePlainRows(const PlainTimes& times, const TableReader& part, PlainRows* rows) {
  const std::size_t count = part.RowCount();
  const std::span<const double> time_s = part.NumbersAhead(kObservedTime),
                                range_m = part.NumbersAhead(kObservedRange);
  if (count == 0 || time_s.size() != count || range_m.size() != count) return false;
  const auto nothing = [&](std::size_t column) { return GivesNothing(part, column); };
  if (!std::all_of(kOwn.begin(), kOwn.end(), nothing) || !nothing(kObservedLine) ||
      !nothing(kObservedPixel) || !part.IndicesAhead(kObservedPass, &rows->pass) ||
      !part.IndicesAhead(kObservedPoint, &rows->point)) {
    return false;
  }
  bool plain = true;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<double, 2>& span_s = times[rows->pass[i]];
    plain &= time_s[i] >= span_s[0] && time_s[i] <= span_s[1] &&
             range_m[i] >= 1.0 / kLargestNumber && range_m[i] <= kLargestLength_m;
  }
  rows->flags.assign(count, 0);
  const std::span<const double> rejected = part.NumbersAhead(kObservedRejected);
  plain &= rejected.size() == count || !part.Has(kObservedRejected);
  for (std::size_t i = 0; i < rejected.size(); ++i) {
    rows->flags[i] = rejected[i] == 1.0 ? Looks::kRejected : 0;
    plain &= rejected[i] == 1.0 || std::isnan(rejected[i]) ||
             (rejected[i] == 0.0 && !std::signbit(rejected[i]));
  }
  rows->time_s = time_s;
  rows->range_m = range_m;
  return plain;
}

void Reserve(std::size_t count, LookRows* rows) {
  ReserveInLargePages(count, &rows->looks.time_s);
  ReserveInLargePages(count, &rows->looks.range_m);
  ReserveInLargePages(count, &rows->looks.pass);
  ReserveInLargePages(count, &rows->looks.flags);
  ReserveInLargePages(count, &rows->point);
}

/// Reads the rows of a part. Points that the block does not have are numbered from `known`.
void ReadRows(const BlockReading& reading, std::uint32_t known, TableReader* part, LookRows* rows) {
  TableReader& reader = *part;
  const IdTable& ids = reading.result.block.points.ids;
  Looks& looks = rows->looks;
  Reserve(reader.RowCount(), rows);
  // Without such columns a pass is the same in all of its rows, and checked in the first.
  const bool own = std::any_of(kOwn.begin(), kOwn.end(), [&](auto i) { return reader.Has(i); });
  std::vector<bool> same(reading.result.block.passes.size(), false);
  while (reader.Next()) {
    const std::size_t row = looks.size();
    const std::uint32_t pass_index = FindPass(reader, kObservedPass, reading.pass_ids);
    const Pass& pass = reading.result.block.passes[pass_index];
    const std::uint32_t point = reader.Lookup(kObservedPoint, [&] {
      const std::string_view id = reader.Id(kObservedPoint);
      const std::uint32_t found = ids.Find(id);
      return found != IdTable::kNone ? found : known + rows->new_points.FindOrAppend(id);
    });
    std::uint8_t flags = reader.Flag(kObservedRejected) ? Looks::kRejected : 0;
    const RadarCoordinates radar = ReadMeasured(reader, pass, reading.options);
    double cone = 0.0, range_sigma_m = kNotGiven, azimuth_sigma = kNotGiven;
    if (!same[pass_index]) {
      const double pixel_sigma_px = reading.pixel_sigma_px[pass_index];
      cone = ReadCone(reader, pass, radar.time_s, &flags);
      range_sigma_m = ReadRangeSigma(reader, pass, pixel_sigma_px, radar);
      azimuth_sigma = ReadAzimuthSigma(reader, pass, &flags);
      same[pass_index] = !own && std::isnan(pixel_sigma_px);
    }
    Append(cone, 0.0, row, &looks.cone);
    Append(range_sigma_m, kNotGiven, row, &looks.range_sigma_m);
    Append(azimuth_sigma, kNotGiven, row, &looks.azimuth_sigma);
    looks.time_s.push_back(radar.time_s);
    looks.range_m.push_back(radar.range_m);
    looks.pass.push_back(pass_index);
    looks.flags.push_back(flags);
    rows->point.push_back(point);
  }
}

/// A tie point that points.csv does not name, if it is new.
std::uint32_t FindOrAddPoint(std::string_view id, Points* points) {
  const std::uint32_t point = points->ids.FindOrAppend(id);
  if (point == points->size()) {
    points->role.push_back(PointRole::kTie);
    points->given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
  }
  return point;
}

template <typename Values, typename Value>
void Concatenate(const Values& part, std::vector<Value>* all) {
  all->insert(all->end(), part.begin(), part.end());
}

/// The same of a column that begins to exist with its first value other than `standard`.
void Concatenate(const std::vector<double>& part,
                 double standard,
                 std::size_t rows_before,
                 std::vector<double>* all) {
  if (part.empty() && all->empty()) return;
  all->resize(rows_before, standard);
  Concatenate(part, all);
}

void AppendRows(const PlainRows& part, LookRows* all) {
  Concatenate(part.time_s, &all->looks.time_s);
  Concatenate(part.range_m, &all->looks.range_m);
  Concatenate(part.pass, &all->looks.pass);
  Concatenate(part.flags, &all->looks.flags);
  Concatenate(part.point, &all->point);
}

/// Rows behind those of `all`. Points from `known` on are the part's new ones.
void AppendRows(const LookRows& part, std::uint32_t known, Points* points, LookRows* all) {
  std::vector<std::uint32_t> point_of_new;
  for (std::size_t i = 0; i < part.new_points.size(); ++i) {
    point_of_new.push_back(FindOrAddPoint(part.new_points[i], points));
  }
  const Looks& looks = part.looks;
  const std::size_t before = all->looks.size();
  Concatenate(looks.cone, 0.0, before, &all->looks.cone);
  Concatenate(looks.range_sigma_m, kNotGiven, before, &all->looks.range_sigma_m);
  Concatenate(looks.azimuth_sigma, kNotGiven, before, &all->looks.azimuth_sigma);
  Concatenate(looks.time_s, &all->looks.time_s);
  Concatenate(looks.range_m, &all->looks.range_m);
  Concatenate(looks.pass, &all->looks.pass);
  Concatenate(looks.flags, &all->looks.flags);
  for (const std::uint32_t point : part.point) {
    all->point.push_back(point < known ? point : point_of_new[point - known]);
  }
}

/// What the cells of a part name, where its texts stand once: points that are new are added in the
/// order of the rows. False where the texts have to be found row by row.
bool FindAhead(const TableReader& part, BlockReading* reading) {
  const auto find_pass = [&](std::string_view id) { return reading->pass_ids.Find(id); };
  const auto find_point = [&](std::string_view id) {
    if (TableReader::ProblemOfId(id) != nullptr) return TableReader::kUnknown;
    return FindOrAddPoint(id, &reading->result.block.points);
  };
  const bool passes = part.LookupAhead(kObservedPass, find_pass);
  return part.LookupAhead(kObservedPoint, find_point) && passes;
}

/// Some rows as a thread has read them.
struct LookPart {
  std::unique_ptr<TableReader> reader;
  PlainRows plain;
  LookRows rows;
  std::uint32_t known = 0;  // points of the block when these were begun
  bool found = false;       // all that they name, ahead
  bool is_plain = false;
};

/// The rows of a table, by all threads; in their order, as if one had read them. An error is that
/// of the first row with one.
void ReadParts(TableReader* reader, BlockReading* reading, LookRows* rows) {
  Points& points = reading->result.block.points;
  const PlainTimes times = PlainTimesOf(*reading);
  std::vector<LookPart> parts(ItemsAtOnce());
  std::shared_mutex new_points;  // found by a row: none is looked up while they are added
  bool begun = false, found = true;
  const auto next = [&](std::size_t place) {
    LookPart& part = parts[place];
    part.reader = reader->Part();
    if (part.reader == nullptr) return false;
    part.found = found = found && FindAhead(*part.reader, reading);
    if (!begun) {  // builds the indices, which threads only read from then on
      static_cast<void>(reading->pass_ids.Find({}));
      if (!found) static_cast<void>(points.ids.Find({}));
    }
    begun = true;
    return true;
  };
  const auto read = [&](std::size_t place) {
    LookPart& part = parts[place];
    part.is_plain = TakePlainRows(times, *part.reader, &part.plain);
    if (part.is_plain) return;
    std::shared_lock lock(new_points, std::defer_lock);
    if (!part.found) lock.lock();
    part.known = part.found ? IdTable::kNone : static_cast<std::uint32_t>(points.size());
    part.rows = {};
    ReadRows(*reading, part.known, part.reader.get(), &part.rows);
  };
  const auto append = [&](std::size_t place) {
    LookPart& part = parts[place];
    if (part.is_plain) {
      AppendRows(part.plain, rows);
    } else {
      std::unique_lock lock(new_points, std::defer_lock);
      if (part.rows.new_points.size() > 0) lock.lock();
      AppendRows(part.rows, part.known, &points, rows);
    }
    part.reader.reset();
    Step(reading->options.progress, "read", rows->looks.size(), 0, "looks");
  };
  PipeInOrder(parts.size(), next, read, append);
  Looks& looks = rows->looks;
  const auto fill = [&looks](double standard, std::vector<double>* column) {
    if (!column->empty()) column->resize(looks.size(), standard);  // the last rows gave none
  };
  fill(0.0, &looks.cone);
  fill(kNotGiven, &looks.range_sigma_m);
  fill(kNotGiven, &looks.azimuth_sigma);
}

}  // namespace

void ReadLooks(BlockReading* reading) {
  auto opened = OpenLooks(*reading);
  TableReader& reader = *opened;
  WarnOfUnknownColumns(reader, &reading->result.warnings);
  const Points& points = reading->result.block.points;
  LookRows rows;
  Reserve(reader.RowCount(), &rows);
  ReadParts(&reader, reading, &rows);
  opened.reset();  // sorting takes the most memory
  Looks& looks = reading->result.block.looks;
  looks = std::move(rows.looks);
  RefuseDuplicates(*reading, SortLooksByPoint(rows.point, points.size(), &looks));
}

}  // namespace sarblock
