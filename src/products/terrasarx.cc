// SPDX-License-Identifier: Apache-2.0
#include "terrasarx.h"

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

// Seconds from one line or sample to the next, compared with the times of the first and the last
// one.
double ReadSpacing_s(const XmlElement& element, double span_s, std::size_t count) {
  const double spacing_s = element.Positive();
  if (element.AttributeText("units") != "s") {
    element.Fail("its attribute units must be 's', got " + Quoted(element.AttributeText("units")));
  }
  const auto steps = static_cast<double>(count - 1);
  if (!(std::abs(span_s - steps * spacing_s) <= 1.5 * spacing_s)) {
    element.Fail(fmt::format("{} s contradicts sceneInfo: {} steps are {} s there",
                             NumberText(spacing_s),
                             count - 1,
                             NumberText(span_s)));
  }
  return spacing_s;
}

void ReadRaster(const XmlElement& info, TerraSarXProduct* product) {
  const XmlElement raster = info.Child("imageDataInfo").Child("imageRaster");
  product->lines = raster.Child("numberOfRows").Pixels();
  product->samples = raster.Child("numberOfColumns").Pixels();
  const XmlElement scene = info.Child("sceneInfo"), range = scene.Child("rangeTime");
  product->first_line = scene.Child("start").Child("timeUTC").Time();
  const double span_s =
      SecondsBetween(product->first_line, scene.Child("stop").Child("timeUTC").Time());
  const double first_s = range.Child("firstPixel").Positive();
  constexpr double kNearest_s = 1e-3;  // 150 km
  if (first_s < kNearest_s) {
    range.Child("firstPixel")
        .Fail(fmt::format("must be {} s or more, got {}", kNearest_s, NumberText(first_s)));
  }
  // Rows are azimuth lines; the spacing of rows is along them, that of columns across.
  product->line_interval_s = ReadSpacing_s(raster.Child("columnSpacing"), span_s, product->lines);
  product->last_line = AddSeconds(
      product->first_line, static_cast<double>(product->lines - 1) * product->line_interval_s);
  product->near_range_m = kRangePerTime_mps * first_s;
  product->range_spacing_m =
      kRangePerTime_mps * ReadSpacing_s(raster.Child("rowSpacing"),
                                        range.Child("lastPixel").Positive() - first_s,
                                        product->samples);
}

void ReadOrbit(const XmlElement& orbit, TerraSarXProduct* product) {
  const XmlElement header = orbit.Child("orbitHeader");
  const XmlElement frame = header.Child("stateVectorRefFrame");
  const std::string name = frame.Text();
  if (!name.starts_with("WGS84") && !name.starts_with("ITRF")) {
    frame.Fail("must be WGS84 or an ITRF (earth-fixed), got " + Quoted(name));
  }
  product->orbit_accuracy = header.Child("accuracy").Name();
  product->orbit = ReadFlatStates(orbit, "stateVec", "timeUTC");
}

}  // namespace

TerraSarXProduct ParseTerraSarX(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "level1Product");
  const XmlElement root = xml.Root(), info = root.Child("productInfo");
  const XmlElement variant = info.Child("productVariantInfo");
  constexpr const char* kSlantOnly = "products in ground range and map geometry are not read";
  variant.Child("productVariant").RequireText("SSC", kSlantOnly);
  variant.Child("projection").RequireText("SLANTRANGE", kSlantOnly);
  const XmlElement image = root.Child("productSpecific").Child("complexImageInfo");
  image.Child("imageCoordinateType").RequireText("ZERODOPPLER", "lines are zero-Doppler times");
  image.Child("imageDataStartWith")
      .RequireText("EARLYAZNEARRG", "lines run with time and samples away from the track");
  TerraSarXProduct product;
  product.file = file;
  product.mission = root.Child("generalHeader").Child("mission").Name();
  const XmlElement acquisition = info.Child("acquisitionInfo");
  product.mode = acquisition.Child("imagingMode").Name();
  product.side = ReadSide(acquisition.Child("lookDirection"), "LEFT", "RIGHT");
  product.wavelength_m =
      kSpeedOfLight_mps /
      root.Child("instrument").Child("radarParameters").Child("centerFrequency").Positive();
  ReadRaster(info, &product);
  ReadOrbit(root.Child("platform").Child("orbit"), &product);
  return product;
}

double RangeTimePolynomial::At_s(double tau_s) const {
  double value_s = 0.0;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
    value_s = value_s * (tau_s - reference_s) + *c;
  }
  return value_s;
}

