// SPDX-License-Identifier: Apache-2.0
#include "block_builder.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "core/text.h"
#include "sicd.h"
#include "tables/csv.h"
#include "tables/table.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr Columns kMatchColumns{{
    {"point", ColumnNeed::kRequired, CellKind::kPoint},
    {"image", ColumnNeed::kRequired, CellKind::kText},
    {"line", ColumnNeed::kRequired},
    {"sample", ColumnNeed::kRequired},
    {"line_sigma_px"},
    {"sample_sigma_px"},
}};

MatchedPoints ReadMatches(TableReader* table) {
  MatchedPoints matches;
  matches.file = table->file();
  WarnOfUnknownColumns(*table, &matches.warnings);
  ForRows(table, [&](const Row& row) {
    MatchedPoint match;
    match.point = row.Id(kMatchColumns("point"));
    match.image = row.Id(kMatchColumns("image"));
    match.line_px = row.RequiredNumber(kMatchColumns("line"));
    match.sample_px = row.RequiredNumber(kMatchColumns("sample"));
    match.line_sigma_px = row.PositiveNumber(kMatchColumns("line_sigma_px"));
    match.sample_sigma_px = row.PositiveNumber(kMatchColumns("sample_sigma_px"));
    match.file_line = row.line();
    matches.rows.push_back(std::move(match));
  });
  return matches;
}

}  // namespace

MatchedPoints ReadMatchedPoints(const std::string& file) {
  return ReadMatches(ReadCsv(file, kMatchColumns).get());
}

MatchedPoints ParseMatchedPoints(std::string_view text, const std::string& file) {
  return ReadMatches(ReadCsvText(file, text, kMatchColumns).get());
}

