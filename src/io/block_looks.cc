// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/units.h"

#include <cmath>
#include <limits>

#include "block_reader.h"
#include "number.h"

namespace sarblock {
namespace {

enum {
  kPass,
  kPoint,
  kTime,
  kRange,
  kSquint,
  kDoppler,
  kRangeSigma,
  kAzimuthSigma,
  kTimeSigma,
  kRejected
};

std::array<CsvColumn, 10> Columns(Measurements measurements) {
  const CsvNeed measured =
      measurements == Measurements::kRequired ? CsvNeed::kRequired : CsvNeed::kOptional;
  return {{{"pass", CsvNeed::kRequired},
           {"point", CsvNeed::kRequired},
           {"time_s", measured},
           {"range_m", measured},
           {"squint_deg"},
           {"doppler_hz"},
           {"range_sigma_m"},
           {"azimuth_sigma_m"},
           {"time_sigma_s"},
           {"rejected"}}};
}

// Appends to a column that begins to exist with its first value other than `standard`.
void Append(double value, double standard, std::size_t row, std::vector<double>* column) {
  const bool is_standard = value == standard || (std::isnan(value) && std::isnan(standard));
  if (column->empty() && is_standard) return;
  column->resize(row, standard);
  column->push_back(value);
}

double ReadTime(const CsvReader& reader, const Pass& pass, Measurements measurements) {
  const double time_s =
      measurements == Measurements::kRequired ? reader.RequiredNumber(kTime) : reader.Number(kTime);
  if (time_s < pass.path.start_s() || time_s > pass.path.end_s()) {
    reader.Fail(kTime,
                NumberText(time_s) + " is outside the flight path of pass " + Quoted(pass.id) +
                    ", which goes from " + NumberText(pass.path.start_s()) + " to " +
                    NumberText(pass.path.end_s()) + " s");
  }
  return time_s;
}

double ReadSquint(const CsvReader& reader) {
  const double squint_deg = reader.Number(kSquint);
  if (!(std::abs(squint_deg) < 90.0)) {
    reader.Fail(kSquint, NumberText(squint_deg) + " is not allowed, -90 < squint_deg < 90 is");
  }
  return squint_deg * kRadPerDeg;
}

double ReadDoppler(const CsvReader& reader, const Pass& pass, double time_s) {
  const double doppler_hz = reader.Number(kDoppler);
  if (std::isnan(pass.wavelength_m)) {
    reader.Fail(kDoppler,
                "pass " + Quoted(pass.id) +
                    " has no wavelength_m in block.toml, which a Doppler "
                    "centroid needs");
  }
  if (std::isnan(time_s)) return doppler_hz;
  if (const auto motion = pass.path.At(time_s)) {
    const double largest_hz = 2.0 * motion->velocity_mps.norm() / pass.wavelength_m;
    if (!(std::abs(doppler_hz) < largest_hz)) {
      reader.Fail(kDoppler,
                  NumberText(doppler_hz) + " is not allowed, less than 2 |v| / wavelength = " +
                      NumberText(largest_hz) + " in magnitude is");
    }
  }
  return doppler_hz;
}

// Squint [rad] or Doppler [Hz], and the flag that tells which.
double ReadCone(const CsvReader& reader, const Pass& pass, double time_s, std::uint8_t* flags) {
  const bool squint = reader.Given(kSquint), doppler = reader.Given(kDoppler);
  if (squint && doppler) {
    reader.Fail(kDoppler, "stands beside squint_deg, one of both is allowed");
  }
  if (doppler) *flags |= Looks::kDoppler;
  return doppler ? ReadDoppler(reader, pass, time_s) : squint ? ReadSquint(reader) : 0.0;
}

double ReadAzimuthSigma(const CsvReader& reader, const Pass& pass, std::uint8_t* flags) {
  const double metres = PositiveNumber(reader, kAzimuthSigma);
  const double seconds = PositiveNumber(reader, kTimeSigma);
  if (!std::isnan(metres) && !std::isnan(seconds)) {
    reader.Fail(kTimeSigma, "stands beside azimuth_sigma_m, one of both is allowed");
  }
  if (!std::isnan(seconds)) {
    *flags |= Looks::kAzimuthSeconds;
    return seconds;
  }
  if (std::isnan(metres) && std::isnan(pass.sigma.azimuth)) {
    reader.Fail(kAzimuthSigma,
                "no standard deviation of azimuth: neither this row, pass " + Quoted(pass.id) +
                    " nor [sigma] of block.toml gives one");
  }
  return metres;
}

double ReadRangeSigma(const CsvReader& reader, const Pass& pass) {
  const double sigma_m = PositiveNumber(reader, kRangeSigma);
  if (std::isnan(sigma_m) && std::isnan(pass.sigma.range_m)) {
    reader.Fail(kRangeSigma,
                "no standard deviation of range: neither this row, pass " + Quoted(pass.id) +
                    " nor [sigma] of block.toml gives one");
  }
  return sigma_m;
}

bool ReadRejected(const CsvReader& reader) {
  const std::string_view text = reader.Text(kRejected);
  if (text == "1") return true;
  if (!text.empty() && text != "0") {
    reader.Fail(kRejected, Quoted(text) + " is not allowed, 0 or 1 is");
  }
  return false;
}

// A point seen twice by a pass is refused. The lines are looked up only then, in a second scan.
void RefuseDuplicates(const BlockReading& reading, const std::vector<std::uint32_t>& old_of_new) {
  const Block& block = reading.result.block;
  std::size_t first = 0, second = std::numeric_limits<std::size_t>::max(), point_found = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point] + 1; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.pass[i] != block.looks.pass[i - 1] || old_of_new[i] >= second) continue;
      first = old_of_new[i - 1];
      second = old_of_new[i];
      point_found = point;
    }
  }
  if (second == std::numeric_limits<std::size_t>::max()) return;
  CsvReader reader = reading.source.Require("observations", Columns(reading.options.measurements));
  std::size_t first_line = 0;
  for (std::size_t row = 0; row <= second && reader.Next(); ++row) {
    if (row == first) first_line = reader.line();
  }
  reader.Fail(kPoint,
              "pass " + Quoted(reader.Text(kPass)) + " sees point " +
                  Quoted(block.points.ids[point_found]) + " twice, first on line " +
                  std::to_string(first_line) + "; one look per pass and point is allowed");
}

}  // namespace

