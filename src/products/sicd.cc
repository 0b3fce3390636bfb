// SPDX-License-Identifier: Apache-2.0
#include "sicd.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "bytes.h"
#include "image.h"
#include "xml.h"
#include <Eigen/Dense>
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

std::size_t CountAboveOne(const XmlElement& element) {
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

// What distinguishes the kinds.
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
    if (scale) image->rate_scale = ReadPolynomial2(*scale);
    return;
  }
  image->wavelength_m = Wavelength_m(root);
  image->aperture_time_s = ReadPolynomial2(grid.Child("TimeCOAPoly"));
  if (image->kind == SicdKind::kPolarFormat) {
    const XmlElement pfa = root.Child("PFA");
    image->polar_angle_rad = ReadPolynomial(pfa.Child("PolarAngPoly"));
    image->frequency_scale = ReadPolynomial(pfa.Child("SpatialFreqSFPoly"));
  } else if (image->kind == SicdKind::kAzimuthCompression) {
    image->cone_cosine_per_m = Bounded(root.Child("RgAzComp").Child("AzSF"), 1.0);
  } else {
    image->axes = {ReadUnitVector(grid.Child("Row").Child("UVectECF")),
                   ReadUnitVector(grid.Child("Col").Child("UVectECF"))};
  }
}

// Transmitter and receiver of a monostatic image may be a little apart on one platform: half the
// way over both must be the range of ARPPoly.
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
    constexpr double kMax_m = 0.01;
    if (largest_m <= kMax_m) continue;
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
  image.rows = CountAboveOne(data.Child("NumRows"));
  image.columns = CountAboveOne(data.Child("NumCols"));
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
  image.side = ReadSide(root.Child("SCPCOA").Child("SideOfTrack"), "L", "R");
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

SicdImage ReadSicd(const std::string& file) { return ReadSource(ByteSource::FromFile(file)); }

SicdImage ParseSicd(std::string_view bytes, const std::string& file) {
  return ReadSource(ByteSource::FromBytes(bytes, file));
}

namespace {

constexpr std::array<const char*, 6> kComponents = {"P1", "P2", "P3", "V1", "V2", "V3"};
constexpr double kLargestSigma = 1e9;

double Sigma(const XmlElement& element) {
  const double sigma = element.Number();
  if (!(sigma >= 0.0 && sigma <= kLargestSigma)) {
    element.Fail(
        fmt::format("must be a standard deviation from 0 to {1}, got {0}", sigma, kLargestSigma));
  }
  return sigma;
}

// A standard deviation of looks, which must be above 0.
double PositiveSigma(const XmlElement& parent, const char* name) {
  const XmlElement element = parent.Child(name);
  const double sigma = Sigma(element);
  if (!(sigma > 0.0)) element.Fail("is 0, a standard deviation of looks above 0 is allowed");
  return sigma;
}

SicdErrorStatistics::PositionAndVelocity ReadPosVelErr(const XmlElement& element) {
  using Axes = SicdErrorStatistics::Axes;
  SicdErrorStatistics::PositionAndVelocity out;
  const XmlElement frame = element.Child("Frame");
  const std::string name = frame.Text();
  if (name == "ECF") {
    out.axes = Axes::kEcf;
  } else if (name == "RIC_ECF") {
    out.axes = Axes::kRicEcf;
  } else if (name == "RIC_ECI") {
    out.axes = Axes::kRicEci;
  } else {
    frame.Fail("must be ECF, RIC_ECF or RIC_ECI, got '" + name + "'");
  }
  for (std::size_t i = 0; i < 6; ++i) out.sigma[i] = Sigma(element.Child(kComponents[i]));
  const auto coefficients = element.Find("CorrCoefs");
  if (!coefficients) return out;
  out.correlated = true;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i + 1; j < 6; ++j) {
      const std::string pair = std::string(kComponents[i]) + kComponents[j];
      const XmlElement coefficient = coefficients->Child(pair.c_str());
      const double r = coefficient.Number();
      if (!(std::abs(r) <= 1.0)) coefficient.Fail("is no correlation, -1 to 1 is allowed");
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      out.correlation(a, b) = out.correlation(b, a) = r;
    }
  }
  return out;
}

// Notes the children of an element that are not used.
void Note(const XmlElement& element,
          const std::string& path,
          std::initializer_list<const char*> names,
          std::vector<std::string>* not_used) {
  for (const char* name : names) {
    if (element.Find(name)) not_used->push_back(path + name);
  }
}

}  // namespace