namespace {

constexpr Columns kReflectorColumns{{
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

std::optional<UtcTime> SurveyTime(const Row& row) {
  if (!row.Given(kReflectorColumns("Survey Date"))) return std::nullopt;
  std::string text(row.Text(kReflectorColumns("Survey Date")));
  constexpr std::size_t kDateAlone = 10;
  if (text.size() == kDateAlone) text += "T00:00:00";
  auto time = ParseUtc(text);
  if (!time) time = EarlyDate(text);
  if (!time) {
    row.Fail(kReflectorColumns("Survey Date"),
             Quoted(row.Text(kReflectorColumns("Survey Date"))) +
                 " is no date, such as 2021-12-17T00:00:00");
  }
  return time;
}

double Velocity_mps(const Row& row, std::size_t column) {
  const double value_mps = row.Number(column);
  if (std::isnan(value_mps)) return 0.0;
  constexpr double kFastest_mps = 1e-3;  // glaciers; in millimetres a year it would be more
  if (std::abs(value_mps) > kFastest_mps) {
    row.Fail(column, NumberText(value_mps) + " m/s is faster than any ground moves");
  }
  return value_mps;
}

Geodetic Place(const Row& row) {
  const auto bounded = [&row](std::size_t column, double most, const char* unit) {
    const double value = row.RequiredNumber(column);
    if (std::abs(value) > most) {
      row.Fail(column,
               NumberText(value) + " is not between -" + NumberText(most) + " and " +
                   NumberText(most) + " " + unit);
    }
    return value;
  };
  const double lat_deg = bounded(kReflectorColumns("Latitude (deg)"), 90.0, "degrees");
  const double lon_deg = bounded(kReflectorColumns("Longitude (deg)"), 360.0, "degrees");
  return {lat_deg * kRadPerDeg,
          lon_deg * kRadPerDeg,
          bounded(kReflectorColumns("Height above ellipsoid (m)"), 20e3, "m")};
}

Reflectors ReadSurveys(TableReader* table) {
  Reflectors reflectors;
  reflectors.file = table->file();
  ForRows(table, [&](const Row& row) {
    ReflectorSurvey survey;
    survey.id = row.Id(kReflectorColumns("Corner reflector ID"));
    survey.place = Place(row);
    survey.surveyed = SurveyTime(row);
    if (row.Given(kReflectorColumns("Validity"))) {
      survey.usable = (row.Count(kReflectorColumns("Validity")) & kUsableForGeometry) != 0;
    }
    survey.velocity_mps = {Velocity_mps(row, kReflectorColumns("Velocity East (m/s)")),
                           Velocity_mps(row, kReflectorColumns("Velocity North (m/s)")),
                           Velocity_mps(row, kReflectorColumns("Velocity Up (m/s)"))};
    survey.file_line = row.line();
    reflectors.surveys.push_back(std::move(survey));
  });
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
  return ReadSurveys(ReadCsv(file, kReflectorColumns).get());
}

Reflectors ParseReflectors(std::string_view text, const std::string& file) {
  return ReadSurveys(ReadCsvText(file, text, kReflectorColumns).get());
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

namespace {

// Standard deviation of the median of normally distributed values, from their absolute deviations.
double SigmaOfMedian(std::vector<double> values, double median) {
  for (double& value : values) value = std::abs(value - median);
  const auto count = static_cast<double>(values.size());
  return 1.4826 * 1.2533 * Median(std::move(values)) / std::sqrt(count);
}

struct Mistake {
  double line_px, sample_px;
  const char* name;
};
constexpr Mistake kMistakes[] = {{0.5, 0.5, "half a pixel in line and sample"},
                                 {-0.5, -0.5, "half a pixel in line and sample"},
                                 {0.5, 0.0, "half a line"},
                                 {-0.5, 0.0, "half a line"},
                                 {0.0, 0.5, "half a sample"},
                                 {0.0, -0.5, "half a sample"},
                                 {1.0, 0.0, "one line"},
                                 {-1.0, 0.0, "one line"}};

}  // namespace

std::optional<RadarCoordinates> SeenBy(const Pass& pass, const Eigen::Vector3d& p_m) {
  const auto time_s = FindConeTime(pass.path, p_m, Cone{}, pass.path.start_s(), pass.path.end_s());
  if (!time_s) return std::nullopt;
  const auto motion = pass.path.At(*time_s);
  if (!motion) return std::nullopt;
  return RadarCoordinates{*time_s, (p_m - motion->position_m).norm()};
}

std::optional<ImageCoordinates> PlaceInImage(const Pass& pass, const Eigen::Vector3d& p_m) {
  const auto seen = SeenBy(pass, p_m);
  if (!seen) return std::nullopt;
  return ImageFromRadar(*pass.image, *seen);
}

void OffsetCollector::Add(std::size_t index,
                          const Pass& pass,
                          const RadarCoordinates& measured,
                          const Eigen::Vector3d& p_m) {
  const auto given_px = PlaceInImage(pass, p_m);
  const auto measured_px = ImageFromRadar(*pass.image, measured);
  if (given_px && measured_px) Add(index, *measured_px, *given_px);
}

void OffsetCollector::Add(std::size_t index,
                          const ImageCoordinates& measured_px,
                          const ImageCoordinates& given_px) {
  if (index >= lines_px_.size()) {
    lines_px_.resize(index + 1);
    samples_px_.resize(index + 1);
  }
  lines_px_[index].push_back(measured_px.line_px - given_px.line_px);
  samples_px_[index].push_back(measured_px.pixel_px - given_px.pixel_px);
}

std::vector<PixelOffset> OffsetCollector::Offsets(std::size_t passes) const {
  std::vector<PixelOffset> offsets(passes);
  for (std::size_t i = 0; i < lines_px_.size(); ++i) {
    PixelOffset& offset = offsets[i];
    offset.looks = lines_px_[i].size();
    if (offset.looks == 0) continue;
    offset.line_px = Median(lines_px_[i]);
    offset.sample_px = Median(samples_px_[i]);
    offset.line_sigma_px = SigmaOfMedian(lines_px_[i], offset.line_px);
    offset.sample_sigma_px = SigmaOfMedian(samples_px_[i], offset.sample_px);
  }
  return offsets;
}

std::vector<std::string> NameOffsets(const Block& block,
                                     const std::vector<PixelOffset>& offsets,
                                     const std::array<double, 2>& pixel_origin_px,
                                     const std::string& measured_by,
                                     const std::string& option) {
  constexpr double kNear_px = 0.15;
  constexpr std::size_t kFewestLooks = 5;
  const auto near = [](double value_px, double sigma_px, double mistake_px) {
    return std::abs(value_px - mistake_px) < kNear_px && 3.0 * sigma_px < kNear_px;
  };
  std::vector<std::string> remarks;
  for (const Mistake& mistake : kMistakes) {
    std::string passes;
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const PixelOffset& offset = offsets[i];
      if (offset.looks >= kFewestLooks &&
          near(offset.line_px, offset.line_sigma_px, mistake.line_px) &&
          near(offset.sample_px, offset.sample_sigma_px, mistake.sample_px)) {
        passes += (passes.empty() ? "" : ", ") + block.passes[i].id;
      }
    }
    if (passes.empty()) continue;
    remarks.push_back(fmt::format(
        "{}: measures lie {} {} where the given positions of the points are. If {} counts "
        "pixels from another origin or was measured with other start times, {} "
        "{:g},{:g} takes it up",
        passes,
        mistake.name,
        mistake.line_px + mistake.sample_px > 0.0 ? "after" : "before",
        measured_by,
        option,
        pixel_origin_px[0] + mistake.line_px,
        pixel_origin_px[1] + mistake.sample_px));
  }
  return remarks;
}

namespace {

// By its name where one is known by these numbers.
Ellipsoid NamedLike(const Ellipsoid& ellipsoid) {
  for (const std::string& name : EllipsoidNames()) {
    const Ellipsoid known = NamedEllipsoid(name);
    if (known.a_m == ellipsoid.a_m && known.flattening == ellipsoid.flattening) return known;
  }
  return ellipsoid;
}

// Line and sample counted from the middle of the first pixel.
ImageCoordinates PlaceOf(const MatchedPoints& matches, const MatchedPoint& row) {
  return {row.line_px - matches.origin_px[0], row.sample_px - matches.origin_px[1]};
}

// Places of an image file in the raster of its pass, and back.
ImageCoordinates RasterFromFile(const ImagePass& image, const ImageCoordinates& file) {
  if (image.axes == RasterAxes::kAzimuthDown) return file;
  if (image.axes == RasterAxes::kRangeDown) return {file.pixel_px, file.line_px};
  return {static_cast<double>(image.lines) - 1.0 - file.pixel_px, file.line_px};
}
ImageCoordinates FileFromRaster(const ImagePass& image, const ImageCoordinates& raster) {
  if (image.axes == RasterAxes::kAzimuthDown) return raster;
  if (image.axes == RasterAxes::kRangeDown) return {raster.pixel_px, raster.line_px};
  return {raster.pixel_px, static_cast<double>(image.lines) - 1.0 - raster.line_px};
}

// A column of looks begins to exist with its first value that is not the one of empty columns.
void AppendValue(double value, double otherwise, std::size_t looks, std::vector<double>* column) {
  if (column->empty() && (std::isnan(value) || value == otherwise)) return;
  column->resize(looks, otherwise);
  column->push_back(value);
}

}  // namespace

UtcTime SetEpoch(const UtcTime& first_line, Pass* pass) {
  const UtcTime epoch = WholeSecond(first_line);
  pass->epoch_utc = UtcText(epoch);
  return epoch;
}

KnownPosition EquallyKnown(std::uint32_t point, const std::array<bool, 3>& fixed, double sigma_m) {
  KnownPosition known{point, fixed, Eigen::Matrix3d::Zero()};
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (fixed[static_cast<std::size_t>(k)]) known.covariance_enu_m2(k, k) = sigma_m * sigma_m;
  }
  return known;
}

namespace {

/// Slant ranges from the outer edge of the first sample to that of the last one, over the lines of
/// the image; nothing where its size or its ranges are not known.
std::optional<Swath> SwathOf(const ImagePass& image) {
  if (image.samples < 2 || image.lines < 1 || !image.pass.image) return std::nullopt;
  Swath swath{SwathKind::kSlantRange, {std::numeric_limits<double>::infinity(), 0.0}};
  auto& [near_m, far_m] = swath.limits;
  const auto last_line = static_cast<double>(image.lines - 1);
  for (const double line_px : {0.0, 0.5 * last_line, last_line}) {
    for (const double pixel_px : {-0.5, static_cast<double>(image.samples) - 0.5}) {
      const auto radar = RadarFromImage(*image.pass.image, {line_px, pixel_px});
      if (!radar) return std::nullopt;
      const double delay_m = image.delay ? image.delay(*radar).range_m : 0.0;
      near_m = std::min(near_m, radar->range_m - delay_m);
      far_m = std::max(far_m, radar->range_m - delay_m);
    }
  }
  if (ProblemOf(swath)) return std::nullopt;
  return swath;
}

}  // namespace

std::uint32_t BlockBuilder::AddImage(ImagePass image) {
  if (images_.empty()) {
    block_.frame = Frame::Geocentric(NamedLike(image.ellipsoid));
  } else {
    const double radius_m = images_.front().ellipsoid.a_m;
    if (std::abs(image.ellipsoid.a_m - radius_m) > kSameRadius * radius_m) {
      throw InputError(FilePlace{image.file, 0, ""},
                       fmt::format("is an image of another body than {}: radius {} km, there {} km",
                                   images_.front().file,
                                   NumberText(1e-3 * image.ellipsoid.a_m),
                                   NumberText(1e-3 * radius_m)));
    }
  }
  for (const Pass& other : block_.passes) {
    if (other.id != image.pass.id) continue;
    throw InputError(
        FilePlace{image.file, 0, "id"},
        Quoted(image.pass.id) + " is the id of another image too, give ids of your own with --id");
  }
  image.pass.swath = SwathOf(image);
  block_.passes.push_back(std::move(image.pass));
  images_.push_back(std::move(image));
  match_counts_.push_back(0);
  delays_.emplace_back();
  models_.reset();
  return static_cast<std::uint32_t>(images_.size() - 1);
}

std::optional<std::uint32_t> BlockBuilder::AddPoint(std::string_view id) {
  const std::uint32_t point = block_.points.ids.FindOrAppend(id);
  if (point != block_.points.size()) return std::nullopt;
  AppendTiePoint();
  return point;
}

void BlockBuilder::AppendTiePoint() {
  block_.points.role.push_back(PointRole::kTie);
  block_.points.given_m.emplace_back(Eigen::Vector3d::Constant(kNotGiven));
}

void BlockBuilder::SetPosition(std::uint32_t point, const Eigen::Vector3d& position_m) {
  block_.points.given_m[point] = position_m;
}

void BlockBuilder::SetKnown(PointRole role, const KnownPosition& known) {
  block_.points.role[known.point] = role;
  block_.points.known.push_back(known);
}

void BlockBuilder::AddLook(const NewLook& look) {
  Looks& looks = block_.looks;
  const bool measured = !std::isnan(look.doppler_hz);
  AppendValue(look.range_sigma_m, kNotGiven, looks.size(), &looks.range_sigma_m);
  AppendValue(look.azimuth_sigma, kNotGiven, looks.size(), &looks.azimuth_sigma);
  AppendValue(measured ? look.doppler_hz : 0.0, 0.0, looks.size(), &looks.cone);
  AppendValue(look.range_delay_m, 0.0, looks.size(), &looks.range_delay_m);
  AppendValue(look.time_shift_s, 0.0, looks.size(), &looks.time_shift_s);
  looks.pass.push_back(look.pass);
  looks.flags.push_back(measured ? look.flags | Looks::kDoppler : look.flags);
  looks.time_s.push_back(look.time_s - look.time_shift_s);
  looks.range_m.push_back(look.range_m - look.range_delay_m);
  point_of_look_.push_back(look.point);
  if (!look.by_place) return;
  const Sentinel1Timing& timing = *images_[look.pass].timing;
  const auto& [delay, troposphere_m] = *look.by_place;
  ImageDelays& sizes = delays_[look.pass];
  if (timing.HasBistatic()) sizes.bistatic_s.Add(delay.bistatic_s);
  if (timing.HasFmRate()) sizes.fm_rate_s.Add(delay.fm_rate_s);
  if (timing.HasPulseMotion()) sizes.pulse_motion_m.Add(delay.pulse_motion_m);
  if (block_.passes[look.pass].reduction.troposphere != TroposphereModel::kNone) {
    sizes.troposphere_m.Add(troposphere_m);
  }
}

bool BlockBuilder::Contains(const ImagePass& image, const ImageCoordinates& place) const {
  const auto within = [](double value_px, std::size_t count) {
    return count == 0 || (value_px >= -0.5 && value_px <= static_cast<double>(count) - 0.5);
  };
  return within(place.line_px, image.lines) && within(place.pixel_px, image.samples);
}

void DelaySize::Add(double value) {
  least = looks > 0 ? std::min(least, value) : value;
  largest = looks > 0 ? std::max(largest, value) : value;
  sum += value;
  ++looks;
}

// The ground of a place and its delays depend on each other: metres of range turn the FM rate by
// microseconds, and the second time by nothing.
void BlockBuilder::SetDelays(const ImageCoordinates& place,
                             const std::optional<Eigen::Vector3d>& p_m,
                             NewLook* look) {
  const ImagePass& image = images_[look->pass];
  const auto raster = RadarFromImage(*block_.passes[look->pass].image, place);
  if (!raster) return;
  if (image.delay) {
    const LookDelay stated = image.delay(*raster);
    look->time_shift_s = stated.time_s;
    look->range_delay_m = stated.range_m;
  }
  if (!image.timing) return;
  std::optional<Eigen::Vector3d> ground_m = p_m ? p_m : image.timing->GroundAt(place, *raster);
  if (!ground_m) return;
  Sentinel1Delay delay = image.timing->At(place, *raster, *ground_m);
  LookReduction models = ModelsAt(look->pass, raster->time_s, *ground_m);
  if (!p_m) {
    const auto reduced_m =
        image.timing->GroundAt(place,
                               {raster->time_s - delay.Time_s() - models.Time_s(),
                                raster->range_m - delay.pulse_motion_m - models.Range_m()});
    if (reduced_m) {
      delay = image.timing->At(place, *raster, *reduced_m);
      models = ModelsAt(look->pass, raster->time_s, *reduced_m);
    }
  }
  if (image.timing->HasBistatic()) delay.bistatic_s += look->time_s - raster->time_s;
  look->time_shift_s = delay.Time_s();
  look->range_delay_m = delay.pulse_motion_m;
  if (!block_.passes[look->pass].path.At(look->time_s - look->time_shift_s)) {
    throw InputError(FilePlace{image.file, 0, "orbit"},
                     fmt::format("does not cover the time of line {}, pixel {} without its shift "
                                 "of {:.3g} s",
                                 place.line_px,
                                 place.pixel_px,
                                 look->time_shift_s));
  }
  look->by_place = {delay, models.range_m[static_cast<std::size_t>(ReductionSource::kTroposphere)]};
}

LookReduction BlockBuilder::ModelsAt(std::size_t pass, double time_s, const Eigen::Vector3d& p_m) {
  if (block_.passes[pass].reduction == ReductionModels{}) return {};
  if (!models_) models_.emplace(block_, ModelsOf(block_));
  return models_->Of(
      static_cast<std::uint32_t>(pass), time_s, Cone{}, p_m, Eigen::Vector3d::Zero());
}

RadarCoordinates BlockBuilder::GeometricOf(const NewLook& look, const Eigen::Vector3d& p_m) {
  const LookReduction models = ModelsAt(look.pass, look.time_s - look.time_shift_s, p_m);
  return {look.time_s - look.time_shift_s - models.Time_s(),
          look.range_m - look.range_delay_m - models.Range_m()};
}

// Delays change so slowly with the place that those of the place before are good to 1e-4 pixels
// after the second step.
std::optional<ImageCoordinates> BlockBuilder::SeenAt(std::size_t pass, const Eigen::Vector3d& p_m) {
  const ImagePass& image = images_[pass];
  const ImageGrid& grid = *block_.passes[pass].image;
  const auto geometric = SeenBy(block_.passes[pass], p_m);
  if (!geometric) return std::nullopt;
  const LookReduction models = ModelsAt(pass, geometric->time_s, p_m);
  const RadarCoordinates seen{geometric->time_s + models.Time_s(),
                              geometric->range_m + models.Range_m()};
  // What a product states changes too little over its own length to need an iteration.
  const LookDelay stated = image.delay ? image.delay(seen) : LookDelay{};
  auto place = ImageFromRadar(grid, {seen.time_s + stated.time_s, seen.range_m + stated.range_m});
  for (int step = 0; image.timing && place && step < 3; ++step) {
    const auto raster = RadarFromImage(grid, *place);
    if (!raster) return std::nullopt;
    const Sentinel1Delay delay = image.timing->At(*place, *raster, p_m);
    place =
        ImageFromRadar(grid, {seen.time_s + delay.Time_s(), seen.range_m + delay.pulse_motion_m});
  }
  return place;
}

std::optional<ImageCoordinates> BlockBuilder::Locate(std::size_t pass, const Eigen::Vector3d& p_m) {
  const ImagePass& image = images_[pass];
  const auto place = image.aperture ? PlaceInSicd(image.aperture->sicd, p_m) : SeenAt(pass, p_m);
  if (!place || !Contains(images_[pass], *place)) return std::nullopt;
  return FileFromRaster(images_[pass], *place);
}

// By id, else by file: as given, by its name, or by its name without ending.
std::uint32_t BlockBuilder::ImageOf(const MatchedPoints& matches, const MatchedPoint& row) const {
  const FilePlace place{matches.file, row.file_line, "image"};
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    if (block_.passes[i].id == row.image) return static_cast<std::uint32_t>(i);
    ids.push_back(block_.passes[i].id);
  }
  const auto named = [&row](const ImagePass& image, int rule) {
    const std::filesystem::path path(image.file);
    return (rule == 0   ? image.file
            : rule == 1 ? path.filename().string()
                        : path.stem().string()) == row.image;
  };
  for (int rule = 0; rule < 3; ++rule) {
    std::optional<std::uint32_t> found;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (!named(images_[i], rule)) continue;
      if (found) throw InputError(place, Quoted(row.image) + " is the name of several images");
      found = static_cast<std::uint32_t>(i);
    }
    if (found) return *found;
  }
  throw InputError(place,
                   Quoted(row.image) +
                       " is no image given, by the id of its pass or the name of its file" +
                       DidYouMean(NearestName(row.image, ids)));
}

