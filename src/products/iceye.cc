// SPDX-License-Identifier: Apache-2.0
#include "iceye.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.h"
#include "image_table.h"
#include "xml.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// Elements `coefficient`, numbered from 1 in this order.
std::vector<double> ReadCoefficients(const XmlElement& list) {
  std::vector<double> values;
  for (const XmlElement& element : list.Children("coefficient")) {
    const XmlElement number = element.Child("number");
    if (number.Count() != static_cast<int>(values.size()) + 1) {
      number.Fail(fmt::format("must be {}, got {}", values.size() + 1, number.Text()));
    }
    values.push_back(element.Child("value").Number());
  }
  if (values.size() < 2) list.Fail("has fewer than two coefficients, two or more are needed");
  return values;
}

// `COLUMN ROW LATITUDE LONGITUDE`, in brackets and with commas or not; columns and rows from 1.
IceyePlace ReadCorner(const XmlElement& root, const char* name) {
  const XmlElement element = root.Child(name);
  std::string text = element.Text();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '['; }, ' ');
  if (text.ends_with(']')) text.pop_back();
  const auto numbers = NumbersOf(text);
  constexpr double kMax_px = 1e7;
  const auto pixel = [](double value) {
    return value >= 1.0 && value <= kMax_px && value == std::floor(value);
  };
  if (!numbers || numbers->size() != 4 || !pixel((*numbers)[0]) || !pixel((*numbers)[1]) ||
      std::abs((*numbers)[2]) > 90.0 || std::abs((*numbers)[3]) > 360.0) {
    element.Fail("must be column, row, latitude and longitude, got " + Quoted(element.Text()));
  }
  return {name,
          static_cast<int>((*numbers)[1]) - 1,
          static_cast<int>((*numbers)[0]) - 1,
          (*numbers)[2] * kRadPerDeg,
          (*numbers)[3] * kRadPerDeg,
          element.line()};
}

void ReadCorners(const XmlElement& root, IceyeProduct* product) {
  for (const char* name : {"coord_first_near",
                           "coord_first_far",
                           "coord_last_near",
                           "coord_last_far",
                           "coord_center"}) {
    product->places.push_back(ReadCorner(root, name));
  }
  const IceyePlace &near = product->places[0], &far = product->places[3];
  const bool whole = near.line == 0 && near.sample == 0 &&
                     static_cast<std::size_t>(far.line) + 1 == product->lines &&
                     static_cast<std::size_t>(far.sample) + 1 == product->samples;
  if (!whole) {
    root.Child("coord_first_near")
        .Fail(
            "the image must run with time and away from the track: from column 1, row 1 at "
            "coord_first_near to its last column and row at coord_last_far");
  }
}

std::optional<RationalPolynomials> ReadRpc(const XmlElement& root) {
  const auto element = root.Find("RPC");
  if (!element) return std::nullopt;
  RationalPolynomials rpc;
  constexpr std::array<const char*, 5> kQuantities{"LINE", "SAMP", "LAT", "LONG", "HEIGHT"};
  for (std::size_t k = 0; k < kQuantities.size(); ++k) {
    rpc.offset[k] = element->Child((std::string(kQuantities[k]) + "_OFF").c_str()).Number();
    rpc.scale[k] = element->Child((std::string(kQuantities[k]) + "_SCALE").c_str()).Positive();
  }
  constexpr std::array<const char*, 4> kPolynomials{
      "LINE_NUM_COEFF", "LINE_DEN_COEFF", "SAMP_NUM_COEFF", "SAMP_DEN_COEFF"};
  for (std::size_t k = 0; k < kPolynomials.size(); ++k) {
    const XmlElement list = element->Child(kPolynomials[k]);
    const std::vector<double> numbers = list.Numbers();
    if (numbers.size() != rpc.coefficients[k].size()) {
      list.Fail(fmt::format("must have 20 numbers, got {}", numbers.size()));
    }
    std::copy(numbers.begin(), numbers.end(), rpc.coefficients[k].begin());
  }
  return rpc;
}

}  // namespace

IceyeProduct ParseIceye(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "Metadata");
  const XmlElement root = xml.Root();
  IceyeProduct product;
  product.file = file;
  product.satellite = root.Child("satellite_name").Name();
  root.Child("product_level").RequireText("GRD", "other products are not read");
  root.Child("geo_ref_system").RequireText("WGS84", "states are earth-fixed");
  product.side = ReadSide(root.Child("look_side"), "left", "right");
  product.wavelength_m = kSpeedOfLight_mps / root.Child("carrier_frequency").Positive();
  product.lines = root.Child("number_of_azimuth_samples").Pixels();
  product.samples = root.Child("number_of_range_samples").Pixels();
  product.first_line = root.Child("zerodoppler_start_utc").Time();
  product.last_line = root.Child("zerodoppler_end_utc").Time();
  const XmlElement interval = root.Child("azimuth_time_interval");
  product.line_interval_s = interval.Positive();
  const double span_s = SecondsBetween(product.first_line, product.last_line);
  const auto steps = static_cast<double>(product.lines - 1);
  if (!(std::abs(span_s - steps * product.line_interval_s) <= 1.5 * product.line_interval_s)) {
    interval.Fail(
        fmt::format("{} s contradicts the times of the first and last line: {} s over {} "
                    "lines",
                    interval.Text(),
                    NumberText(span_s),
                    product.lines));
  }
  product.range_spacing_m = root.Child("range_spacing").Positive();
  const XmlElement ground = root.Child("GRSR_Coefficients");
  product.ground_range.push_back({ground.Child("zero_doppler_time").Time(),
                                  ground.Child("ground_range_origin").Number(),
                                  ReadCoefficients(ground)});
  product.orbit = ReadFlatStates(root.Child("Orbit_State_Vectors"), "orbit_vector", "time");
  product.orbit_level = root.Child("orbit_processing_level").Name();
  if (const auto delay = root.Find("tropo_range_delay")) {
    constexpr double kMost_m = 150.0;
    product.troposphere_m = delay->Number();
    if (!(product.troposphere_m >= 0.0 && product.troposphere_m <= kMost_m)) {
      delay->Fail(fmt::format("must be 0 to {} m, got {}", kMost_m, delay->Text()));
    }
  }
  const XmlElement height = root.Child("avg_scene_height");
  constexpr double kHighest_m = 20e3;
  product.scene_height_m = height.Number();
  if (std::abs(product.scene_height_m) > kHighest_m) height.Fail("is not between -20 and 20 km");
  ReadCorners(root, &product);
  product.rpc = ReadRpc(root);
  return product;
}

