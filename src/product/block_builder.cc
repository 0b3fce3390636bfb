// SPDX-License-Identifier: Apache-2.0
#include "block_builder.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <unordered_set>
#include <utility>

#include "core/text.h"
#include "sicd_projection.h"
#include <fmt/core.h>

namespace sarblock {
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

KnownPosition EquallyKnown(std::uint32_t point, const std::array<bool, 3>& held, double sigma_m) {
  KnownPosition known{point, held, Eigen::Matrix3d::Zero()};
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (held[static_cast<std::size_t>(k)]) known.covariance_enu_m2(k, k) = sigma_m * sigma_m;
  }
  return known;
}

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
  block_.passes.push_back(std::move(image.pass));
  images_.push_back(std::move(image));
  match_counts_.push_back(0);
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
  looks.pass.push_back(look.pass);
  looks.flags.push_back(measured ? look.flags | Looks::kDoppler : look.flags);
  looks.time_s.push_back(look.time_s);
  looks.range_m.push_back(look.range_m);
  point_of_look_.push_back(look.point);
}

bool BlockBuilder::Contains(const ImagePass& image, const ImageCoordinates& place) const {
  const auto within = [](double value_px, std::size_t count) {
    return count == 0 || (value_px >= -0.5 && value_px <= static_cast<double>(count) - 0.5);
  };
  return within(place.line_px, image.lines) && within(place.pixel_px, image.samples);
}

std::optional<ImageCoordinates> BlockBuilder::Locate(std::size_t pass,
                                                     const Eigen::Vector3d& p_m) const {
  const ImagePass& image = images_[pass];
  const auto place = image.aperture ? PlaceInSicd(image.aperture->sicd, p_m)
                                    : PlaceInImage(block_.passes[pass], p_m);
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
    AddLook(look);
    ++match_counts_[look.pass];
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
    offsets_.Add(look.pass, block_.passes[look.pass], {look.time_s, look.range_m}, p_m);
  } else if (const auto given_px = PlaceInSicd(aperture->sicd, p_m)) {
    offsets_.Add(look.pass, PlaceOf(matches, row), *given_px);
  }
}

void BlockBuilder::FailOutside(const MatchedPoints& matches,
                               const MatchedPoint& row,
                               const ImagePass& image,
                               const char* problem) const {
  const bool range_down = image.axes != RasterAxes::kAzimuthDown;
  throw InputError(
      FilePlace{matches.file, row.file_line, "line"},
      fmt::format("line {} and sample {} are outside image {}: {}",
                  NumberText(row.line_px),
                  NumberText(row.sample_px),
                  Quoted(row.image),
                  problem != nullptr ? problem
                                     : fmt::format("it has {} lines and {} samples",
                                                   range_down ? image.samples : image.lines,
                                                   range_down ? image.lines : image.samples)));
}

void BlockBuilder::SetApertureMatch(const MatchedPoints& matches,
                                    const MatchedPoint& row,
                                    const ImageCoordinates& place,
                                    NewLook* look) const {
  const ImagePass& image = images_[look->pass];
  const Pass& pass = block_.passes[look->pass];
  const SicdImage& sicd = image.aperture->sicd;
  const auto measured = LookOfPlace(sicd, place.line_px, place.pixel_px);
  if (!measured) FailOutside(matches, row, image, "they have no range and range rate");
  look->time_s = measured->time_s + image.aperture->start_s;
  if (!pass.path.At(look->time_s)) {
    FailOutside(matches, row, image, "its path does not cover the time");
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
  if (!sigma) FailOutside(matches, row, image, "range and range rate do not change there");
  if (!std::isnan(row.line_sigma_px)) look->range_sigma_m = sigma->range_m;
  if (!std::isnan(row.sample_sigma_px)) {
    look->azimuth_sigma = sigma->range_rate_mps * hertz_per_mps;
    look->flags |= Looks::kAzimuthHertz;
  }
}

void BlockBuilder::SetMatch(const MatchedPoints& matches,
                            const MatchedPoint& row,
                            NewLook* look) const {
  const Pass& pass = block_.passes[look->pass];
  const ImagePass& image = images_[look->pass];
  const ImageCoordinates place = RasterFromFile(image, PlaceOf(matches, row));
  if (!Contains(image, place)) FailOutside(matches, row, image, nullptr);
  if (image.aperture) return SetApertureMatch(matches, row, place, look);
  const auto radar = RadarFromImage(*pass.image, place);
  if (!radar) FailOutside(matches, row, image, "they have no slant range");
  if (!pass.path.At(radar->time_s)) {
    FailOutside(matches, row, image, "its path does not cover the time");
  }
  const bool range_down = image.axes != RasterAxes::kAzimuthDown;
  look->time_s = radar->time_s;
  look->range_m = radar->range_m;
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

}  // namespace sarblock