void BlockBuilder::AddMatches(const MatchedPoints& matches) {
  const auto key = [](std::uint64_t point, std::uint64_t pass) { return point << 32U | pass; };
  std::unordered_set<std::uint64_t> seen;
  for (std::size_t i = 0; i < point_of_look_.size(); ++i) {
    seen.insert(key(point_of_look_[i], block_.looks.pass[i]));
  }
  std::vector<NewLook> looks;
  for (const MatchedPoint& row : matches.rows) {
    NewLook look;
    look.pass = ImageOf(matches, row);
    look.point = block_.points.ids.FindOrAppend(row.point);
    if (look.point == block_.points.size()) AppendTiePoint();
    if (!seen.insert(key(look.point, look.pass)).second) {
      throw InputError(FilePlace{matches.file, row.file_line, "point"},
                       Quoted(row.point) + " is measured twice in image " + Quoted(row.image));
    }
    SetMatch(matches, row, &look);
    CompareWithGiven(matches, row, look);
    looks.push_back(look);
  }
  SetDelaysWhereLooksMeet(matches, &looks);
  for (const NewLook& look : looks) {
    AddLook(look);
    ++match_counts_[look.pass];
  }
}

// The height of the grid is known to hundreds of metres in mountains; that at which two flights see
// a point is better.
void BlockBuilder::SetDelaysWhereLooksMeet(const MatchedPoints& matches,
                                           std::vector<NewLook>* looks) {
  constexpr double kUseful_m =
      100.0;                         // standard deviation; of the height 0.1 m along track at most
  constexpr double kApart_m = 10.0;  // by which paths and pixels may be off
  std::map<std::uint32_t, std::vector<std::size_t>> by_point;
  for (std::size_t i = 0; i < looks->size(); ++i) {
    const NewLook& look = (*looks)[i];
    if (look.by_place && !block_.points.given_m[look.point].allFinite()) {
      by_point[look.point].push_back(i);
    }
  }
  for (const auto& [point, indices] : by_point) {
    if (indices.size() < 2) continue;
    std::vector<FixedPathLook> seen;
    for (const std::size_t i : indices) {
      const NewLook& look = (*looks)[i];
      const Pass& pass = block_.passes[look.pass];
      const double time_s = look.time_s - look.time_shift_s;
      const auto motion = pass.path.At(time_s);
      if (!motion) continue;
      FixedPathLook& fixed = seen.emplace_back();
      fixed.antenna_m = motion->position_m;
      fixed.velocity_mps = motion->velocity_mps;
      fixed.acceleration_mps2 = motion->acceleration_mps2;
      fixed.range_m = look.range_m - look.range_delay_m - look.by_place->troposphere_m;
      fixed.side = static_cast<int>(pass.side);
      fixed.range_sigma_m = fixed.azimuth_sigma = kApart_m;
    }
    const Intersection met = Intersect(seen, block_.frame);
    if (met.outcome != IntersectionOutcome::kDetermined ||
        !(met.covariance_m2.trace() < kUseful_m * kUseful_m)) {
      continue;
    }
    for (const std::size_t i : indices) {
      const ImageCoordinates place =
          RasterFromFile(images_[(*looks)[i].pass], PlaceOf(matches, matches.rows[i]));
      SetDelays(place, met.position_m, &(*looks)[i]);
    }
  }
}

