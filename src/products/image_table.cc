// SPDX-License-Identifier: Apache-2.0
#include "image_table.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "core/text.h"
#include "core/utc.h"
#include "csm.h"
#include "geometry/recorded_states.h"
#include "image.h"
#include "tables/hdf5_file.h"
#include "xml.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

std::vector<OrbitState> ReadOrbit(const XmlElement& list) {
  return ReadStates(list, "orbit", [](const XmlElement& orbit) -> OrbitState {
    const XmlElement frame = orbit.Child("frame");
    if (frame.Text() != "Earth Fixed") {
      frame.Fail("must be 'Earth Fixed', got '" + frame.Text() + "'");
    }
    return {orbit.Child("time").Time(),
            ReadVector(orbit.Child("position"), "x", "y", "z"),
            ReadVector(orbit.Child("velocity"), "x", "y", "z")};
  });
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

// The points; of a grid that is only compared, those that make no sense are left out with a
// warning.
void ReadGrid(const XmlElement& list, PartUse use, Sentinel1Product* product) {
  std::vector<GeolocationGridPoint>* const grid = &product->grid;
  std::vector<std::pair<std::pair<int, int>, XmlElement>> places;
  std::size_t left_out = 0;
  std::string first;
  for (const XmlElement& element : list.Children("geolocationGridPoint")) {
    try {
      grid->push_back(ReadGridPoint(element));
      places.push_back({{grid->back().line, grid->back().pixel}, element});
    } catch (const InputError& error) {
      if (use == PartUse::kUsed) throw;
      if (left_out++ == 0) first = error.what();
    }
  }
  if (grid->empty()) list.Fail("has no geolocationGridPoint" + (first.empty() ? "" : ": " + first));
  if (left_out > 0) {
    product->warnings.push_back(fmt::format("{}: {} of {} grid points are left out, the first: {}",
                                            product->file,
                                            left_out,
                                            left_out + grid->size(),
                                            first));
  }
  const auto by_place = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::stable_sort(places.begin(), places.end(), by_place);
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i].first == places[i - 1].first) {
      places[i].second.Fail("line " + std::to_string(places[i].first.first) + ", pixel " +
                            std::to_string(places[i].first.second) + " is given twice");
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

// firstValidSample and lastValidSample of a burst, one number per line each; -1: none.
void ReadValidSamples(const XmlElement& burst, int lines, std::vector<ValidSamples>* all) {
  const auto first = burst.Find("firstValidSample"), last = burst.Find("lastValidSample");
  if (!first || !last) return;
  const auto read = [lines](const XmlElement& element) {
    std::vector<double> numbers = element.Numbers();
    if (numbers.size() != static_cast<std::size_t>(lines)) {
      element.Fail(fmt::format(
          "must have {} numbers, one per line of the burst, got {}", lines, numbers.size()));
    }
    return numbers;
  };
  constexpr double kNone = -1.0, kLargest = 1e9;
  const std::vector<double> begin = read(*first), end = read(*last);
  for (std::size_t i = 0; i < begin.size(); ++i) {
    all->push_back({static_cast<int>(std::clamp(begin[i], kNone, kLargest)),
                    static_cast<int>(std::clamp(end[i], kNone, kLargest))});
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
  for (const XmlElement& burst : list->Children("burst")) {
    ReadValidSamples(burst, product->lines_per_burst, &product->valid_samples);
  }
  const std::size_t in_bursts =
      product->bursts.size() * static_cast<std::size_t>(product->lines_per_burst);
  if (product->valid_samples.size() != in_bursts) product->valid_samples.clear();
}

void ReadImage(const XmlElement& root, const XmlElement& information, Sentinel1Product* product) {
  const XmlElement image = root.Child("imageAnnotation").Child("imageInformation");
  product->first_line = image.Child("productFirstLineUtcTime").Time();
  product->last_line = image.Child("productLastLineUtcTime").Time();
  if (!(SecondsBetween(product->first_line, product->last_line) > 0.0)) {
    image.Child("productLastLineUtcTime").Fail("is not after productFirstLineUtcTime");
  }
  product->line_interval_s = image.Child("azimuthTimeInterval").Positive();
  if (const auto lines = image.Find("numberOfLines")) {
    product->lines = static_cast<std::size_t>(lines->Count());
  }
  if (const auto samples = image.Find("numberOfSamples")) {
    product->samples = static_cast<std::size_t>(samples->Count());
  }
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
    projection.Fail("must be 'Slant Range' or 'Ground Range', got '" + projection.Text() + "'");
  }
}

std::string OptionalText(const XmlElement& element, const char* name) {
  const auto child = element.Find(name);
  return child ? child->Text() : std::string();
}

}  // namespace