ImageCoordinates RationalPolynomials::At(const Geodetic& place) const {
  const double p = (place.lat_rad / kRadPerDeg - offset[2]) / scale[2];
  const double l = (place.lon_rad / kRadPerDeg - offset[3]) / scale[3];
  const double h = (place.h_m - offset[4]) / scale[4];
  const std::array<double, 20> terms{1.0,       l,         p,         h,         l * p,
                                     l * h,     p * h,     l * l,     p * p,     h * h,
                                     p * l * h, l * l * l, l * p * p, l * h * h, l * l * p,
                                     p * p * p, p * h * h, l * l * h, p * p * h, h * h * h};
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t k = 0; k < terms.size(); ++k) values[i] += coefficients[i][k] * terms[k];
  }
  return {offset[0] + scale[0] * values[0] / values[1],
          offset[1] + scale[1] * values[2] / values[3]};
}

namespace {

// Holds the places that the metadata name, at the scene's height, against raster and path.
void HoldPlaces(const IceyeProduct& product, const Pass& pass) {
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  for (const IceyePlace& place : product.places) {
    const FilePlace file_place{product.file, place.file_line, place.name};
    const Geodetic at{place.lat_rad, place.lon_rad, product.scene_height_m};
    const auto seen = PlaceInImage(pass, earth.FrameFromGeodetic(at));
    constexpr double kMaxOff_px = 2.0;
    // Samples depend on the height of the ground, lines do not.
    if (!seen || !(std::abs(seen->line_px - place.line) <= kMaxOff_px)) {
      throw InputError(file_place,
                       fmt::format("is at line {} of the image by its row, by orbit and times {}; "
                                   "{} lines are allowed",
                                   place.line,
                                   seen ? "at line " + Digits(seen->line_px, 7) : "outside",
                                   kMaxOff_px));
    }
    const auto radar = RadarFromImage(*pass.image, *seen);
    constexpr double kAnyMisfit = 1e9;
    const auto fit =
        radar ? FitGridPoint({radar->time_s, radar->range_m, at}, earth, pass.path, kAnyMisfit)
              : std::nullopt;
    if (fit && fit->side != product.side) {
      throw InputError(file_place,
                       fmt::format("lies to the {} of the flight, look_side is {}",
                                   fit->side == LookSide::kLeft ? "left" : "right",
                                   product.side == LookSide::kLeft ? "left" : "right"));
    }
  }
}

// Largest distances of the rational polynomials from raster and path, at the scene's height.
ImageCoordinates HoldRpc(const IceyeProduct& product, const Pass& pass) {
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  ImageCoordinates off;
  for (const IceyePlace& place : product.places) {
    const Geodetic at{place.lat_rad, place.lon_rad, product.scene_height_m};
    const auto seen = PlaceInImage(pass, earth.FrameFromGeodetic(at));
    if (!seen) continue;
    const ImageCoordinates rpc = product.rpc->At(at);
    const double line_px = std::abs(rpc.line_px - seen->line_px);
    const double sample_px = std::abs(rpc.pixel_px - seen->pixel_px);
    if (!(line_px <= 1.0 && sample_px <= 1.0)) {
      throw InputError(FilePlace{product.file, place.file_line, place.name},
                       fmt::format("is {} lines and {} samples from where the RPC see it, 1 is "
                                   "allowed: orbit, times or ranges are wrong, or the RPC",
                                   Digits(line_px, 4),
                                   Digits(sample_px, 4)));
    }
    off.line_px = std::max(off.line_px, line_px);
    off.pixel_px = std::max(off.pixel_px, sample_px);
  }
  return off;
}

}  // namespace

ImagePass PassOfIceye(const IceyeProduct& product,
                      const ImportOptions& options,
                      std::vector<std::string>* warnings,
                      std::string* stated) {
  ImagePass image =
      PassOfZeroDopplerImage(product,
                             product.satellite + "_GRD_" + CompactTime(product.first_line),
                             "Metadata.Orbit_State_Vectors",
                             options.through.value_or(OrbitThrough::kStates),
                             options,
                             warnings);
  if (!image.middle) {
    throw InputError(FilePlace{product.file, 0, "Metadata.GRSR_Coefficients"},
                     "give no slant range in the middle of the image");
  }
  HoldPlaces(product, image.pass);
  if (product.troposphere_m > 0.0) {
    *stated = fmt::format("its processor took {:.4f} m of troposphere off the ranges",
                          product.troposphere_m);
  } else {
    *stated = "its processor took no delay off the ranges";
    if (options.reduce) image.pass.reduction.troposphere = TroposphereModel::kStandard;
  }
  if (product.rpc) {
    const ImageCoordinates off = HoldRpc(product, image.pass);
    *stated += fmt::format(
        "; its RPC agree within {:.3f} lines and {:.3f} samples", off.line_px, off.pixel_px);
  }
  return image;
}

}  // namespace sarblock