// Where the point has a position that is given.
void BlockBuilder::CompareWithGiven(const MatchedPoints& matches,
                                    const MatchedPoint& row,
                                    const NewLook& look) {
  const Eigen::Vector3d& p_m = block_.points.given_m[look.point];
  if (!p_m.allFinite()) return;
  const auto& aperture = images_[look.pass].aperture;
  if (!aperture) {
    offsets_.Add(look.pass, block_.passes[look.pass], GeometricOf(look, p_m), p_m);
  } else if (const auto given_px = PlaceInSicd(aperture->sicd, p_m)) {
    offsets_.Add(look.pass, PlaceOf(matches, row), *given_px);
  }
}

void BlockBuilder::FailOutside(const MatchedPoints& matches,
                               const MatchedPoint& row,
                               const std::string& problem) const {
  throw InputError(FilePlace{matches.file, row.file_line, "line"},
                   fmt::format("line {} and sample {} are outside image {}: {}",
                               NumberText(row.line_px),
                               NumberText(row.sample_px),
                               Quoted(row.image),
                               problem));
}

// Refuses places where the image has no pixel. `place` is in its raster.
void BlockBuilder::RequireValid(const MatchedPoints& matches,
                                const MatchedPoint& row,
                                const ImagePass& image,
                                const ImageCoordinates& place) const {
  if (!Contains(image, place)) {
    const bool range_down = image.axes != RasterAxes::kAzimuthDown;
    FailOutside(matches,
                row,
                fmt::format("it has {} lines and {} samples{}",
                            range_down ? image.samples : image.lines,
                            range_down ? image.lines : image.samples,
                            image.counting));
  }
  const double line_px = std::max(0.0, std::round(place.line_px));
  if (!(line_px < static_cast<double>(image.valid_samples.size()))) return;
  const auto [first, last] = image.valid_samples[static_cast<std::size_t>(line_px)];
  if (first < 0 || last < first) {
    FailOutside(
        matches, row, fmt::format("line {} of it has no valid sample{}", line_px, image.counting));
  }
  if (place.pixel_px < first - 0.5 || place.pixel_px > last + 0.5) {
    FailOutside(
        matches,
        row,
        fmt::format(
            "samples {} to {} of line {} are valid{}", first, last, line_px, image.counting));
  }
}

