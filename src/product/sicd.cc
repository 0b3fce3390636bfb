// SPDX-License-Identifier: Apache-2.0
#include "product/sicd.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>

#include "byte_source.h"
#include "nitf_text.h"
#include "sicd_error_reader.h"
#include "xml_reader.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kLargestLength_m = 1e9;
constexpr double kLongestTime_s = 1e6;

double Bounded(const XmlElement& element, double most) {
  const double value = element.Number();
  if (!(std::abs(value) <= most)) element.Fail(fmt::format("is not between -{0} and {0}", most));
  return value;
}

// Coefficients of x^exponent1, in any order; those that are left out are 0.
constexpr int kHighestDegree = 64;
constexpr double kLargestCoefficient = 1e30;

SicdPolynomial ReadPolynomial(const XmlElement& element) {
  SicdPolynomial polynomial;
  for (const XmlElement& coefficient : element.Children("Coef")) {
    const int exponent = coefficient.Attribute("exponent1", kHighestDegree);
    const auto k = static_cast<std::size_t>(exponent);
    if (polynomial.size() <= k) polynomial.resize(k + 1, 0.0);
    polynomial[k] = Bounded(coefficient, kLargestCoefficient);
  }
  if (polynomial.empty()) element.Fail("has no coefficient");
  return polynomial;
}

// Version 0.4 writes some of x alone, without exponent2.
SicdPolynomial2 ReadPolynomial2(const XmlElement& element) {
  SicdPolynomial2 polynomial;
  for (const XmlElement& coefficient : element.Children("Coef")) {
    const auto j = static_cast<std::size_t>(coefficient.Attribute("exponent1", kHighestDegree));
    const bool of_y = coefficient.Has("exponent2");
    const auto k =
        static_cast<std::size_t>(of_y ? coefficient.Attribute("exponent2", kHighestDegree) : 0);
    if (polynomial.size() <= j) polynomial.resize(j + 1);
    if (polynomial[j].size() <= k) polynomial[j].resize(k + 1, 0.0);
    polynomial[j][k] = Bounded(coefficient, kLargestCoefficient);
  }
  if (polynomial.empty()) element.Fail("has no coefficient");
  return polynomial;
}

Eigen::Vector3d ReadVector(const XmlElement& element) {
  return {Bounded(element.Child("X"), kLargestLength_m),
          Bounded(element.Child("Y"), kLargestLength_m),
          Bounded(element.Child("Z"), kLargestLength_m)};
}

using SicdPath = std::array<SicdPolynomial, 3>;
SicdPath ReadPath(const XmlElement& element) {
  return {ReadPolynomial(element.Child("X")),
          ReadPolynomial(element.Child("Y")),
          ReadPolynomial(element.Child("Z"))};
}

std::size_t AtLeastTwo(const XmlElement& element) {
  const int count = element.Count();
  if (count < 2) element.Fail("is below 2");
  return static_cast<std::size_t>(count);
}

Eigen::Vector3d ReadUnitVector(const XmlElement& element) {
  constexpr double kRounding = 1e-6;
  const Eigen::Vector3d vector = ReadVector(element);
  if (!(std::abs(vector.norm() - 1.0) <= kRounding)) element.Fail("is no vector of length 1");
  return vector;
}

SicdKind KindOf(const XmlElement& root) {
  const XmlElement type = root.Child("Grid").Child("Type");
  const std::string name = type.Text();
  if (name == "PLANE" || name == "XRGYCR" || name == "XCTYAT") return SicdKind::kPlane;
  if (name == "RGAZIM") {
    const XmlElement algorithm = root.Child("ImageFormation").Child("ImageFormAlgo");
    if (algorithm.Text() == "PFA") return SicdKind::kPolarFormat;
    if (algorithm.Text() == "RGAZCOMP") return SicdKind::kAzimuthCompression;
    algorithm.Fail("'" + algorithm.Text() +
                   "' is not read with the grid type RGAZIM, PFA and RGAZCOMP are");
  }
  const auto rma = root.Find("RMA");
  if (name != "RGZERO" || !rma || !rma->Find("INCA")) {
    type.Fail("'" + name +
              "' is not read: RGZERO of an RMA/INCA image is, RGAZIM of PFA and RGAZCOMP, PLANE, "
              "XRGYCR and XCTYAT");
  }
  return SicdKind::kInca;
}

// Only the ratio of Doppler and frequency counts: the middle of the band is as good as any.
double Wavelength_m(const XmlElement& root) {
  const XmlElement band = root.Child("ImageFormation").Child("TxFrequencyProc");
  return 2.0 * kSpeedOfLight_mps /
         (band.Child("MinProc").Positive() + band.Child("MaxProc").Positive());
}