Sentinel1Product ParseSentinel1(std::string_view text,
                                const std::string& file,
                                const Sentinel1Use& use) {
  const XmlFile xml(text, file, "product");
  const XmlElement root = xml.Root();
  Sentinel1Product product;
  product.file = file;
  const XmlElement header = root.Child("adsHeader");
  product.mission = header.Child("missionId").Name();
  product.swath = header.Child("swath").Name();
  product.polarisation = header.Child("polarisation").Name();
  const XmlElement general = root.Child("generalAnnotation");
  const XmlElement information = general.Child("productInformation");
  product.wavelength_m = kSpeedOfLight_mps / information.Child("radarFrequency").Positive();
  ReadImage(root, information, &product);
  if (const auto processing = root.Child("imageAnnotation").Find("processingInformation")) {
    product.orbit_source = OptionalText(*processing, "orbitSource");
  }
  try {
    product.orbit = ReadOrbit(general.Child("orbitList"));
  } catch (const InputError& error) {
    if (use.orbit == PartUse::kUsed) throw;
    product.warnings.push_back(std::string("the annotated orbit is not used: ") + error.what());
  }
  ReadGrid(root.Child("geolocationGrid").Child("geolocationGridPointList"), use.grid, &product);
  product.radar = ReadSentinel1Radar(root);
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
    frame.Fail("must be 'EARTH_FIXED', got '" + frame.Text() + "'");
  }
  const XmlElement list = xml.Root().Child("Data_Block").Child("List_of_OSVs");
  orbit.states = ReadStates(list, "OSV", [&orbit](const XmlElement& element) -> OrbitState {
    orbit.quality.push_back(OptionalText(element, "Quality"));
    return {element.Child("UTC").Time(),
            ReadVector(element, "X", "Y", "Z"),
            ReadVector(element, "VX", "VY", "VZ")};
  });
  return orbit;
}