void BlockBuilder::SetApertureMatch(const MatchedPoints& matches,
                                    const MatchedPoint& row,
                                    const ImageCoordinates& place,
                                    NewLook* look) const {
  const ImagePass& image = images_[look->pass];
  const Pass& pass = block_.passes[look->pass];
  const SicdImage& sicd = image.aperture->sicd;
  const auto measured = LookOfPlace(sicd, place.line_px, place.pixel_px);
  if (!measured) FailOutside(matches, row, "they have no range and range rate");
  look->time_s = measured->time_s + image.aperture->start_s;
  if (!pass.path.At(look->time_s)) {
    FailOutside(matches, row, "its path does not cover the time");
  }
  look->range_m = measured->range_m;
  const double hertz_per_mps = 2.0 / pass.wavelength_m;
  look->doppler_hz = -measured->range_rate_mps * hertz_per_mps;
  if (std::isnan(row.line_sigma_px) && std::isnan(row.sample_sigma_px)) return;
  // Range and Doppler may depend on both: that which is not given is a pixel, evenly spread.
  const auto or_pixel = [](double sigma_px) { return std::isnan(sigma_px) ? kEvenly : sigma_px; };
  const auto sigma = SigmaOfPlace(sicd,
                                  place.line_px,
                                  place.pixel_px,
                                  or_pixel(row.line_sigma_px),
                                  or_pixel(row.sample_sigma_px));
  if (!sigma) FailOutside(matches, row, "range and range rate do not change there");
  if (!std::isnan(row.line_sigma_px)) look->range_sigma_m = sigma->range_m;
  if (!std::isnan(row.sample_sigma_px)) {
    look->azimuth_sigma = sigma->range_rate_mps * hertz_per_mps;
    look->flags |= Looks::kAzimuthHertz;
  }
}