std::optional<SicdErrorStatistics> ReadErrorStatistics(const XmlElement& root) {
  const auto element = root.Find("ErrorStatistics");
  if (!element) return std::nullopt;
  SicdErrorStatistics out;
  Note(*element,
       "",
       {"CompositeSCP",
        "BistaticCompositeSCP",
        "BistaticComponents",
        "BistaticAdjustableParameterOffsets"},
       &out.not_used);
  if (const auto rest = element->Find("Unmodeled")) {
    out.row_sigma_m = PositiveSigma(*rest, "Xrow");
    out.column_sigma_m = PositiveSigma(*rest, "Ycol");
    Note(*rest, "Unmodeled.", {"XrowYcol", "UnmodeledDecorr"}, &out.not_used);
  }
  const auto components = element->Find("Components");
  if (!components) return out;
  if (const auto path = components->Find("PosVelErr")) {
    out.path = ReadPosVelErr(*path);
    Note(*path, "PosVelErr.", {"PositionDecorr"}, &out.not_used);
  }
  if (const auto radar = components->Find("RadarSensor")) {
    if (const auto bias = radar->Find("RangeBias")) out.range_bias_m = Sigma(*bias);
    Note(*radar,
         "RadarSensor.",
         {"ClockFreqSF", "TransmitFreqSF", "RangeBiasDecorr"},
         &out.not_used);
  }
  if (const auto air = components->Find("TropoError")) {
    if (const auto vertical = air->Find("TropoRangeVertical")) {
      out.zenith_delay_m = Sigma(*vertical);
    }
    Note(*air, "TropoError.", {"TropoRangeSlant", "TropoRangeDecorr"}, &out.not_used);
  }
  Note(*components, "", {"IonoError"}, &out.not_used);
  return out;
}

namespace {

using RangeAndRate = Eigen::Vector2d;  // [m], [m/s]

// As a moving antenna sees a place at rest.
RangeAndRate Seen(const SicdMotion& antenna, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d from_m = antenna.position_m - p_m;
  const double range_m = from_m.norm();
  return {range_m, antenna.velocity_mps.dot(from_m) / range_m};
}

// The image projections of SICD volume 3 at a time that is given apart.
RangeAndRate IncaRangeAndRate(const SicdImage& image, double x_m, double y_m, double time_s) {
  const double closest_s = ValueOf(image.closest_time_s, y_m);
  const double closest_m = image.closest_range_m + x_m;
  const double speed_mps = MotionOf(image, closest_s).velocity_mps.norm();
  const double rate_m2ps2 = ValueOf(image.rate_scale, x_m, y_m) * speed_mps * speed_mps;
  const double since_s = time_s - closest_s;
  const double range_m = std::sqrt(closest_m * closest_m + rate_m2ps2 * since_s * since_s);
  return {range_m, rate_m2ps2 * since_s / range_m};
}

RangeAndRate PolarFormatRangeAndRate(const SicdImage& image,
                                     double x_m,
                                     double y_m,
                                     double time_s) {
  const double angle_rad = ValueOf(image.polar_angle_rad, time_s);
  const double turn_radps = ValueOf(DerivativeOf(image.polar_angle_rad), time_s);
  const double scale = ValueOf(image.frequency_scale, angle_rad);
  const double scale_rate = ValueOf(DerivativeOf(image.frequency_scale), angle_rad);
  const double along_m = x_m * std::cos(angle_rad) + y_m * std::sin(angle_rad);
  const double across_m = y_m * std::cos(angle_rad) - x_m * std::sin(angle_rad);
  const RangeAndRate centre = Seen(MotionOf(image, time_s), image.centre_m);
  return centre +
         RangeAndRate(scale * along_m, (scale_rate * along_m + scale * across_m) * turn_radps);
}

RangeAndRate AzimuthCompressionRangeAndRate(const SicdImage& image,
                                            double x_m,
                                            double y_m,
                                            double time_s) {
  const SicdMotion antenna = MotionOf(image, time_s);
  return Seen(antenna, image.centre_m) +
         RangeAndRate(x_m, -antenna.velocity_mps.norm() * image.cone_cosine_per_m * y_m);
}

RangeAndRate PlaneRangeAndRate(const SicdImage& image, double x_m, double y_m, double time_s) {
  return Seen(MotionOf(image, time_s), image.centre_m + x_m * image.axes[0] + y_m * image.axes[1]);
}

RangeAndRate Measured(const SicdImage& image, double x_m, double y_m, double time_s) {
  switch (image.kind) {
    case SicdKind::kPolarFormat:
      return PolarFormatRangeAndRate(image, x_m, y_m, time_s);
    case SicdKind::kAzimuthCompression:
      return AzimuthCompressionRangeAndRate(image, x_m, y_m, time_s);
    case SicdKind::kPlane:
      return PlaneRangeAndRate(image, x_m, y_m, time_s);
    case SicdKind::kInca:
      break;
  }
  return IncaRangeAndRate(image, x_m, y_m, time_s);
}

// By central differences over a metre of rows and of columns; the functions are nearly linear.
template <typename Function>
Eigen::Matrix2d Slopes(const Function& function, double x_m, double y_m) {
  constexpr double kHalf_m = 0.5;
  Eigen::Matrix2d slopes;
  slopes.col(0) = function(x_m + kHalf_m, y_m) - function(x_m - kHalf_m, y_m);
  slopes.col(1) = function(x_m, y_m + kHalf_m) - function(x_m, y_m - kHalf_m);
  return slopes;
}

}  // namespace