namespace {

constexpr std::size_t kMaxLines = 10'000'000;  // and samples
constexpr std::size_t kMaxStates = 10'000;
constexpr std::size_t kMaxGridPoints = std::size_t{1} << 25;

/// The group of the image, with its band.
struct Root {
  std::string band;
  std::string path;  // "/science/LSAR/RSLC"
};
Root FindRoot(const Hdf5Values& file) {
  for (const char* band : {"LSAR", "SSAR"}) {
    for (const char* product : {"RSLC", "SLC"}) {
      std::string path = std::string("/science/") + band + "/" + product;
      if (file.Has(path)) return {band, std::move(path)};
    }
  }
  file.Fail("/science/LSAR/RSLC",
            "is missing: an RSLC of NISAR is needed; products in map geometry have no times and "
            "ranges");
}

/// Seconds from an epoch that the attribute "units" gives.
struct Times {
  UtcTime epoch;
  std::vector<double> seconds_s;
  [[nodiscard]] UtcTime At(std::size_t i) const { return AddSeconds(epoch, seconds_s[i]); }
};
Times ReadTimes(const Hdf5Values& file, const std::string& path, std::size_t most) {
  constexpr std::string_view kSince = "seconds since ";
  std::string units = file.TextAttribute(path, "units");
  std::optional<UtcTime> epoch;
  if (units.starts_with(kSince)) {
    std::string text = units.substr(kSince.size());
    if (text.size() > 10 && text[10] == ' ') text[10] = 'T';
    epoch = ParseUtc(text);
  }
  if (!epoch) {
    file.Fail(path + " (units)",
              "must be 'seconds since ' and a UTC time from 1972 on, got " + Quoted(units));
  }
  constexpr double kMax_s = 1e9;
  Times times{*epoch, file.Numbers(path, 1, most).values};
  for (const double seconds_s : times.seconds_s) {
    if (std::abs(seconds_s) > kMax_s) {
      file.Fail(path, NumberText(seconds_s) + " s are no time of an image");
    }
  }
  return times;
}

/// First value and step of values that must be evenly spaced.
struct Axis {
  double first = 0.0, step = 0.0;
};
Axis EvenAxis(const Hdf5Values& file, const std::string& path, const std::vector<double>& values) {
  if (values.size() < 2) file.Fail(path, "has one value, two or more are needed");
  const Axis axis{values.front(),
                  (values.back() - values.front()) / static_cast<double>(values.size() - 1)};
  if (!(axis.step > 0.0)) file.Fail(path, "must increase");
  constexpr double kUneven = 0.01;  // of a step: times of seconds in a day are good to 1e-11 s
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = values[i] - (axis.first + static_cast<double>(i) * axis.step);
    if (std::abs(off) > kUneven * axis.step) {
      file.Fail(path + "[" + std::to_string(i) + "]",
                NumberText(values[i]) + " is not evenly spaced: " + NumberText(axis.step) +
                    " from one to the next is");
    }
  }
  return axis;
}

double Positive(const Hdf5Values& file, const std::string& path) {
  const double value = file.Number(path);
  if (const char* problem = ProblemOfPositive(value))
    file.Fail(path, MustBe(problem, NumberText(value)));
  return value;
}

LookSide ReadSide(const Hdf5Values& file, const std::string& path) {
  const std::string given = file.Text(path);
  std::string text = given;
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (text != "left" && text != "right") {
    file.Fail(path, "must be left or right, got " + Quoted(given));
  }
  return text == "left" ? LookSide::kLeft : LookSide::kRight;
}

void RequireSize(const Hdf5Values& file,
                 const std::string& path,
                 const Hdf5Array& array,
                 const std::vector<std::size_t>& size) {
  if (array.size == size) return;
  const auto text = [](const std::vector<std::size_t>& lengths) {
    std::string list;
    for (const std::size_t length : lengths) {
      list += (list.empty() ? "" : " x ") + std::to_string(length);
    }
    return list;
  };
  file.Fail(path, "is " + text(array.size) + ", " + text(size) + " is needed");
}

void ReadOrbit(const Hdf5Values& file, const std::string& path, NisarProduct* product) {
  const Times times = ReadTimes(file, path + "/time", kMaxStates);
  const std::vector<std::size_t> size{times.seconds_s.size(), 3};
  const Hdf5Array positions = file.Numbers(path + "/position", 2, 3 * kMaxStates);
  const Hdf5Array velocities = file.Numbers(path + "/velocity", 2, 3 * kMaxStates);
  RequireSize(file, path + "/position", positions, size);
  RequireSize(file, path + "/velocity", velocities, size);
  if (size[0] < 2) file.Fail(path + "/time", "has one state, a path needs two or more");
  for (std::size_t i = 0; i < size[0]; ++i) {
    const OrbitState state{times.At(i),
                           Eigen::Vector3d::Map(positions.values.data() + 3 * i),
                           Eigen::Vector3d::Map(velocities.values.data() + 3 * i)};
    const auto problem =
        ProblemOfState(product->orbit.empty() ? nullptr : &product->orbit.back(), state);
    if (problem) file.Fail(fmt::format("{}: state {}", path, i + 1), *problem);
    product->orbit.push_back(state);
  }
  if (file.Has(path + "/orbitType")) product->orbit_type = file.Text(path + "/orbitType");
}