void ReadLooks(BlockReading* reading) {
  const Measurements measurements = reading->options.measurements;
  CsvReader reader = reading->source.Require("observations", Columns(measurements));
  WarnOfUnknownColumns(reader, &reading->result.warnings);
  Block& block = reading->result.block;
  Points& points = block.points;
  Looks& looks = block.looks;
  std::vector<std::uint32_t> point_of_look;
  while (reader.Next()) {
    const std::size_t row = looks.size();
    const std::uint32_t pass_index = FindPass(reader, kPass, reading->pass_ids);
    const Pass& pass = block.passes[pass_index];
    const std::uint32_t point = points.ids.FindOrAppend(reader.Id(kPoint));
    if (point == points.size()) {  // a tie point that points.csv does not name
      points.role.push_back(PointRole::kTie);
      points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
    }
    std::uint8_t flags = ReadRejected(reader) ? Looks::kRejected : 0;
    const double time_s = ReadTime(reader, pass, measurements);
    const double range_m = PositiveNumber(reader, kRange);
    if (measurements == Measurements::kRequired && std::isnan(range_m)) {
      reader.Fail(kRange, "is empty, a number is needed");
    }
    Append(ReadCone(reader, pass, time_s, &flags), 0.0, row, &looks.cone);
    Append(ReadRangeSigma(reader, pass), kNotGiven, row, &looks.range_sigma_m);
    Append(ReadAzimuthSigma(reader, pass, &flags), kNotGiven, row, &looks.azimuth_sigma);
    looks.time_s.push_back(time_s);
    looks.range_m.push_back(range_m);
    looks.pass.push_back(pass_index);
    looks.flags.push_back(flags);
    point_of_look.push_back(point);
    if (row % 65536 == 65535) Step(reading->options.progress, "read", row, 0, "looks");
  }
  RefuseDuplicates(*reading, SortLooksByPoint(point_of_look, points.size(), &looks));
}

}  // namespace sarblock