void BlockBuilder::SetMatch(const MatchedPoints& matches, const MatchedPoint& row, NewLook* look) {
  const Pass& pass = block_.passes[look->pass];
  const ImagePass& image = images_[look->pass];
  const ImageCoordinates place = RasterFromFile(image, PlaceOf(matches, row));
  RequireValid(matches, row, image, place);
  if (image.aperture) return SetApertureMatch(matches, row, place, look);
  const auto radar = RadarFromImage(*pass.image, place);
  if (!radar) FailOutside(matches, row, "they have no slant range");
  const bool range_down = image.axes != RasterAxes::kAzimuthDown;
  look->time_s = radar->time_s;
  look->range_m = radar->range_m;
  const Eigen::Vector3d& given_m = block_.points.given_m[look->point];
  SetDelays(place, given_m.allFinite() ? std::optional(given_m) : std::nullopt, look);
  if (!pass.path.At(look->time_s - look->time_shift_s)) {
    FailOutside(matches, row, "its path does not cover the time");
  }
  const double azimuth_px = range_down ? row.sample_sigma_px : row.line_sigma_px;
  const double range_px = range_down ? row.line_sigma_px : row.sample_sigma_px;
  if (!std::isnan(azimuth_px)) {
    look->azimuth_sigma = azimuth_px * pass.image->line_interval_s;
    look->flags |= Looks::kAzimuthSeconds;
  }
  if (!std::isnan(range_px)) {
    const auto pixel_m = SlantRangePerPixel_m(*pass.image, *radar);
    if (pixel_m) look->range_sigma_m = range_px * *pixel_m;
  }
}