void ReadSwath(const Hdf5Values& file, const std::string& swaths, NisarProduct* product) {
  const std::string frequency = swaths + "/" + product->frequency;
  const std::string lines = swaths + "/zeroDopplerTime", ranges = frequency + "/slantRange";
  if (!file.Has(frequency)) file.Fail(frequency, "is missing; --frequency takes the other one");
  const Times times = ReadTimes(file, lines, kMaxLines);
  const Axis time_s = EvenAxis(file, lines, times.seconds_s);
  product->lines = times.seconds_s.size();
  product->first_line = AddSeconds(times.epoch, time_s.first);
  product->last_line = times.At(product->lines - 1);
  product->line_interval_s = time_s.step;
  const std::vector<double> ranges_m = file.Numbers(ranges, 1, kMaxLines).values;
  const Axis range_m = EvenAxis(file, ranges, ranges_m);
  if (!(range_m.first > 0.0) || ranges_m.back() > kLargestNumber) {
    file.Fail(ranges, NumberText(range_m.first) + " m is no slant range");
  }
  product->samples = ranges_m.size();
  product->near_range_m = range_m.first;
  product->range_spacing_m = range_m.step;
  product->wavelength_m =
      kSpeedOfLight_mps / Positive(file, frequency + "/processedCenterFrequency");
}

void ReadGrid(const Hdf5Values& file, const std::string& path, NisarGrid* grid) {
  if (!file.Has(path)) return;
  constexpr double kGeographic = 4326.0;
  if (file.Number(path + "/epsg") != kGeographic) {
    file.Fail(path + "/epsg", "must be 4326 (longitude and latitude of WGS84)");
  }
  const Times times = ReadTimes(file, path + "/zeroDopplerTime", kMaxGridPoints);
  for (std::size_t i = 0; i < times.seconds_s.size(); ++i) grid->time.push_back(times.At(i));
  grid->height_m = file.Numbers(path + "/heightAboveEllipsoid", 1, kMaxGridPoints).values;
  grid->slant_range_m = file.Numbers(path + "/slantRange", 1, kMaxGridPoints).values;
  for (const double range_m : grid->slant_range_m) {
    if (!(range_m > 0.0) || range_m > kLargestNumber) {
      file.Fail(path + "/slantRange", NumberText(range_m) + " m is no slant range");
    }
  }
  constexpr double kHighest_m = 20e3;
  for (const double height_m : grid->height_m) {
    if (std::abs(height_m) > kHighest_m) {
      file.Fail(path + "/heightAboveEllipsoid",
                NumberText(height_m) + " is not between -20 and 20 km");
    }
  }
  const std::vector<std::size_t> size{
      grid->height_m.size(), grid->time.size(), grid->slant_range_m.size()};
  const auto read = [&](const char* name, double most_deg, std::vector<double>* into) {
    const std::string dataset = path + "/" + name;
    Hdf5Array array = file.Numbers(dataset, 3, kMaxGridPoints);
    RequireSize(file, dataset, array, size);
    for (const double value_deg : array.values) {
      if (std::abs(value_deg) > most_deg) {
        file.Fail(
            dataset,
            fmt::format(
                "{} is not between -{} and {} degrees", NumberText(value_deg), most_deg, most_deg));
      }
    }
    *into = std::move(array.values);
  };
  read("coordinateX", 360.0, &grid->longitude_deg);
  read("coordinateY", 90.0, &grid->latitude_deg);
}

}  // namespace

NisarProduct ReadNisar(const std::string& name, NisarFrequency frequency, PartUse grid) {
  const Hdf5Values file(name);
  const Root root = FindRoot(file);
  NisarProduct product;
  product.file = name;
  product.band = root.band;
  product.frequency = frequency == NisarFrequency::kA ? "frequencyA" : "frequencyB";
  product.side = ReadSide(file, "/science/" + root.band + "/identification/lookDirection");
  ReadSwath(file, root.path + "/swaths", &product);
  ReadOrbit(file, root.path + "/metadata/orbit", &product);
  try {
    ReadGrid(file, root.path + "/metadata/geolocationGrid", &product.grid);
  } catch (const InputError& error) {
    if (grid == PartUse::kUsed) throw;
    product.grid = {};
    product.warnings.push_back(std::string("the geolocation grid is left out: ") + error.what());
  }
  return product;
}

