// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "block_file.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include "geometry/recorded_states.h"

namespace sarblock::files {
namespace {

// The table, with columns for what was measured: time and range, or line and pixel.
std::unique_ptr<TableReader> OpenLooks(const BlockReading& reading) {
  auto reader = reading.source.Require("observations", kLookColumns);
  const bool image = reader->Has(kLookColumns("line")) && reader->Has(kLookColumns("pixel"));
  if (!image && reading.options.measurements == Measurements::kRequired) {
    reader->RequireColumn(kLookColumns("time_s"));
    reader->RequireColumn(kLookColumns("range_m"));
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
RadarCoordinates ReadRadar(const Row& row, Measurements measurements) {
  const bool required = measurements == Measurements::kRequired;
  const RadarCoordinates radar{
      required ? row.RequiredNumber(kLookColumns("time_s")) : row.Number(kLookColumns("time_s")),
      row.PositiveNumber(kLookColumns("range_m"))};
  if (required && std::isnan(radar.range_m))
    row.Fail(kLookColumns("range_m"), "is empty, a number is needed");
  static_cast<void>(LengthNumber(row, kLookColumns("range_m")));
  return radar;
}

RadarCoordinates ReadImage(const Row& row, const Pass& pass) {
  for (const std::size_t column : {kLookColumns("time_s"), kLookColumns("range_m")}) {
    if (row.Given(column)) {
      row.Fail(column, "excludes line and pixel; give one of both");
    }
  }
  if (!pass.image) {
    row.Fail(kLookColumns("line"),
             "pass " + Quoted(pass.id) +
                 " has no [pass.image] in block.toml, which line and pixel need");
  }
  const ImageCoordinates image{row.RequiredNumber(kLookColumns("line")),
                               row.RequiredNumber(kLookColumns("pixel"))};
  const auto radar = RadarFromImage(*pass.image, image);
  if (!radar) {
    row.Fail(kLookColumns("pixel"),
             NumberText(image.pixel_px) + " has no slant range in the image of pass " +
                 Quoted(pass.id) + ": ranges must be above 0 and grow with the pixel there");
  }
  return *radar;
}

std::string WrapHint(const FlightPath& path, double time_s) {
  const double wrap_s = WrapOf_s(path, time_s);
  if (wrap_s == 0.0) return "";
  return "; " + NumberText(std::abs(wrap_s)) + " s " + (wrap_s > 0.0 ? "later" : "earlier") +
         " it is on it: seconds of the " + (std::abs(wrap_s) > 86400.0 ? "week" : "day") +
         " that begin again";
}

/// What a row says to take off: range_delay_m, time_shift_s.
struct GivenReduction {
  double range_m = 0.0, time_s = 0.0;
};
GivenReduction ReadGivenReduction(const Row& row) {
  // The ionosphere delays long waves by some hundreds of metres; a shift of a second would be an
  // error of the clock, which is a correction to estimate.
  constexpr double kLargest_m = 10e3, kLargest_s = 1.0;
  const auto bounded = [&row](std::size_t column, double largest) {
    const double value = row.Number(column);
    if (std::abs(value) > largest) {
      row.Fail(column,
               "must be between -" + NumberText(largest) + " and " + NumberText(largest) +
                   ", got " + NumberText(value));
    }
    return std::isnan(value) ? 0.0 : value;
  };
  return {bounded(kLookColumns("range_delay_m"), kLargest_m),
          bounded(kLookColumns("time_shift_s"), kLargest_s)};
}

RadarCoordinates ReadMeasured(const Row& row, const Pass& pass, const ReadOptions& options) {
  const bool image = row.Given(kLookColumns("line")) || row.Given(kLookColumns("pixel"));
  const RadarCoordinates radar =
      image ? ReadImage(row, pass) : ReadRadar(row, options.measurements);
  if (options.contradictions == Contradictions::kKeep || row.Flag(kLookColumns("rejected"))) {
    return radar;  // what takes no part contradicts nothing
  }
  if (radar.time_s < pass.path.start_s() || radar.time_s > pass.path.end_s()) {
    row.Fail(image ? kLookColumns("line") : kLookColumns("time_s"),
             (image ? "time " : "") + NumberText(radar.time_s) +
                 " is outside the flight path of pass " + Quoted(pass.id) + ", which goes from " +
                 NumberText(pass.path.start_s()) + " to " + NumberText(pass.path.end_s()) + " s" +
                 WrapHint(pass.path, radar.time_s));
  }
  return radar;
}

double ReadSquint(const Row& row) {
  const double squint_deg = row.Number(kLookColumns("squint_deg"));
  if (!(std::abs(squint_deg) < 90.0)) {
    row.Fail(kLookColumns("squint_deg"),
             "must be between -90 and 90, got " + NumberText(squint_deg));
  }
  return squint_deg * kRadPerDeg;
}

double ReadDoppler(const Row& row, const Pass& pass, double time_s, Contradictions contradictions) {
  const double doppler_hz = row.Number(kLookColumns("doppler_hz"));
  if (std::isnan(pass.wavelength_m)) {
    row.Fail(kLookColumns("doppler_hz"),
             "pass " + Quoted(pass.id) +
                 " has no wavelength_m in block.toml, which a Doppler "
                 "centroid needs");
  }
  if (std::isnan(time_s) || contradictions == Contradictions::kKeep) return doppler_hz;
  if (const auto motion = pass.path.At(time_s)) {
    const double largest_hz = 2.0 * motion->velocity_mps.norm() / pass.wavelength_m;
    if (!(std::abs(doppler_hz) < largest_hz)) {
      row.Fail(kLookColumns("doppler_hz"),
               "must be less than 2 |v| / wavelength = " + NumberText(largest_hz) +
                   " in magnitude, got " + NumberText(doppler_hz));
    }
  }
  return doppler_hz;
}

// Squint [rad] or Doppler [Hz], that of the pass where the row gives none, and the flag that says
// which.
double ReadCone(const Row& row,
                const Pass& pass,
                double time_s,
                Contradictions contradictions,
                std::uint8_t* flags) {
  const bool squint = row.Given(kLookColumns("squint_deg")),
             doppler = row.Given(kLookColumns("doppler_hz"));
  if (squint && doppler) {
    row.Fail(kLookColumns("doppler_hz"), "excludes squint_deg; give one of both");
  }
  if (doppler) *flags |= Looks::kDoppler;
  return doppler  ? ReadDoppler(row, pass, time_s, contradictions)
         : squint ? ReadSquint(row)
                  : pass.squint_rad;
}

// The one number above 0 that the row gives among `columns`; its column, or nothing.
template <std::size_t kCount>
std::optional<std::size_t> OneOfColumns(const Row& row,
                                        const std::array<std::size_t, kCount>& columns,
                                        double* value) {
  std::optional<std::size_t> found;
  for (const std::size_t column : columns) {
    const double number = row.PositiveNumber(column);
    if (std::isnan(number)) continue;
    if (found) {
      row.Fail(column, "excludes " + row.Place(*found).field + "; give one of both");
    }
    found = column;
    *value = number;
  }
  return found;
}

const ImageGrid& RequireImage(const Row& row, const Pass& pass, std::size_t column) {
  if (!pass.image) {
    row.Fail(column,
             "pass " + Quoted(pass.id) +
                 " has no [pass.image] in block.toml, which a standard deviation in pixels "
                 "needs");
  }
  return *pass.image;
}

double ReadAzimuthSigma(const Row& row, const Pass& pass, std::uint8_t* flags) {
  double sigma = kNotGiven;
  static constexpr std::array<std::size_t, 4> kColumns{kLookColumns("azimuth_sigma_m"),
                                                       kLookColumns("time_sigma_s"),
                                                       kLookColumns("doppler_sigma_hz"),
                                                       kLookColumns("line_sigma_px")};
  const auto column = OneOfColumns(row, kColumns, &sigma);
  if (!column && std::isnan(pass.sigma.azimuth)) {
    row.Fail(kLookColumns("azimuth_sigma_m"),
             "no standard deviation of azimuth: neither this row, pass " + Quoted(pass.id) +
                 " nor [sigma] of block.toml gives one");
  }
  if (column == kLookColumns("line_sigma_px"))
    sigma *= RequireImage(row, pass, kLookColumns("line_sigma_px")).line_interval_s;
  if (column == kLookColumns("time_sigma_s") || column == kLookColumns("line_sigma_px"))
    *flags |= Looks::kAzimuthSeconds;
  if (column == kLookColumns("doppler_sigma_hz")) *flags |= Looks::kAzimuthHertz;
  const bool measured = column ? column == kLookColumns("doppler_sigma_hz")
                               : pass.sigma.azimuth_unit == AzimuthUnit::kHertz;
  if (measured && (*flags & Looks::kDoppler) == 0) {
    row.Fail(kLookColumns("doppler_hz"),
             "is empty, but " +
                 (column ? "this row has doppler_sigma_hz"
                         : "the standard deviation of azimuth of pass " + Quoted(pass.id) +
                               " is one of Doppler") +
                 ": give the measured Doppler, or the standard deviation as azimuth_sigma_m or "
                 "time_sigma_s");
  }
  return sigma;
}

double ReadRangeSigma(const Row& row,
                      const Pass& pass,
                      double pass_pixel_sigma_px,
                      const RadarCoordinates& radar) {
  double sigma = kNotGiven;
  static constexpr std::array<std::size_t, 2> kColumns{kLookColumns("range_sigma_m"),
                                                       kLookColumns("pixel_sigma_px")};
  auto column = OneOfColumns(row, kColumns, &sigma);
  if (!column && !std::isnan(pass_pixel_sigma_px)) {
    column = kLookColumns("pixel_sigma_px");
    sigma = pass_pixel_sigma_px;
  }
  if (!column && std::isnan(pass.sigma.range_m)) {
    row.Fail(kLookColumns("range_sigma_m"),
             "no standard deviation of range: neither this row, pass " + Quoted(pass.id) +
                 " nor [sigma] of block.toml gives one");
  }
  if (column != kLookColumns("pixel_sigma_px")) return sigma;
  const auto pixel_m =
      SlantRangePerPixel_m(RequireImage(row, pass, kLookColumns("pixel_sigma_px")), radar);
  if (!pixel_m) {
    row.Fail(kLookColumns("pixel_sigma_px"),
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
  const Duplicate found = FindDuplicate(block, old_of_new);
  if (found.second == std::numeric_limits<std::size_t>::max()) return;
  const auto table = OpenLooks(reading);
  std::size_t at = 0;
  std::string first_line;
  ForRows(table.get(), [&](const Row& row) {
    if (at == found.first) first_line = table->NameOfLine(row.line());
    if (at++ < found.second) return;
    row.Fail(kLookColumns("point"),
             "pass " + Quoted(row.Text(kLookColumns("pass"))) + " sees point " +
                 Quoted(block.points.ids[found.point]) + " twice, first on " + first_line +
                 "; one look per pass and point is allowed");
  });
}

/// Columns of which a row that gives nothing is as the pass says.
constexpr std::array kOwn{kLookColumns("squint_deg"),
                          kLookColumns("doppler_hz"),
                          kLookColumns("range_sigma_m"),
                          kLookColumns("azimuth_sigma_m"),
                          kLookColumns("time_sigma_s"),
                          kLookColumns("doppler_sigma_hz"),
                          kLookColumns("line_sigma_px"),
                          kLookColumns("pixel_sigma_px")};

/// Reads rows, as looks without offsets, up to the first with an error, which the batch keeps.
void ReadRows(const BlockReading& reading, Batch* batch, Looks* rows) {
  Looks& looks = *rows = {};
  IdFinder passes("pass", reading.pass_ids, "block.toml");
  // Where no row gives any of these a pass is the same in all of its rows, and checked in the
  // first.
  const bool own = std::any_of(
      kOwn.begin(), kOwn.end(), [&](auto i) { return !batch->columns[i].numbers.empty(); });
  const bool reduced = !batch->columns[kLookColumns("range_delay_m")].numbers.empty() ||
                       !batch->columns[kLookColumns("time_shift_s")].numbers.empty();
  std::vector<bool> same(reading.result.block.passes.size(), false);
  const auto read_row = [&](const Row& row) {
    const std::uint32_t pass_index = passes.Find(row, kLookColumns("pass"));
    const Pass& pass = reading.result.block.passes[pass_index];
    static_cast<void>(row.Id(kLookColumns("point")));
    std::uint8_t flags = row.Flag(kLookColumns("rejected")) ? Looks::kRejected : 0;
    const RadarCoordinates radar = ReadMeasured(row, pass, reading.options);
    double cone = pass.squint_rad, range_sigma_m = kNotGiven, azimuth_sigma = kNotGiven;
    if (!same[pass_index]) {
      const double pixel_sigma_px = reading.pixel_sigma_px[pass_index];
      cone = ReadCone(row, pass, radar.time_s, reading.options.contradictions, &flags);
      range_sigma_m = ReadRangeSigma(row, pass, pixel_sigma_px, radar);
      azimuth_sigma = ReadAzimuthSigma(row, pass, &flags);
      same[pass_index] = !own && std::isnan(pixel_sigma_px);
    }
    const GivenReduction reduction = reduced ? ReadGivenReduction(row) : GivenReduction{};
    if (reduced && radar.range_m <= reduction.range_m) {
      row.Fail(kLookColumns("range_delay_m"),
               "must be less than the range, " + NumberText(radar.range_m) + ", got " +
                   NumberText(reduction.range_m));
    }
    Append(reduction.range_m, 0.0, row.number(), &looks.range_delay_m);
    Append(reduction.time_s, 0.0, row.number(), &looks.time_shift_s);
    Append(cone, 0.0, row.number(), &looks.cone);
    Append(range_sigma_m, kNotGiven, row.number(), &looks.range_sigma_m);
    Append(azimuth_sigma, kNotGiven, row.number(), &looks.azimuth_sigma);
    looks.time_s.push_back(radar.time_s - reduction.time_s);
    looks.range_m.push_back(radar.range_m - reduction.range_m);
    looks.pass.push_back(pass_index);
    looks.flags.push_back(flags);
  };
  try {
    for (std::size_t row = 0; row < batch->rows; ++row) read_row(Row(*batch, row));
  } catch (const InputError&) {
    batch->error = std::current_exception();
  }
}

template <typename Value>
void Concatenate(const std::vector<Value>& part, std::size_t, std::vector<Value>* all) {
  all->insert(all->end(), part.begin(), part.end());
}

/// The same of a column that begins to exist with its first value other than `standard`.
void Concatenate(const std::vector<double>& part,
                 std::size_t rows_before,
                 std::vector<double>* all,
                 double standard) {
  if (part.empty() && all->empty()) return;
  all->resize(rows_before, standard);
  Concatenate(part, rows_before, all);
}

/// Rows behind those of `all`.
void AppendRows(const Looks& part, Looks* all) {
  const std::size_t before = all->size();
  Looks::ForColumns([&](const char*, auto column, auto... standard) {
    Concatenate(part.*column, before, &(all->*column), standard...);
  });
}

/// The point of an id; a tie point that points.csv does not name, if it is new. `likely` is its
/// number where a file has its ids in the order of the points.
std::uint32_t FindOrAddPoint(std::string_view id, std::uint32_t likely, Points* points) {
  if (likely < points->size() && points->ids[likely] == id) return likely;
  const std::uint32_t point = points->ids.FindOrAppend(id);
  if (point == points->size()) {
    points->role.push_back(PointRole::kTie);
    points->given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
  }
  return point;
}

}  // namespace

void ReadLooks(BlockReading* reading) {
  auto table = OpenLooks(*reading);
  WarnOfUnknownColumns(*table, &reading->result.warnings);
  Points& points = reading->result.block.points;
  Looks looks;
  std::vector<std::uint32_t> point_of_look;
  const std::size_t expected = table->RowsLeft();
  ReserveInLargePages(expected, &looks.time_s);
  ReserveInLargePages(expected, &looks.range_m);
  ReserveInLargePages(expected, &looks.pass);
  ReserveInLargePages(expected, &looks.flags);
  ReserveInLargePages(expected, &point_of_look);
  static_cast<void>(reading->pass_ids.Find({}));  // builds the index, which threads only read
  FoundTexts found;
  const auto read = [&](Batch* batch, Looks* part) { ReadRows(*reading, batch, part); };
  const auto append = [&](Batch* batch, Looks* part) {
    constexpr std::size_t kId = kLookColumns("point");
    for (std::size_t i = 0; i < part->size(); ++i) {
      const Row row(*batch, i);
      const std::uint32_t likely = batch->columns[kId].indices[i];
      point_of_look.push_back(
          found.Of(row, kId, [&] { return FindOrAddPoint(row.Text(kId), likely, &points); }));
    }
    AppendRows(*part, &looks);
    Step(reading->options.progress, "read", looks.size(), 0, "looks");
  };
  ForBatches<Looks>(table.get(), read, append);
  Looks::ForColumns([&](const char*, auto column, auto... standard) {
    // The last rows gave none.
    if (!(looks.*column).empty()) (looks.*column).resize(looks.size(), standard...);
  });
  WarnOfDoubts(*table, &reading->result.warnings);
  table.reset();  // sorting takes the most memory
  Looks& sorted = reading->result.block.looks;
  sorted = std::move(looks);
  RefuseDuplicates(*reading, SortLooksByPoint(point_of_look, points.size(), &sorted));
}

}  // namespace sarblock::files
