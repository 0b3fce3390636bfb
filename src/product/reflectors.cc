// SPDX-License-Identifier: Apache-2.0
#include "product/reflectors.h"

#include "sarblock/core/error.h"

#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "core/text.h"
#include "tables/csv.h"

namespace sarblock {
namespace {

enum {
  kReflectorId,
  kReflectorLat,
  kReflectorLon,
  kReflectorHeight,
  kReflectorDate,
  kReflectorValidity,
  kReflectorEast,
  kReflectorNorth,
  kReflectorUp
};
constexpr std::array<TableColumn, 9> kReflectorColumns{{
    {"Corner reflector ID", ColumnNeed::kRequired, CellKind::kPoint},
    {"Latitude (deg)", ColumnNeed::kRequired},
    {"Longitude (deg)", ColumnNeed::kRequired},
    {"Height above ellipsoid (m)", ColumnNeed::kRequired},
    {"Survey Date", ColumnNeed::kOptional, CellKind::kText},
    {"Validity", ColumnNeed::kOptional, CellKind::kCount},
    {"Velocity East (m/s)"},
    {"Velocity North (m/s)"},
    {"Velocity Up (m/s)"},
}};
constexpr std::uint32_t kUsableForGeometry = 4;

// UTC of before 1972 had other seconds than ours: the same day to a day, which is enough for the
// motion of continents. Tables without a survey say 1970.
std::optional<UtcTime> EarlyDate(std::string_view text) {
  int year = 0;
  if (text.size() < 4) return std::nullopt;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + 4, year);
  if (error != std::errc() || stop != text.data() + 4 || year < 1900 || year >= 1972) {
    return std::nullopt;
  }
  const auto later = ParseUtc("1972" + std::string(text.substr(4)));
  constexpr double kYear_s = 365.25 * 86400.0;
  if (!later) return std::nullopt;
  return AddSeconds(*later, (year - 1972) * kYear_s);
}

std::optional<UtcTime> SurveyTime(const TableReader& reader) {
  if (!reader.Given(kReflectorDate)) return std::nullopt;
  std::string text(reader.Text(kReflectorDate));
  constexpr std::size_t kDateAlone = 10;
  if (text.size() == kDateAlone) text += "T00:00:00";
  auto time = ParseUtc(text);
  if (!time) time = EarlyDate(text);
  if (!time) {
    reader.Fail(kReflectorDate,
                Quoted(reader.Text(kReflectorDate)) + " is no date, such as 2021-12-17T00:00:00");
  }
  return time;
}

double Velocity_mps(const TableReader& reader, std::size_t column) {
  const double value_mps = reader.Number(column);
  if (std::isnan(value_mps)) return 0.0;
  constexpr double kFastest_mps = 1e-3;  // glaciers; in millimetres a year it would be more
  if (std::abs(value_mps) > kFastest_mps) {
    reader.Fail(column, NumberText(value_mps) + " m/s is faster than any ground moves");
  }
  return value_mps;
}

Geodetic Place(const TableReader& reader) {
  const auto bounded = [&reader](std::size_t column, double most, const char* unit) {
    const double value = reader.RequiredNumber(column);
    if (std::abs(value) > most) {
      reader.Fail(column,
                  NumberText(value) + " is not between -" + NumberText(most) + " and " +
                      NumberText(most) + " " + unit);
    }
    return value;
  };
  const double lat_deg = bounded(kReflectorLat, 90.0, "degrees");
  const double lon_deg = bounded(kReflectorLon, 360.0, "degrees");
  return {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, bounded(kReflectorHeight, 20e3, "m")};
}

Reflectors ReadSurveys(CsvReader reader) {
  Reflectors reflectors;
  reflectors.file = reader.file();
  while (reader.Next()) {
    ReflectorSurvey survey;
    survey.id = reader.Id(kReflectorId);
    survey.place = Place(reader);
    survey.surveyed = SurveyTime(reader);
    if (reader.Given(kReflectorValidity)) {
      survey.usable = (reader.Count(kReflectorValidity) & kUsableForGeometry) != 0;
    }
    survey.velocity_mps = {Velocity_mps(reader, kReflectorEast),
                           Velocity_mps(reader, kReflectorNorth),
                           Velocity_mps(reader, kReflectorUp)};
    survey.file_line = reader.line();
    reflectors.surveys.push_back(std::move(survey));
  }
  if (reflectors.surveys.empty()) {
    throw InputError(FilePlace{reflectors.file, 0, ""}, "has no reflector, one or more are needed");
  }
  return reflectors;
}

// Seconds that a survey is older than a time; negative where it is later.
double Age_s(const ReflectorSurvey& survey, const UtcTime& time) {
  return survey.surveyed ? SecondsBetween(*survey.surveyed, time) : 0.0;
}

}  // namespace

Reflectors ReadReflectors(const std::string& file) {
  return ReadSurveys(CsvReader(std::filesystem::path(file), kReflectorColumns));
}

Reflectors ParseReflectors(std::string_view text, const std::string& file) {
  return ReadSurveys(CsvReader(file, text, kReflectorColumns));
}

std::vector<ReflectorPosition> ReflectorsAt(const Reflectors& reflectors,
                                            const UtcTime& time,
                                            const Frame& frame) {
  std::map<std::string, const ReflectorSurvey*> latest;
  for (const ReflectorSurvey& survey : reflectors.surveys) {
    const double age_s = Age_s(survey, time);
    if (age_s < 0.0) continue;
    const ReflectorSurvey*& of_id = latest[survey.id];
    if (of_id != nullptr && Age_s(*of_id, time) == age_s) {
      throw InputError(FilePlace{reflectors.file, survey.file_line, "Survey Date"},
                       Quoted(survey.id) + " has two surveys of the same date");
    }
    if (of_id == nullptr || age_s < Age_s(*of_id, time)) of_id = &survey;
  }
  std::vector<ReflectorPosition> positions;
  for (const auto& [id, survey] : latest) {
    if (survey == nullptr || !survey->usable) continue;
    const Eigen::Vector3d p_m = frame.FrameFromGeodetic(survey->place);
    const Eigen::Vector3d moved_m = Age_s(*survey, time) * survey->velocity_mps;
    positions.push_back(
        {id, p_m + frame.EnuFromFrame(p_m).transpose() * moved_m, survey->file_line});
  }
  return positions;
}

}  // namespace sarblock