std::vector<PixelOffset> BlockBuilder::MatchOffsets() const {
  std::vector<PixelOffset> offsets = offsets_.Offsets(images_.size());
  for (std::size_t i = 0; i < images_.size(); ++i) {
    if (images_[i].axes == RasterAxes::kAzimuthDown) continue;
    if (images_[i].axes == RasterAxes::kRangeDownMirrored) offsets[i].line_px *= -1.0;
    std::swap(offsets[i].line_px, offsets[i].sample_px);
    std::swap(offsets[i].line_sigma_px, offsets[i].sample_sigma_px);
  }
  return offsets;
}

Block BlockBuilder::Finish() {
  std::sort(block_.points.known.begin(),
            block_.points.known.end(),
            [](const auto& a, const auto& b) { return a.point < b.point; });
  SortLooksByPoint(point_of_look_, block_.points.size(), &block_.looks);
  std::vector<std::optional<std::array<double, 2>>> spans_s;
  for (const ImagePass& image : images_) spans_s.push_back(image.span_s);
  SetStripSpans(spans_s, &block_);
  return std::move(block_);
}

namespace {

/// What the images say of one reflector.
struct ReflectorImages {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<std::pair<std::size_t, ImageCoordinates>> places;
  std::size_t file_line = 0;
};

Eigen::Vector3d MeanPosition_m(const std::string& file,
                               const std::string& id,
                               const ReflectorImages& predictions,
                               std::vector<std::string>* warnings) {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p_m : predictions.positions_m) mean_m += p_m;
  mean_m /= static_cast<double>(predictions.positions_m.size());
  double farthest_m = 0.0;
  for (const Eigen::Vector3d& p_m : predictions.positions_m) {
    farthest_m = std::max(farthest_m, (p_m - mean_m).norm());
  }
  constexpr double kNamed_m = 1e-3, kMoved_m = 1.0;
  if (farthest_m > kMoved_m) {
    throw InputError(FilePlace{file, predictions.file_line, id},
                     fmt::format("was moved between the images, {:.1f} m from the mean of its "
                                 "positions: a block holds a point once; import the images apart, "
                                 "or give it another name for one of them",
                                 farthest_m));
  }
  if (farthest_m > kNamed_m) {
    warnings->push_back(fmt::format(
        "{}: {} is up to {:.1f} mm from the mean of its positions at the dates of the images, "
        "which is taken for all of them",
        file,
        id,
        1e3 * farthest_m));
  }
  return mean_m;
}

}  // namespace