namespace {

// S1A of an annotation and Sentinel-1A of an orbit file name the same satellite.
bool SameMission(const std::string& product, const std::string& orbit) {
  return !product.empty() && !orbit.empty() &&
         (product == orbit || (orbit.starts_with("Sentinel-") && product == "S" + orbit.substr(9)));
}

/// Times of the product's image and grid, from its epoch.
struct Span {
  double start_s = 0.0, end_s = 0.0;
  void Include(double time_s) {
    start_s = std::min(start_s, time_s);
    end_s = std::max(end_s, time_s);
  }
};
Span SpanOf(const Sentinel1Product& product, const UtcTime& epoch) {
  Span span{SecondsBetween(epoch, product.first_line), SecondsBetween(epoch, product.last_line)};
  for (const GeolocationGridPoint& point : product.grid) {
    span.Include(SecondsBetween(epoch, point.time));
  }
  return span;
}

// Names states of an orbit file, from index `begin` to `end`, that it does not call nominal.
void WarnOfQuality(const OrbitFile& orbit,
                   std::size_t begin,
                   std::size_t end,
                   std::vector<std::string>* warnings) {
  std::size_t count = 0, first = 0;
  for (std::size_t k = begin; k < end; ++k) {
    if (orbit.quality[k].empty() || orbit.quality[k] == "NOMINAL") continue;
    if (count++ == 0) first = k;
  }
  if (count == 0) return;
  warnings->push_back(
      fmt::format("{}: {} of the {} states that are used are not NOMINAL, the first, {} at {}",
                  orbit.file,
                  count,
                  end - begin,
                  Quoted(orbit.quality[first]),
                  UtcText(orbit.states[first].time)));
}

/// What is taken of an orbit file.
struct TakenOrbit {
  std::string file;
  std::vector<StateVector> states;
};

}  // namespace

bool Covers(const OrbitFile& orbit, const Sentinel1Product& product) {
  if (!SameMission(product.mission, orbit.mission)) return false;
  const Span span = SpanOf(product, product.first_line);
  return SecondsBetween(product.first_line, orbit.states.front().time) <= span.start_s &&
         SecondsBetween(product.first_line, orbit.states.back().time) >= span.end_s;
}

namespace {

// The first orbit file of the mission that covers the product, with margin as far as it goes.
TakenOrbit OrbitOfFiles(const std::vector<OrbitFile>& orbits,
                        const Sentinel1Product& product,
                        const UtcTime& epoch,
                        double margin_s,
                        std::vector<std::string>* warnings) {
  const Span span = SpanOf(product, epoch);
  for (const OrbitFile& orbit : orbits) {
    if (!Covers(orbit, product)) continue;
    std::vector<StateVector> states = StatesFrom(orbit.states, epoch);
    const auto from = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s >= span.start_s - margin_s;
    });
    const auto to = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s > span.end_s + margin_s;
    });
    // One state more on both sides: the span with its margin then lies inside the path.
    const auto begin = from == states.begin() ? from : from - 1;
    const auto end = to == states.end() ? to : to + 1;
    WarnOfQuality(orbit,
                  static_cast<std::size_t>(begin - states.begin()),
                  static_cast<std::size_t>(end - states.begin()),
                  warnings);
    return {orbit.file, {begin, end}};
  }
  std::string files;
  for (const OrbitFile& orbit : orbits) {
    files += fmt::format("{}{} ({}, {} to {})",
                         files.empty() ? "" : "; ",
                         orbit.file,
                         orbit.mission,
                         UtcText(orbit.states.front().time),
                         UtcText(orbit.states.back().time));
  }
  throw InputError(FilePlace{product.file, 0, "orbit"},
                   fmt::format("no orbit file covers this product ({}, {} to {}); given: {}",
                               product.mission,
                               UtcText(product.first_line),
                               UtcText(product.last_line),
                               files));
}

