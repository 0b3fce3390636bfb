// SPDX-License-Identifier: Apache-2.0
#include "sarblock/product/sicd.h"

#include <algorithm>
#include <cmath>

#include "byte_source.h"
#include "core/units.h"
#include "nitf_text.h"
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
SicdPolynomial ReadPolynomial(const XmlElement& element) {
  constexpr int kHighestDegree = 64;
  SicdPolynomial polynomial;
  for (const XmlElement& coefficient : element.Children("Coef")) {
    const int exponent = coefficient.Attribute("exponent1", kHighestDegree);
    const auto k = static_cast<std::size_t>(exponent);
    if (polynomial.size() <= k) polynomial.resize(k + 1, 0.0);
    polynomial[k] = Bounded(coefficient, 1e30);
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

XmlElement Inca(const XmlElement& root) {
  const XmlElement type = root.Child("Grid").Child("Type");
  const auto rma = root.Find("RMA");
  const auto inca = rma ? rma->Find("INCA") : std::nullopt;
  if (!inca || type.Text() != "RGZERO") {
    type.Fail(
        "'" + type.Text() +
        "' is not read: RGZERO of an RMA/INCA image is, in which a row is a range and a column a "
        "zero-Doppler time");
  }
  return *inca;
}

SicdImage ReadSicdText(std::string_view text, const std::string& file) {
  const XmlFile xml(text, file, "SICD");
  const XmlElement root = xml.Root();
  const XmlElement type = root.Child("CollectionInfo").Child("CollectType");
  if (type.Text() != "MONOSTATIC") type.Fail("'" + type.Text() + "' is not read, MONOSTATIC is");
  const XmlElement inca = Inca(root);
  const XmlElement data = root.Child("ImageData"), grid = root.Child("Grid");
  const XmlElement timeline = root.Child("Timeline");
  SicdImage image;
  image.file = file;
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
  image.wavelength_m = kSpeedOfLight_mps / inca.Child("FreqZero").Positive();
  image.closest_time_s = ReadPolynomial(inca.Child("TimeCAPoly"));
  image.closest_range_m = inca.Child("R_CA_SCP").Positive();
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