SeenReflectors ReflectorsInImages(const Reflectors& reflectors,
                                  const std::vector<UtcTime>& first_lines,
                                  BlockBuilder* builder,
                                  std::vector<std::string>* warnings) {
  const double earth_m = NamedEllipsoid("WGS84").a_m;
  if (std::abs(builder->frame().ellipsoid().a_m - earth_m) > kSameRadius * earth_m) {
    throw InputError(FilePlace{reflectors.file, 0, ""},
                     "holds places on the Earth, the images are of another body");
  }
  std::map<std::string, ReflectorImages> seen;
  std::map<std::string, std::string> why;
  for (const ReflectorSurvey& survey : reflectors.surveys) {
    why[survey.id] = "it was surveyed only after the images, or is not valid for geometry";
  }
  for (std::size_t pass = 0; pass < first_lines.size(); ++pass) {
    for (const ReflectorPosition& at :
         ReflectorsAt(reflectors, first_lines[pass], builder->frame())) {
      why[at.id] = "by its position it is in none of the images";
      const auto place = builder->Locate(pass, at.position_m);
      if (!place) continue;
      ReflectorImages& predictions = seen[at.id];
      predictions.positions_m.push_back(at.position_m);
      predictions.places.emplace_back(pass, *place);
      predictions.file_line = at.file_line;
    }
  }
  SeenReflectors result;
  for (const auto& [id, predictions] : seen) {
    result.reflectors.push_back(
        {id, MeanPosition_m(reflectors.file, id, predictions, warnings), predictions.places});
    why.erase(id);
  }
  result.left_out.assign(why.begin(), why.end());
  return result;
}

}  // namespace sarblock