namespace {

/// All but presentation and bursts.
template <typename Product>
ImageGrid GridOf(const Product& product, const UtcTime& epoch) {
  ImageGrid image;
  image.first_line_s = SecondsBetween(epoch, product.first_line);
  image.line_interval_s = product.line_interval_s;
  image.near_range_m = product.near_range_m;
  image.range_spacing_m = product.range_spacing_m;
  for (const ProductGroundRange& polynomial : product.ground_range) {
    image.ground_range.push_back(
        {SecondsBetween(epoch, polynomial.time), polynomial.origin_m, polynomial.coefficients});
  }
  return image;
}

}  // namespace

ImageGrid ImageOf(const Sentinel1Product& product, const UtcTime& epoch) {
  ImageGrid image = GridOf(product, epoch);
  image.presentation = product.presentation;
  for (const UtcTime& burst : product.bursts) {
    image.burst_start_s.push_back(SecondsBetween(epoch, burst));
  }
  image.lines_per_burst = static_cast<std::size_t>(product.lines_per_burst);
  return image;
}

ImageGrid ImageOf(const ZeroDopplerImage& product, const UtcTime& epoch) {
  ImageGrid image = GridOf(product, epoch);
  if (!product.ground_range.empty()) image.presentation = Presentation::kGround;
  return image;
}

ImageGrid ImageOf(const RadarImage& image, RangePolynomialTimes reading, double epoch_s) {
  ImageGrid grid;
  grid.presentation = Presentation::kGround;
  grid.first_line_s = image.first_line_s - epoch_s;
  grid.line_interval_s = image.line_interval_s;
  grid.near_range_m = image.first_sample_m;
  grid.range_spacing_m = image.sample_spacing_m;
  grid.ground_range = image.ground_range;
  if (reading == RangePolynomialTimes::kUsgscsm) {
    grid.ground_range =
        AsUsgscsmReads(image.ground_range, image.states.front().time_s, image.states.back().time_s);
  }
  for (GroundRangePolynomial& polynomial : grid.ground_range) polynomial.time_s -= epoch_s;
  return grid;
}

}  // namespace

namespace {

/// The largest distance between raster and grid along one axis, in pixels.
struct RasterMisfit {
  double off_px = 0.0;
  std::size_t point = 0, beyond = 0;  ///< where it is, and how many points are beyond one pixel

  void Add(double value_px, std::size_t i) {
    if (std::abs(value_px) > 1.0) ++beyond;
    if (!(std::abs(value_px) > std::abs(off_px))) return;
    off_px = value_px;
    point = i;
  }
};

[[noreturn]] void FailRaster(const Sentinel1Product& product,
                             const RasterMisfit& misfit,
                             const std::string& off,
                             const char* cause) {
  const GeolocationGridPoint& point = product.grid[misfit.point];
  throw InputError(
      FilePlace{product.file, point.file_line, "geolocationGridPoint"},
      fmt::format("the raster of the image contradicts this point: at line {}, pixel {} it is {} "
                  "from it, 1 is allowed ({} of {} points are beyond): {}",
                  point.line,
                  point.pixel,
                  off,
                  misfit.beyond,
                  product.grid.size(),
                  cause));
}

}  // namespace