LookDelay PropagationEffects::At(double range_m) const {
  const double tau_s = range_m / kRangePerTime_mps;
  LookDelay delay;
  for (const RangeTimePolynomial& term : range_delays) {
    delay.range_m += kRangePerTime_mps * term.At_s(tau_s);
  }
  for (const RangeTimePolynomial& term : azimuth_shifts) delay.time_s += term.At_s(tau_s);
  return delay;
}

std::string Describe(const PropagationEffects& effects) {
  const auto sum = [](const std::vector<RangeTimePolynomial>& terms, double factor, int digits) {
    double all = 0.0;
    std::string each;
    for (const RangeTimePolynomial& term : terms) {
      const double value = factor * term.At_s(term.reference_s);
      all += value;
      each += fmt::format("{}{} {:.{}f}", each.empty() ? "" : ", ", term.source, value, digits);
    }
    return std::pair(fmt::format("{:.{}f}", all, digits), each);
  };
  std::string text;
  if (!effects.range_delays.empty()) {
    const auto [all, each] = sum(effects.range_delays, kRangePerTime_mps, 4);
    text += fmt::format("range {} m ({})", all, each);
  }
  if (!effects.azimuth_shifts.empty()) {
    const auto [all, each] = sum(effects.azimuth_shifts, 1e6, 1);
    text += fmt::format("{}azimuth time {} us ({})", text.empty() ? "" : ", ", all, each);
  }
  return text;
}

namespace {

// The terms called `name`, none larger than `most_s` from near to far range.
std::vector<RangeTimePolynomial> ReadTerms(const XmlElement& effects,
                                           const char* name,
                                           double most_s,
                                           const TerraSarXProduct& product) {
  constexpr int kMaxDegree = 10;
  const double near_s = product.near_range_m / kRangePerTime_mps;
  const double far_s = near_s + static_cast<double>(product.samples - 1) * product.range_spacing_m /
                                    kRangePerTime_mps;
  std::vector<RangeTimePolynomial> terms;
  for (const XmlElement& element : effects.Children(name)) {
    RangeTimePolynomial term;
    term.source = element.AttributeText("source");
    term.reference_s = element.Child("referencePoint").Number();
    const double reach_s =
        std::max(std::abs(near_s - term.reference_s), std::abs(far_s - term.reference_s));
    double most = 0.0;
    for (const XmlElement& coefficient : element.Children("coefficient")) {
      const int exponent = coefficient.Attribute("exponent", kMaxDegree);
      term.coefficients.resize(
          std::max(term.coefficients.size(), static_cast<std::size_t>(exponent) + 1), 0.0);
      term.coefficients[static_cast<std::size_t>(exponent)] += coefficient.Number();
      most += std::abs(coefficient.Number()) * std::pow(reach_s, exponent);
    }
    if (term.coefficients.empty()) element.Fail("has no coefficient, one or more are needed");
    if (!(most <= most_s)) {
      element.Fail(fmt::format(
          "reaches {} s within the image, {} s at most is allowed", NumberText(most), most_s));
    }
    terms.push_back(std::move(term));
  }
  return terms;
}

/// Reads the points of a grid.
class GridReader {
 public:
  GridReader(const XmlElement& root, const TerraSarXProduct& product)
      : product_(product), earth_(Frame::Geocentric(NamedEllipsoid("WGS84"))) {
    const XmlElement sphere = root.Child("referenceFrames").Child("sphere");
    a_m_ = ReadAxis(sphere.Child("semiMajorAxis"));
    b_m_ = ReadAxis(sphere.Child("semiMinorAxis"));
    if (b_m_ > a_m_) sphere.Child("semiMinorAxis").Fail("is longer than semiMajorAxis");
    const XmlElement reference = root.Child("geolocationGrid").Child("gridReferenceTime");
    time_ = reference.Child("tReferenceTimeUTC").Time();
    range_time_s_ = reference.Child("tauReferenceTime").Number();
  }

  [[nodiscard]] TerraSarXGridPoint Read(const XmlElement& element) const {
    constexpr int kMost = 1'000'000;
    constexpr double kLongest_s = 1e4;  // of a data take
    TerraSarXGridPoint point;
    point.azimuth_index = element.Attribute("iaz", kMost);
    point.range_index = element.Attribute("irg", kMost);
    const XmlElement t = element.Child("t"), tau = element.Child("tau");
    if (std::abs(t.Number()) > kLongest_s) t.Fail("is not within an image, got " + t.Text() + " s");
    point.time = AddSeconds(time_, t.Number());
    point.range_m = kRangePerTime_mps * (range_time_s_ + tau.Number());
    if (!(point.range_m > 0.0)) tau.Fail("gives a range that is not above 0");
    RequireRaster(element.Child("row"),
                  SecondsBetween(product_.first_line, point.time) / product_.line_interval_s);
    RequireRaster(element.Child("col"),
                  (point.range_m - product_.near_range_m) / product_.range_spacing_m);
    point.place = ReadPlace(element);
    point.file_line = element.line();
    return point;
  }