SicdMotion MotionOf(const SicdImage& image, double time_s) {
  SicdMotion motion;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    motion.position_m[i] = ValueOf(image.path_m[axis], time_s);
    motion.velocity_mps[i] = ValueOf(DerivativeOf(image.path_m[axis]), time_s);
  }
  return motion;
}

SicdMotion AdjustedMotionOf(const SicdImage& image, double time_s) {
  SicdMotion motion = MotionOf(image, time_s);
  if (image.offsets) {
    const SicdOffsets& offsets = *image.offsets;
    motion.position_m += offsets.position_m + offsets.velocity_mps * (time_s - image.centre_time_s);
    motion.velocity_mps += offsets.velocity_mps;
  }
  return motion;
}

std::optional<ApertureLook> LookOfPlace(const SicdImage& image, double row_px, double column_px) {
  const double x_m = image.Row_m(row_px), y_m = image.Azimuth_m(column_px);
  const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
  const RangeAndRate measured =
      Measured(image, x_m, y_m, time_s) + RangeAndRate(image.RangeOffset_m(), 0.0);
  const double speed_mps = MotionOf(image, time_s).velocity_mps.norm();
  const bool possible = std::isfinite(time_s) && std::isfinite(measured[0]) && measured[0] > 0.0 &&
                        std::isfinite(speed_mps) && std::abs(measured[1]) < speed_mps;
  if (!possible) return std::nullopt;
  return ApertureLook{time_s, measured[0], measured[1]};
}

std::optional<ApertureSigma> SigmaOfPlace(const SicdImage& image,
                                          double row_px,
                                          double column_px,
                                          double row_sigma_px,
                                          double column_sigma_px) {
  const double x_m = image.Row_m(row_px), y_m = image.Azimuth_m(column_px);
  const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
  const Eigen::Matrix2d slopes = Slopes(
      [&](double row_m, double column_m) { return Measured(image, row_m, column_m, time_s); },
      x_m,
      y_m);
  const Eigen::Vector2d sigma_m(row_sigma_px * image.row_spacing_m,
                                column_sigma_px * image.column_spacing_m);
  const Eigen::Vector2d sigma = (slopes * sigma_m.asDiagonal()).rowwise().norm();
  if (!sigma.allFinite() || !(sigma.minCoeff() > 0.0)) return std::nullopt;
  return ApertureSigma{sigma[0], sigma[1]};
}

std::optional<ImageCoordinates> PlaceInSicd(const SicdImage& image, const Eigen::Vector3d& p_m) {
  constexpr int kMaxSteps = 30;
  constexpr double kEnd_m = 1e-8, kFarthest_m = 1e7;
  // What the image says of a place less what the antenna sees there at the same time.
  const auto difference = [&](double x_m, double y_m) -> Eigen::Vector2d {
    const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
    return Measured(image, x_m, y_m, time_s) + RangeAndRate(image.RangeOffset_m(), 0.0) -
           Seen(AdjustedMotionOf(image, time_s), p_m);
  };
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Matrix2d slopes = Slopes(difference, place_m.x(), place_m.y());
    const Eigen::Vector2d change_m = -slopes.inverse() * difference(place_m.x(), place_m.y());
    place_m += change_m;
    if (!(place_m.norm() < kFarthest_m)) return std::nullopt;
    if (change_m.norm() > kEnd_m * (1.0 + place_m.norm())) continue;
    return ImageCoordinates{
        place_m.x() / image.row_spacing_m + image.centre_row_px - image.first_row_px,
        place_m.y() / image.column_spacing_m + image.centre_column_px - image.first_column_px};
  }
  return std::nullopt;
}

}  // namespace sarblock