void RequireRasterOfGrid(const Sentinel1Product& product, const std::vector<bool>& trusted) {
  const ImageGrid raster = ImageOf(product, product.first_line);
  RasterMisfit lines, samples;
  double range_m = 0.0;  // at the worst sample
  for (std::size_t i = 0; i < product.grid.size(); ++i) {
    if (!trusted[i]) continue;
    const GeolocationGridPoint& point = product.grid[i];
    const auto at =
        RadarFromImage(raster, {static_cast<double>(point.line), static_cast<double>(point.pixel)});
    if (!at) continue;
    const double time_s = at->time_s - SecondsBetween(product.first_line, point.time);
    lines.Add(time_s / raster.line_interval_s, i);
    const auto sample_m = SlantRangePerPixel_m(raster, *at);
    if (!sample_m) continue;
    samples.Add((at->range_m - point.slant_range_m) / *sample_m, i);
    if (samples.point == i) range_m = at->range_m - point.slant_range_m;
  }
  if (lines.beyond > 0) {
    FailRaster(product,
               lines,
               fmt::format("{} lines ({} s)",
                           Digits(lines.off_px, 4),
                           Digits(lines.off_px * raster.line_interval_s, 4)),
               "productFirstLineUtcTime, azimuthTimeInterval or the azimuthTime of a burst is "
               "wrong, or the grid");
  }
  if (samples.beyond > 0) {
    FailRaster(product,
               samples,
               fmt::format("{} samples ({} m)", Digits(samples.off_px, 4), Digits(range_m, 4)),
               raster.presentation == Presentation::kSlant
                   ? "slantRangeTime or rangeSamplingRate of the image is wrong, or the grid"
                   : "rangePixelSpacing or grsrCoefficients of the image are wrong, or the grid");
  }
}

ImagePass PassOfSentinel1(const Sentinel1Product& product,
                          const std::vector<OrbitFile>& orbits,
                          const ImportOptions& options,
                          std::vector<std::string>* warnings) {
  ImagePass image{.file = product.file, .ellipsoid = NamedEllipsoid("WGS84")};
  Pass& pass = image.pass;
  pass.id = product.mission + "_" + product.swath + "_" + product.polarisation + "_" +
            CompactTime(product.first_line);
  image.first_line = product.first_line;
  const UtcTime epoch = SetEpoch(product.first_line, &pass);
  pass.wavelength_m = product.wavelength_m;
  // The processor takes nothing off for the atmosphere.
  if (options.reduce) pass.reduction.troposphere = TroposphereModel::kStandard;
  const Span span = SpanOf(product, epoch);
  const TakenOrbit orbit =
      orbits.empty() ? TakenOrbit{"", StatesFrom(product.orbit, epoch)}
                     : OrbitOfFiles(orbits, product, epoch, options.orbit_margin_s, warnings);
  if (orbit.states.empty()) {
    throw InputError(FilePlace{product.file, 0, "orbit"},
                     "the annotated one is not used, and no orbit file covers this product");
  }
  image.orbit_file = orbit.file;
  image.lines = product.lines;
  image.samples = product.samples;
  image.valid_samples = product.valid_samples;
  image.counting = "; merged, debursted or cut images count lines and samples otherwise";
  warnings->insert(warnings->end(), product.warnings.begin(), product.warnings.end());
  pass.path = PathThroughOrbit(orbit.file.empty() ? product.file : orbit.file,
                               orbit.states,
                               {span.start_s, span.end_s},
                               options.orbit_step_s,
                               options.through.value_or(OrbitThrough::kStates),
                               warnings);
  pass.image = ImageOf(product, epoch);
  CheckImageGrid(*pass.image);
  image.span_s = {span.start_s, span.end_s};
  const GeolocationGridPoint& middle = product.grid[product.grid.size() / 2];
  image.middle = {SecondsBetween(epoch, middle.time), middle.slant_range_m};
  return image;
}

Sentinel1Timing TimingOfSentinel1(const Sentinel1Product& product,
                                  const Pass& pass,
                                  const std::vector<double>& heights_m) {
  const UtcTime epoch = WholeSecond(product.first_line);
  std::vector<Sentinel1GridPlace> grid;
  for (std::size_t i = 0; i < product.grid.size(); ++i) {
    const GeolocationGridPoint& point = product.grid[i];
    grid.push_back({{static_cast<double>(point.line), static_cast<double>(point.pixel)},
                    {SecondsBetween(epoch, point.time), point.slant_range_m},
                    heights_m[i]});
  }
  return {product.radar, product.swath, product.samples, pass, epoch, grid};
}