 private:
  double ReadAxis(const XmlElement& element) const {
    const double axis_m = element.Positive();
    if (std::abs(axis_m - earth_.ellipsoid().a_m) > 0.01 * earth_.ellipsoid().a_m) {
      element.Fail("is not a semi-axis of the Earth, got " + element.Text());
    }
    return axis_m;
  }

  // Rows and columns are whole numbers from 1 on, up to one below the time and range of the point.
  static void RequireRaster(const XmlElement& element, double by_raster_px) {
    constexpr double kMost_px = 2.0;
    const int given_px = element.Count() - 1;
    if (std::abs(by_raster_px - given_px) <= kMost_px) return;
    element.Fail(fmt::format(
        "contradicts the image: its time or range is that of {:.1f}, {} from it is allowed; is "
        "this the GEOREF.xml of another product?",
        by_raster_px + 1.0,
        kMost_px));
  }

  [[nodiscard]] Geodetic ReadPlace(const XmlElement& element) const {
    const XmlElement lat = element.Child("lat"), lon = element.Child("lon");
    const XmlElement height = element.Child("height");
    const double lat_deg = lat.Number(), lon_deg = lon.Number(), h_m = height.Number();
    if (std::abs(lat_deg) > 90.0) lat.Fail("is not between -90 and 90 degrees");
    if (std::abs(lon_deg) > 360.0) lon.Fail("is not between -360 and 360 degrees");
    constexpr double kHighest_m = 20e3;
    if (std::abs(h_m) > kHighest_m) height.Fail("is not between -20 and 20 km");
    const Frame grown = Frame::Geocentric({"", a_m_ + h_m, (a_m_ - b_m_) / (a_m_ + h_m)});
    return earth_.GeodeticFromFrame(
        grown.FrameFromGeodetic({lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, 0.0}));
  }

  const TerraSarXProduct& product_;
  Frame earth_;
  double a_m_ = 0.0, b_m_ = 0.0;
  UtcTime time_;
  double range_time_s_ = 0.0;
};

std::vector<TerraSarXGridPoint> ReadGrid(const XmlElement& root, const TerraSarXProduct& product) {
  const GridReader reader(root, product);
  const XmlElement list = root.Child("geolocationGrid");
  std::vector<TerraSarXGridPoint> grid;
  for (const XmlElement& element : list.Children("gridPoint")) grid.push_back(reader.Read(element));
  if (grid.empty()) list.Fail("has no gridPoint");
  return grid;
}

}  // namespace

void AddGeoref(std::string_view text, const std::string& file, TerraSarXProduct* product) {
  constexpr double kMostDelay_s = 1e-6;  // of two-way time: 150 m
  constexpr double kMostShift_s = 0.01;
  const XmlFile xml(text, file, "geoReference");
  const XmlElement effects = xml.Root().Child("signalPropagationEffects");
  product->georef_file = file;
  product->effects = {ReadTerms(effects, "rangeDelay", kMostDelay_s, *product),
                      ReadTerms(effects, "azimuthShift", kMostShift_s, *product)};
  product->grid = ReadGrid(xml.Root(), *product);
}

ImagePass PassOfTerraSarX(const TerraSarXProduct& product,
                          const ImportOptions& options,
                          std::vector<std::string>* warnings) {
  ImagePass image = PassOfZeroDopplerImage(
      product,
      product.mission + "_" + product.mode + "_" + CompactTime(product.first_line),
      "level1Product.platform.orbit",
      options.through.value_or(OrbitThrough::kPositions),
      options,
      warnings);
  if (!options.reduce) return image;
  if (!product.georef_file.empty()) {
    image.delay = [effects = product.effects](const RadarCoordinates& measured) {
      return effects.At(measured.range_m);
    };
    return image;
  }
  image.pass.reduction.troposphere = TroposphereModel::kStandard;
  warnings->push_back(
      product.file +
      ": no GEOREF.xml in ANNOTATION beside it or in its folder: the delays of this "
      "product are not known. The standard troposphere is reduced, a shift of "
      "azimuth times (some 0.2 ms) is not");
  return image;
}

}  // namespace sarblock
