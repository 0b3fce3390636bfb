// SPDX-License-Identifier: Apache-2.0
#include "sarblock/product/sicd.h"

#include <algorithm>
#include <cmath>

#include "byte_source.h"
#include "core/units.h"
#include "nitf_text.h"
#include "sicd_error_reader.h"
#include "xml_reader.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kLargestLength_m = 1e9;

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
  const XmlElement path = root.Child("Position").Child("ARPPoly");
  for (std::size_t k = 0; k < 3; ++k) {
    const char* const axes[] = {"X", "Y", "Z"};
    image.path_m[k] = ReadPolynomial(path.Child(axes[k]));
  }
  const XmlElement side = root.Child("SCPCOA").Child("SideOfTrack");
  const std::string letter = side.Text();
  if (letter != "L" && letter != "R") side.Fail("'" + letter + "' is not allowed, L or R is");
  image.side = letter == "L" ? LookSide::kLeft : LookSide::kRight;
  image.errors = ReadErrorStatistics(root);
  return image;
}

SicdImage ReadSource(ByteSource source) {
  constexpr std::uint64_t kMagicBytes = 9;
  const std::string magic = source.Read(0, std::min(kMagicBytes, source.size()), "file header");
  if (magic == "NITF02.10" || magic == "NSIF01.00") {
    const std::string text = SicdTextOfNitf(&source);
    return ReadSicdText(text, source.file());
  }
  if (source.size() > kLargestSicdText) {
    throw InputError(FilePlace{source.file(), 0, ""}, "is larger than 64 MiB, which no XML is");
  }
  return ReadSicdText(source.Read(0, source.size(), "text"), source.file());
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

SicdImage ReadSicd(const std::string& file) { return ReadSource(ByteSource::OfFile(file)); }

SicdImage ParseSicd(std::string_view bytes, const std::string& file) {
  return ReadSource(ByteSource::OfBytes(bytes, file));
}

}  // namespace sarblock