// What tells the kinds apart.
void ReadKind(const XmlElement& root, SicdImage* image) {
  image->kind = KindOf(root);
  const XmlElement grid = root.Child("Grid");
  if (image->kind == SicdKind::kInca) {
    const XmlElement inca = root.Child("RMA").Child("INCA");
    image->wavelength_m = kSpeedOfLight_mps / inca.Child("FreqZero").Positive();
    image->closest_time_s = ReadPolynomial(inca.Child("TimeCAPoly"));
    image->closest_range_m = inca.Child("R_CA_SCP").Positive();
    const auto time = grid.Find("TimeCOAPoly"), scale = inca.Find("DRateSFPoly");
    if (time) image->aperture_time_s = ReadPolynomial2(*time);
    if (scale) image->rate_scale_1 = ReadPolynomial2(*scale);
    return;
  }
  image->wavelength_m = Wavelength_m(root);
  image->aperture_time_s = ReadPolynomial2(grid.Child("TimeCOAPoly"));
  if (image->kind == SicdKind::kPolarFormat) {
    const XmlElement pfa = root.Child("PFA");
    image->polar_angle_rad = ReadPolynomial(pfa.Child("PolarAngPoly"));
    image->frequency_scale_1 = ReadPolynomial(pfa.Child("SpatialFreqSFPoly"));
  } else if (image->kind == SicdKind::kAzimuthCompression) {
    image->cone_cosine_per_m = Bounded(root.Child("RgAzComp").Child("AzSF"), 1.0);
  } else {
    image->axes_1 = {ReadUnitVector(grid.Child("Row").Child("UVectECF")),
                     ReadUnitVector(grid.Child("Col").Child("UVectECF"))};
  }
}

// Transmitter and receiver of a monostatic image may stand a little apart on one platform: what
// counts is that half the way by both is the range of ARPPoly.
void RequireOneAntenna(const XmlElement& position, const SicdImage& image) {
  const auto transmitter = position.Find("TxAPCPoly"), receivers = position.Find("RcvAPC");
  if (!transmitter || !receivers) return;
  const auto range_m = [&image](const SicdPath& path, double time_s) {
    Eigen::Vector3d place_m;
    for (Eigen::Index k = 0; k < 3; ++k) {
      place_m[k] = ValueOf(path[static_cast<std::size_t>(k)], time_s);
    }
    return (place_m - image.centre_m).norm();
  };
  const SicdPath transmits = ReadPath(*transmitter);
  for (const XmlElement& receiver : receivers->Children("RcvAPCPoly")) {
    const SicdPath receives = ReadPath(receiver);
    double largest_m = 0.0;
    for (const double part : {0.0, 0.5, 1.0}) {
      const double time_s = part * image.duration_s;
      const double both_m = 0.5 * (range_m(transmits, time_s) + range_m(receives, time_s));
      largest_m = std::max(largest_m, std::abs(both_m - range_m(image.path_m, time_s)));
    }
    constexpr double kMost_m = 0.01;
    if (largest_m <= kMost_m) continue;
    receiver.Fail(fmt::format(
        "with TxAPCPoly makes ranges that differ by {:.3g} m from those of ARPPoly: the "
        "transmitter and the receiver of a bistatic image are not read, one antenna "
        "for both is",
        largest_m));
  }
}

std::optional<SicdOffsets> ReadOffsets(const XmlElement& root) {
  const auto statistics = root.Find("ErrorStatistics");
  const auto given = statistics ? statistics->Find("AdjustableParameterOffsets") : std::nullopt;
  if (!given) return std::nullopt;
  constexpr double kLongest_s = 1.0;
  SicdOffsets offsets;
  offsets.position_m = ReadVector(given->Child("ARPPosSCPCOA"));
  offsets.velocity_mps = ReadVector(given->Child("ARPVel"));
  offsets.range_m = 0.5 * kSpeedOfLight_mps *
                    (Bounded(given->Child("RcvTimeSCPCOA"), kLongest_s) -
                     Bounded(given->Child("TxTimeSCPCOA"), kLongest_s));
  return offsets;
}

// Corners of the image as the file places them, in the order of their indices.
std::optional<std::array<Geodetic, 4>> ReadCorners(const XmlElement& geo, double height_m) {
  const auto given = geo.Find("ImageCorners");
  if (!given) return std::nullopt;
  const std::vector<XmlElement> corners = given->Children("ICP");
  if (corners.size() != 4) return std::nullopt;
  std::array<Geodetic, 4> places;
  std::array<bool, 4> found{};
  for (const XmlElement& corner : corners) {
    const std::string index = corner.AttributeText("index");
    const std::array<const char*, 4> names{"1:FRFC", "2:FRLC", "3:LRLC", "4:LRFC"};
    const auto name = std::find(names.begin(), names.end(), index);
    if (name == names.end()) return std::nullopt;
    const auto k = static_cast<std::size_t>(name - names.begin());
    places[k] = {Bounded(corner.Child("Lat"), 90.0) * kRadPerDeg,
                 Bounded(corner.Child("Lon"), 360.0) * kRadPerDeg,
                 height_m};
    found[k] = true;
  }
  if (std::count(found.begin(), found.end(), true) != 4) return std::nullopt;
  return places;
}