ImagePass PassOfZeroDopplerImage(const ZeroDopplerImage& product,
                                 std::string id,
                                 const char* orbit_place,
                                 OrbitThrough through,
                                 const ImportOptions& options,
                                 std::vector<std::string>* warnings) {
  ImagePass image{.file = product.file, .ellipsoid = NamedEllipsoid("WGS84")};
  image.lines = product.lines;
  image.samples = product.samples;
  Pass& pass = image.pass;
  pass.id = std::move(id);
  image.first_line = product.first_line;
  const UtcTime epoch = SetEpoch(product.first_line, &pass);
  pass.side = product.side;
  pass.wavelength_m = product.wavelength_m;
  const Span span{SecondsBetween(epoch, product.first_line),
                  SecondsBetween(epoch, product.last_line)};
  pass.path = PathThroughOrbit(product.file,
                               StatesFrom(product.orbit, epoch),
                               {span.start_s, span.end_s},
                               options.orbit_step_s,
                               through,
                               warnings);
  pass.image = ImageOf(product, epoch);
  if (!pass.path.At(span.start_s) || !pass.path.At(span.end_s)) {
    throw InputError(FilePlace{product.file, 0, orbit_place},
                     fmt::format("covers {:.3f} to {:.3f} s after {}, the image {:.3f} to {:.3f} s",
                                 pass.path.start_s(),
                                 pass.path.end_s(),
                                 UtcText(epoch),
                                 span.start_s,
                                 span.end_s));
  }
  CheckImageGrid(*pass.image);
  image.middle = RadarFromImage(*pass.image,
                                {0.5 * static_cast<double>(product.lines - 1),
                                 0.5 * static_cast<double>(product.samples - 1)});
  image.span_s = {span.start_s, span.end_s};
  return image;
}

ImagePass PassOfNisar(const NisarProduct& product,
                      const ImportOptions& options,
                      std::vector<std::string>* warnings) {
  warnings->insert(warnings->end(), product.warnings.begin(), product.warnings.end());
  ImagePass image =
      PassOfZeroDopplerImage(product,
                             "NISAR_" + product.band + "_" + product.frequency.back() + "_" +
                                 CompactTime(product.first_line),
                             "metadata/orbit/time",
                             options.through.value_or(OrbitThrough::kStates),
                             options,
                             warnings);
  if (options.grid) {
    Span span{(*image.span_s)[0], (*image.span_s)[1]};
    const UtcTime epoch = WholeSecond(product.first_line);
    for (const UtcTime& time : product.grid.time) span.Include(SecondsBetween(epoch, time));
    image.span_s = {span.start_s, span.end_s};
  }
  return image;
}

ImagePass PassOfRadarImage(const RadarImage& given, RangePolynomialTimes range_polynomial) {
  ImagePass image{.file = given.file, .ellipsoid = given.ellipsoid};
  Pass& pass = image.pass;
  pass.id = std::filesystem::path(given.file).stem().string();
  image.first_line = UtcOfEphemerisTime(given.first_line_s);
  const UtcTime epoch = SetEpoch(image.first_line, &pass);
  const double epoch_s = EphemerisTime_s(epoch);
  pass.side = given.side;
  pass.wavelength_m = given.wavelength_m;
  std::vector<StateVector> states = given.states;
  for (StateVector& state : states) state.time_s -= epoch_s;
  if (const auto close = FindCloseStates(states)) {
    throw InputError(
        FilePlace{given.file, 0, ""},
        fmt::format("states {} and {} are {}", close->second, close->second + 1, Describe(*close)));
  }
  try {
    pass.image = ImageOf(given, range_polynomial, epoch_s);
    pass.path = FlightPath(std::move(states));
    CheckImageGrid(*pass.image);
  } catch (const InputError& error) {
    throw InputError(FilePlace{given.file, 0, ""}, error.what());
  }
  image.lines = given.lines;
  image.samples = given.samples;
  image.middle = RadarFromImage(
      *pass.image,
      {0.5 * static_cast<double>(given.lines - 1), 0.5 * static_cast<double>(given.samples - 1)});
  return image;
}

}  // namespace sarblock
