// SPDX-License-Identifier: Apache-2.0
#include "product/sentinel1.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "orbit_path.h"
#include "xml_reader.h"

namespace sarblock {
namespace {

constexpr double kRangePerTime_mps = 0.5 * kSpeedOfLight_mps;  // two-way time to one-way range

Eigen::Vector3d ReadVector(const XmlElement& element, const char* x, const char* y, const char* z) {
  return {element.Child(x).Number(), element.Child(y).Number(), element.Child(z).Number()};
}

void AppendState(const XmlElement& element, const OrbitState& state, std::vector<OrbitState>* all) {
  const auto problem = ProblemOfState(all->empty() ? nullptr : &all->back(), state);
  if (problem) element.Fail(*problem);
  all->push_back(state);
}

void ReadOrbit(const XmlElement& list, std::vector<OrbitState>* states) {
  for (const XmlElement& orbit : list.Children("orbit")) {
    const XmlElement frame = orbit.Child("frame");
    if (frame.Text() != "Earth Fixed") {
      frame.Fail("'" + frame.Text() + "' is not allowed, 'Earth Fixed' is");
    }
    AppendState(orbit,
                {orbit.Child("time").Time(),
                 ReadVector(orbit.Child("position"), "x", "y", "z"),
                 ReadVector(orbit.Child("velocity"), "x", "y", "z")},
                states);
  }
  if (states->size() < 2) list.Fail("has fewer than two states, a path needs two or more");
}

GeolocationGridPoint ReadGridPoint(const XmlElement& element) {
  GeolocationGridPoint point;
  point.line = element.Child("line").Count();
  point.pixel = element.Child("pixel").Count();
  point.time = element.Child("azimuthTime").Time();
  point.slant_range_m = kRangePerTime_mps * element.Child("slantRangeTime").Positive();
  const XmlElement lat = element.Child("latitude"), lon = element.Child("longitude");
  const double lat_deg = lat.Number(), lon_deg = lon.Number();
  if (std::abs(lat_deg) > 90.0) lat.Fail("is not between -90 and 90 degrees");
  if (std::abs(lon_deg) > 360.0) lon.Fail("is not between -360 and 360 degrees");
  point.place = {lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, element.Child("height").Number()};
  constexpr double kHighest_m = 20e3;
  if (std::abs(point.place.h_m) > kHighest_m) {
    element.Child("height").Fail("is not between -20 and 20 km");
  }
  point.file_line = element.line();
  return point;
}

void ReadGrid(const XmlElement& list, std::vector<GeolocationGridPoint>* grid) {
  std::vector<std::pair<std::pair<int, int>, XmlElement>> places;
  for (const XmlElement& element : list.Children("geolocationGridPoint")) {
    grid->push_back(ReadGridPoint(element));
    places.push_back({{grid->back().line, grid->back().pixel}, element});
  }
  if (grid->empty()) list.Fail("has no geolocationGridPoint");
  const auto by_place = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::stable_sort(places.begin(), places.end(), by_place);
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i].first == places[i - 1].first) {
      places[i].second.Fail("line " + std::to_string(places[i].first.first) + ", pixel " +
                            std::to_string(places[i].first.second) + " stands twice");
    }
  }
  std::stable_sort(grid->begin(), grid->end(), [](const auto& a, const auto& b) {
    return std::pair(a.line, a.pixel) < std::pair(b.line, b.pixel);
  });
}

void ReadGroundRange(const XmlElement& root, Sentinel1Product* product) {
  const XmlElement list = root.Child("coordinateConversion").Child("coordinateConversionList");
  for (const XmlElement& element : list.Children("coordinateConversion")) {
    ProductGroundRange polynomial{element.Child("azimuthTime").Time(),
                                  element.Child("gr0").Number(),
                                  element.Child("grsrCoefficients").Numbers()};
    auto& all = product->ground_range;
    if (!all.empty() && !(SecondsBetween(all.back().time, polynomial.time) > 0.0)) {
      element.Fail("its azimuthTime is not after that of the one before");
    }
    if (polynomial.coefficients.size() < 2) {
      element.Child("grsrCoefficients").Fail("has one coefficient, two or more are needed");
    }
    all.push_back(std::move(polynomial));
  }
  if (product->ground_range.empty()) {
    list.Fail("is empty, a ground range product needs its polynomials");
  }
}