// What is refused after reading.
void KeepLines(const XmlElement& root, SicdImage* image) {
  const auto keep = [image](const std::optional<XmlElement>& element) {
    if (element) image->element_lines.emplace_back(element->Path(), element->line());
  };
  keep(root.Find("Grid"));
  keep(root.Child("Grid").Find("TimeCOAPoly"));
  keep(root.Child("Timeline").Find("CollectDuration"));
  keep(root.Child("Position").Find("ARPPoly"));
  keep(root.Child("GeoData").Find("ImageCorners"));
  const auto rma = root.Find("RMA");
  const auto inca = rma ? rma->Find("INCA") : std::nullopt;
  if (inca) keep(inca->Find("TimeCAPoly"));
}

SicdImage ReadSicdText(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "SICD");
  const XmlElement root = xml.Root();
  const XmlElement type = root.Child("CollectionInfo").Child("CollectType");
  if (type.Text() != "MONOSTATIC") type.Fail("'" + type.Text() + "' is not read, MONOSTATIC is");
  const XmlElement data = root.Child("ImageData"), grid = root.Child("Grid");
  const XmlElement timeline = root.Child("Timeline");
  SicdImage image;
  image.file = file;
  ReadKind(root, &image);
  image.core_name = root.Child("CollectionInfo").Child("CoreName").Text();
  image.rows = AtLeastTwo(data.Child("NumRows"));
  image.columns = AtLeastTwo(data.Child("NumCols"));
  image.first_row_px = data.Child("FirstRow").Count();
  image.first_column_px = data.Child("FirstCol").Count();
  image.centre_row_px = data.Child("SCPPixel").Child("Row").Count();
  image.centre_column_px = data.Child("SCPPixel").Child("Col").Count();
  image.row_spacing_m = grid.Child("Row").Child("SS").Positive();
  image.column_spacing_m = grid.Child("Col").Child("SS").Positive();
  image.centre_m = ReadVector(root.Child("GeoData").Child("SCP").Child("ECF"));
  image.start = timeline.Child("CollectStart").Time();
  image.duration_s = timeline.Child("CollectDuration").Positive();
  image.path_m = ReadPath(root.Child("Position").Child("ARPPoly"));
  RequireOneAntenna(root.Child("Position"), image);
  image.offsets = ReadOffsets(root);
  const XmlElement aperture = root.Child("SCPCOA");
  if (image.offsets || aperture.Find("SCPTime")) {
    image.centre_time_s = Bounded(aperture.Child("SCPTime"), kLongestTime_s);
  }
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  image.corners = ReadCorners(root.Child("GeoData"), earth.GeodeticFromFrame(image.centre_m).h_m);
  KeepLines(root, &image);
  const XmlElement side = root.Child("SCPCOA").Child("SideOfTrack");
  const std::string letter = side.Text();
  if (letter != "L" && letter != "R") side.Fail("'" + letter + "' is not allowed, L or R is");
  image.side = letter == "L" ? LookSide::kLeft : LookSide::kRight;
  image.errors = ReadErrorStatistics(root);
  return image;
}

SicdImage ReadSource(ByteSource source) {
  const std::string text = SicdText(&source);
  return ReadSicdText(text, source.file());
}

}  // namespace

double ValueOf(const SicdPolynomial& polynomial, double x) {
  double value = 0.0;
  for (auto c = polynomial.rbegin(); c != polynomial.rend(); ++c) value = value * x + *c;
  return value;
}

double ValueOf(const SicdPolynomial2& polynomial, double x_m, double y_m) {
  double value = 0.0;
  for (auto c = polynomial.rbegin(); c != polynomial.rend(); ++c) {
    value = value * x_m + ValueOf(*c, y_m);
  }
  return value;
}

SicdPolynomial DerivativeOf(const SicdPolynomial& polynomial) {
  SicdPolynomial derivative;
  for (std::size_t k = 1; k < polynomial.size(); ++k) {
    derivative.push_back(static_cast<double>(k) * polynomial[k]);
  }
  return derivative;
}

FilePlace SicdImage::PlaceOf(const char* element) const {
  const auto found = std::find_if(element_lines.begin(),
                                  element_lines.end(),
                                  [&](const auto& line) { return line.first == element; });
  return {file, found == element_lines.end() ? 0 : found->second, element};
}

SicdImage ReadSicd(const std::string& file) { return ReadSource(ByteSource::OfFile(file)); }

SicdImage ParseSicd(std::string_view bytes, const std::string& file) {
  return ReadSource(ByteSource::OfBytes(bytes, file));
}

}  // namespace sarblock