void ReadBursts(const XmlElement& root, Sentinel1Product* product) {
  const auto timing = root.Find("swathTiming");
  const auto list = timing ? timing->Find("burstList") : std::nullopt;
  if (!list) return;
  for (const XmlElement& burst : list->Children("burst")) {
    const UtcTime time = burst.Child("azimuthTime").Time();
    if (!product->bursts.empty() && !(SecondsBetween(product->bursts.back(), time) > 0.0)) {
      burst.Fail("its azimuthTime is not after that of the burst before");
    }
    product->bursts.push_back(time);
  }
  if (product->bursts.empty()) return;
  const XmlElement lines = timing->Child("linesPerBurst");
  product->lines_per_burst = lines.Count();
  if (product->lines_per_burst == 0) lines.Fail("is 0 although there are bursts");
}

void ReadImage(const XmlElement& root, const XmlElement& information, Sentinel1Product* product) {
  const XmlElement image = root.Child("imageAnnotation").Child("imageInformation");
  product->first_line = image.Child("productFirstLineUtcTime").Time();
  product->last_line = image.Child("productLastLineUtcTime").Time();
  if (!(SecondsBetween(product->first_line, product->last_line) > 0.0)) {
    image.Child("productLastLineUtcTime").Fail("is not after productFirstLineUtcTime");
  }
  product->line_interval_s = image.Child("azimuthTimeInterval").Positive();
  const XmlElement projection = information.Child("projection");
  if (projection.Text() == "Slant Range") {
    product->near_range_m = kRangePerTime_mps * image.Child("slantRangeTime").Positive();
    product->range_spacing_m =
        kRangePerTime_mps / information.Child("rangeSamplingRate").Positive();
    ReadBursts(root, product);
  } else if (projection.Text() == "Ground Range") {
    product->presentation = Presentation::kGround;
    product->range_spacing_m = image.Child("rangePixelSpacing").Positive();
    ReadGroundRange(root, product);
  } else {
    projection.Fail("'" + projection.Text() +
                    "' is not allowed, 'Slant Range' or 'Ground Range' is");
  }
}

std::string OptionalText(const XmlElement& element, const char* name) {
  const auto child = element.Find(name);
  return child ? child->Text() : std::string();
}

// A name that becomes part of an id.
std::string Name(const XmlElement& element) {
  const std::string name = element.Text();
  const auto odd = [](char c) { return static_cast<unsigned char>(c) <= 0x20 || c == 0x7f; };
  if (name.size() > 20 || std::any_of(name.begin(), name.end(), odd)) {
    element.Fail("is not a short name without blanks");
  }
  return name;
}

}  // namespace

Sentinel1Product ParseSentinel1(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "product");
  const XmlElement root = xml.Root();
  Sentinel1Product product;
  product.file = file;
  const XmlElement header = root.Child("adsHeader");
  product.mission = Name(header.Child("missionId"));
  product.swath = Name(header.Child("swath"));
  product.polarisation = Name(header.Child("polarisation"));
  const XmlElement general = root.Child("generalAnnotation");
  const XmlElement information = general.Child("productInformation");
  product.wavelength_m = kSpeedOfLight_mps / information.Child("radarFrequency").Positive();
  ReadImage(root, information, &product);
  if (const auto processing = root.Child("imageAnnotation").Find("processingInformation")) {
    product.orbit_source = OptionalText(*processing, "orbitSource");
  }
  ReadOrbit(general.Child("orbitList"), &product.orbit);
  ReadGrid(root.Child("geolocationGrid").Child("geolocationGridPointList"), &product.grid);
  return product;
}

OrbitFile ParseOrbitFile(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "Earth_Explorer_File");
  const XmlElement header = xml.Root().Child("Earth_Explorer_Header");
  OrbitFile orbit;
  orbit.file = file;
  orbit.mission = header.Child("Fixed_Header").Child("Mission").Text();
  const XmlElement frame = header.Child("Variable_Header").Child("Ref_Frame");
  if (frame.Text() != "EARTH_FIXED") {
    frame.Fail("'" + frame.Text() + "' is not allowed, 'EARTH_FIXED' is");
  }
  const XmlElement list = xml.Root().Child("Data_Block").Child("List_of_OSVs");
  for (const XmlElement& element : list.Children("OSV")) {
    AppendState(element,
                {element.Child("UTC").Time(),
                 ReadVector(element, "X", "Y", "Z"),
                 ReadVector(element, "VX", "VY", "VZ")},
                &orbit.states);
  }
  if (orbit.states.size() < 2) list.Fail("has fewer than two states, a path needs two or more");
  return orbit;
}

}  // namespace sarblock
