// SPDX-License-Identifier: Apache-2.0
#include "network.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "bytes.h"
#include "core/text.h"
#include "core/utc.h"
#include "isis.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::uint64_t kLargestMessage = 64U << 20U;  // half a million measures of one point

// Numbers of the fields, from ControlNetFileHeaderV0002.proto and ControlPointFileEntryV0002.proto
// of ISIS.
enum HeaderField : std::uint32_t { kHeaderTarget = 2, kHeaderPointSizes = 7 };
enum PointField : std::uint32_t {
  kPointId = 1,
  kPointType = 2,
  kPointIgnored = 6,
  kPointRejected = 7,
  kPointLatitudeConstrained = 13,
  kPointLongitudeConstrained = 14,
  kPointRadiusConstrained = 15,
  kPointAprioriX = 16,
  kPointAprioriCovariance = 19,
  kPointAdjustedX = 20,
  kPointMeasure = 25
};
enum MeasureField : std::uint32_t {
  kMeasureSerial = 1,
  kMeasureSample = 3,
  kMeasureLine = 4,
  kMeasureIgnored = 10,
  kMeasureRejected = 11,
  kMeasureSampleSigma = 15,
  kMeasureLineSigma = 16
};

struct Region {
  std::uint64_t start = 0, bytes = 0;
};

/// What the label says of the file behind it.
struct NetworkLabel {
  int version = 0;
  std::string target;
  Region header, points;
};

NetworkLabel LabelOf(ByteSource* source) {
  const PvlObject root = ReadPvlLabel(source);
  if (root.Find("ControlNetwork") != nullptr) {
    throw InputError(FilePlace{source->file(), 0, "ControlNetwork"},
                     "is a network as text; a binary one is needed, which ISIS writes of it with "
                     "cnetpvl2bin");
  }
  if (root.Find("ProtoBuffer") == nullptr) {
    throw InputError(FilePlace{source->file(), 0, "ProtoBuffer"},
                     "is missing in the label: a binary control network of ISIS (.net) is needed");
  }
  const PvlObject& buffer = root.Child("ProtoBuffer");
  const PvlObject& info = buffer.Child("ControlNetworkInfo");
  NetworkLabel label;
  const std::uint64_t version = info.Count("Version", 0);
  if (version != 2 && version != 5) {
    info.Fail("Version",
              fmt::format("{} is not read, 2 and 5 are; a present ISIS writes it as version 5 "
                          "(cnetedit, or any program that saves the network)",
                          version));
  }
  label.version = static_cast<int>(version);
  if (info.FindKey("TargetName") != nullptr) label.target = info.Text("TargetName");
  const PvlObject& core = buffer.Child("Core");
  for (const auto& [region, start, bytes] :
       {std::tuple{&label.header, "HeaderStartByte", "HeaderBytes"},
        std::tuple{&label.points, "PointsStartByte", "PointsBytes"}}) {
    region->start = core.Count(start, 0);
    region->bytes = core.Count(bytes, 0);
    if (region->start > source->size() || region->bytes > source->size() - region->start) {
      core.Fail(bytes,
                fmt::format("{} from byte {} are not in the file, which has {} bytes",
                            region->bytes,
                            region->start,
                            source->size()));
    }
  }
  if (label.header.bytes > kLargestMessage) {
    core.Fail("HeaderBytes", "is longer than 64 MiB, which no header is");
  }
  return label;
}

class NetworkReader {
 public:
  explicit NetworkReader(ByteSource source) : source_(std::move(source)) {}

  ControlNetwork Read() {
    const NetworkLabel label = LabelOf(&source_);
    network_.file = source_.file();
    network_.version = label.version;
    network_.target = label.target;
    const std::vector<std::uint64_t> sizes = ReadHeader(label);
    if (label.version == 2) {
      ReadPointsOfSizes(label.points, sizes);
    } else {
      ReadPointsWithSizes(label.points);
    }
    for (std::size_t i = 0; i < serials_.size(); ++i) network_.serials.emplace_back(serials_[i]);
    return std::move(network_);
  }

 private:
  [[noreturn]] void Fail(std::uint64_t byte, const std::string& problem) const {
    throw InputError(FilePlace{source_.file(), 0, fmt::format("byte {}", byte)}, problem);
  }

  std::vector<std::uint64_t> ReadHeader(const NetworkLabel& label) {
    const std::string message = source_.Read(label.header.start, label.header.bytes, "header");
    WireReader reader(message, source_.file(), label.header.start);
    std::vector<std::uint64_t> sizes;
    for (WireField field; reader.Next(&field);) {
      if (field.number == kHeaderTarget && field.type == 2) network_.target = field.bytes;
      if (field.number != kHeaderPointSizes) continue;
      if (field.type == 0) sizes.push_back(field.varint);
      WireReader list(field.bytes, source_.file(), reader.ValueOffset(field));
      while (field.type == 2 && !list.AtEnd()) sizes.push_back(list.Varint());
    }
    return sizes;
  }

  void ReadPointsOfSizes(const Region& region, const std::vector<std::uint64_t>& sizes) {
    std::uint64_t at = region.start;
    for (const std::uint64_t size : sizes) ReadPointMessage(region, size, &at);
    if (at != region.start + region.bytes) {
      Fail(at, "the sizes of the points in the header do not add up to PointsBytes of the label");
    }
  }

  void ReadPointsWithSizes(const Region& region) {
    std::uint64_t at = region.start;
    while (at < region.start + region.bytes) {
      if (region.start + region.bytes - at < sizeof(std::uint32_t)) {
        Fail(at, "the size of a point is cut short");
      }
      const std::string size = source_.Read(at, sizeof(std::uint32_t), "points");
      at += size.size();
      ReadPointMessage(region, LittleEndianUint32(size.data()), &at);
    }
  }

  void ReadPointMessage(const Region& region, std::uint64_t size, std::uint64_t* at) {
    const std::uint64_t left = region.start + region.bytes - *at;
    if (size > left || size > kLargestMessage) {
      Fail(*at, fmt::format("a point of {} bytes; {} are left and 64 MiB are allowed", size, left));
    }
    const std::string message = source_.Read(*at, size, "points");
    network_.points.push_back(ReadPoint(message, *at));
    *at += size;
  }

  NetworkPoint ReadPoint(const std::string& message, std::uint64_t offset) {
    WireReader reader(message, source_.file(), offset);
    NetworkPoint point;
    Eigen::Vector3d apriori_m = Eigen::Vector3d::Constant(std::nan(""));
    Eigen::Vector3d adjusted_m = apriori_m;
    std::array<std::optional<bool>, 3> constrained;
    for (WireField field; reader.Next(&field);) {
      const bool set = field.type == 0 && field.varint != 0;
      switch (field.number) {
        case kPointId:
          point.id = field.bytes;
          break;
        case kPointType:
          point.type = TypeOf(field, offset);
          break;
        case kPointIgnored:
        case kPointRejected:
          point.unused = point.unused || set;
          break;
        case kPointLatitudeConstrained:
          constrained[1] = set;
          break;
        case kPointLongitudeConstrained:
          constrained[0] = set;
          break;
        case kPointRadiusConstrained:
          constrained[2] = set;
          break;
        case kPointAprioriCovariance:
          point.covariance_m2 = CovarianceOf(field, point, offset);
          break;
        case kPointMeasure:
          if (field.type != 2) reader.Fail("a measure that is no message");
          point.measures.push_back(ReadMeasure(field.bytes, reader.ValueOffset(field), point.id));
          break;
        default:
          if (field.type != 1) break;
          if (field.number >= kPointAprioriX && field.number < kPointAprioriX + 3) {
            apriori_m[field.number - kPointAprioriX] = field.Double();
          } else if (field.number >= kPointAdjustedX && field.number < kPointAdjustedX + 3) {
            adjusted_m[field.number - kPointAdjustedX] = field.Double();
          }
      }
    }
    if (point.id.empty()) Fail(offset, "a point without an id");
    for (const Eigen::Vector3d& position_m : {adjusted_m, apriori_m}) {
      if (position_m.allFinite() && position_m.norm() > 0.0) point.position_m = position_m;
    }
    if (constrained[0] || constrained[1] || constrained[2]) {
      point.constrained = {constrained[0].value_or(false),
                           constrained[1].value_or(false),
                           constrained[2].value_or(false)};
    }
    return point;
  }

  NetworkPointType TypeOf(const WireField& field, std::uint64_t offset) const {
    // 0 and 1, tie and ground, are of files before the three types of today.
    if (field.type == 0 && field.varint <= 1) {
      return field.varint == 0 ? NetworkPointType::kFree : NetworkPointType::kFixed;
    }
    if (field.type != 0 || field.varint > 4) Fail(offset, "a point of a type that is not known");
    return static_cast<NetworkPointType>(field.varint);
  }

  Eigen::Matrix3d CovarianceOf(const WireField& field,
                               const NetworkPoint& point,
                               std::uint64_t offset) const {
    const std::vector<double> upper = field.Doubles();
    if (upper.size() != 6) {
      Fail(offset,
           fmt::format("point {}: its a-priori covariance has {} numbers, 6 are needed",
                       Quoted(point.id),
                       upper.size()));
    }
    Eigen::Matrix3d covariance_m2;
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = i; j < 3; ++j) {
        covariance_m2(i, j) = covariance_m2(j, i) = upper[next++];
      }
    }
    return covariance_m2;
  }

  NetworkMeasure ReadMeasure(std::string_view message,
                             std::uint64_t offset,
                             const std::string& point) {
    WireReader reader(message, source_.file(), offset);
    NetworkMeasure measure{.line_px = std::nan(""), .sample_px = std::nan("")};
    std::string_view serial;
    for (WireField field; reader.Next(&field);) {
      const bool number = field.type == 1;
      const bool set = field.type == 0 && field.varint != 0;
      if (field.number == kMeasureSerial && field.type == 2) serial = field.bytes;
      if (field.number == kMeasureSample && number) measure.sample_px = field.Double();
      if (field.number == kMeasureLine && number) measure.line_px = field.Double();
      if (field.number == kMeasureSampleSigma && number) measure.sample_sigma_px = field.Double();
      if (field.number == kMeasureLineSigma && number) measure.line_sigma_px = field.Double();
      if (field.number == kMeasureIgnored || field.number == kMeasureRejected) {
        measure.unused = measure.unused || set;
      }
    }
    if (serial.empty()) {
      Fail(offset, "point " + Quoted(point) + ": a measure without a serial number");
    }
    if (!std::isfinite(measure.line_px) || !std::isfinite(measure.sample_px)) {
      Fail(offset,
           fmt::format("point {} in {}: line and sample are needed, both finite",
                       Quoted(point),
                       Quoted(serial)));
    }
    for (double* const sigma_px : {&measure.line_sigma_px, &measure.sample_sigma_px}) {
      if (!(*sigma_px > 0.0 && std::isfinite(*sigma_px))) *sigma_px = std::nan("");
    }
    measure.serial = serials_.FindOrAppend(serial);
    return measure;
  }

  ByteSource source_;
  ControlNetwork network_;
  IdTable serials_;
};

}  // namespace

ControlNetwork ReadControlNetwork(const std::string& file) {
  return NetworkReader(ByteSource::FromFile(file)).Read();
}

ControlNetwork ParseControlNetwork(std::string_view bytes, const std::string& file) {
  return NetworkReader(ByteSource::FromBytes(bytes, file)).Read();
}

namespace {

constexpr std::size_t kNone = SerialMatches::kNone;

// Instrument and start time of SPACECRAFT/INSTRUMENT/TIME.
std::string_view WithoutSpacecraft(std::string_view serial) {
  const std::size_t slash = serial.find('/');
  return slash == std::string_view::npos ? std::string_view() : serial.substr(slash + 1);
}

std::optional<double> StartOf(std::string_view serial) {
  const auto time = ParseUtc(serial.substr(serial.rfind('/') + 1));  // npos + 1 is 0
  return time ? std::optional<double>(EphemerisTime_s(*time)) : std::nullopt;
}

std::string StemOf(const std::string& file) { return std::filesystem::path(file).stem().string(); }

bool IsSerialOf(const RadarImage& image, const std::string& serial, int rule) {
  switch (rule) {
    case 0:
      return !image.serial.empty() && image.serial == serial;
    case 1:
      return !image.serial.empty() && !WithoutSpacecraft(serial).empty() &&
             WithoutSpacecraft(serial) == WithoutSpacecraft(image.serial);
    case 2:
      return StemOf(serial) == StemOf(image.file) ||
             std::filesystem::path(serial).filename() ==
                 std::filesystem::path(image.file).filename();
    default:
      const auto start_s = StartOf(serial);
      return image.serial.empty() && start_s &&
             std::abs(*start_s - image.first_line_s) < 2.0 * image.line_interval_s;
  }
}

class SerialMatcher {
 public:
  SerialMatcher(const ControlNetwork& network,
                const std::vector<RadarImage>& images,
                const NetworkImportOptions& options)
      : network_(network), images_(images), options_(options) {
    result_.image_of_serial.assign(network.serials.size(), kNone);
    result_.serial_of_image.assign(images.size(), kNone);
  }

  SerialMatches Match() {
    for (const SerialOfImage& given : options_.serials) MatchGiven(given);
    for (int rule = 0; rule < 4; ++rule) {
      for (std::size_t image = 0; image < images_.size(); ++image) MatchImage(image, rule);
    }
    RefuseMissing();
    for (std::size_t image = 0; image < images_.size(); ++image) {
      if (result_.serial_of_image[image] == kNone) WarnOfUnused(image);
    }
    WarnOfStarts();
    return std::move(result_);
  }

 private:
  [[nodiscard]] InputError Failure(const std::string& problem) const {
    return InputError(FilePlace{network_.file, 0, "serial number"}, problem);
  }

  void MatchGiven(const SerialOfImage& given) {
    const auto found = std::find(network_.serials.begin(), network_.serials.end(), given.serial);
    if (found == network_.serials.end()) {
      throw Failure(Quoted(given.serial) +
                    " of --serial is in no measure of the network, which has " +
                    SomeOf(network_.serials));
    }
    Pair(static_cast<std::size_t>(found - network_.serials.begin()), given.image);
  }

  void MatchImage(std::size_t image, int rule) {
    if (result_.serial_of_image[image] != kNone) return;
    for (std::size_t serial = 0; serial < network_.serials.size(); ++serial) {
      // What one rule found no later, weaker one contradicts.
      if (result_.image_of_serial[serial] != kNone && rule > 0) continue;
      if (IsSerialOf(images_[image], network_.serials[serial], rule)) {
        Pair(serial, image);
        return;
      }
    }
  }

  void Pair(std::size_t serial, std::size_t image) {
    const std::size_t other = result_.image_of_serial[serial];
    if (other != kNone) {
      throw Failure(
          fmt::format("{} is that of {} and of {}: give one of the two images, or "
                      "--serial SERIAL=FILE for both",
                      Quoted(network_.serials[serial]),
                      images_[other].file,
                      images_[image].file));
    }
    if (result_.serial_of_image[image] != kNone) {
      throw Failure(images_[image].file + " is given for two serial numbers of --serial");
    }
    result_.image_of_serial[serial] = image;
    result_.serial_of_image[image] = serial;
  }

  static std::string SomeOf(const std::vector<std::string>& names) {
    constexpr std::size_t kMax = 3;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMax); ++i) {
      text += (i > 0 ? ", " : "") + Quoted(names[i]);
    }
    return names.size() > kMax ? text + fmt::format(" and {} more", names.size() - kMax) : text;
  }

  void RefuseMissing() {
    std::vector<std::string> missing;
    for (std::size_t serial = 0; serial < network_.serials.size(); ++serial) {
      if (result_.image_of_serial[serial] == kNone) missing.push_back(network_.serials[serial]);
    }
    if (missing.empty()) return;
    const std::string text = fmt::format(
        "{} of {} have no image: {}", missing.size(), network_.serials.size(), SomeOf(missing));
    if (options_.missing == MissingImages::kLeaveOut) {
      result_.warnings.push_back(network_.file + ": serial numbers: " + text +
                                 "; their measures are left out");
      return;
    }
    throw Failure(text +
                  "; give their files, --serial SERIAL=FILE where a file does not tell its serial "
                  "number, or --leave-out-missing for a block without their measures");
  }

  void WarnOfUnused(std::size_t image) {
    std::string text = images_[image].file + ": no measure of the network is in this image";
    if (!images_[image].serial.empty()) {
      text += ", whose serial number is " + Quoted(images_[image].serial);
    }
    result_.warnings.push_back(text +
                               "; it is left out. --serial SERIAL=FILE says which serial number "
                               "means it");
  }

  // A cube takes its start time from the label that made the serial number; an ISD has both.
  void WarnOfStarts() {
    for (std::size_t image = 0; image < images_.size(); ++image) {
      const std::size_t serial = result_.serial_of_image[image];
      if (serial == kNone || !images_[image].serial.empty()) continue;
      const auto start_s = StartOf(network_.serials[serial]);
      if (!start_s) continue;
      const double lines =
          (images_[image].first_line_s - *start_s) / images_[image].line_interval_s;
      if (!(std::abs(std::abs(lines) - 1.0) < 0.1)) continue;
      result_.warnings.push_back(fmt::format(
          "{}: starts one line ({:.3f} ms) {} than serial number {} says: the network was measured "
          "with another start time. --pixel-origin {:g},{:g} shifts the network by this line, or "
          "make the ISD with the version of ALE that made the network's images",
          images_[image].file,
          1e3 * std::abs(images_[image].first_line_s - *start_s),
          lines < 0.0 ? "earlier" : "later",
          Quoted(network_.serials[serial]),
          options_.pixel_origin_px[0] + (lines < 0.0 ? -1.0 : 1.0),
          options_.pixel_origin_px[1]));
    }
  }

  const ControlNetwork& network_;
  const std::vector<RadarImage>& images_;
  const NetworkImportOptions& options_;
  SerialMatches result_;
};

}  // namespace

SerialMatches MatchSerials(const ControlNetwork& network,
                           const std::vector<RadarImage>& images,
                           const NetworkImportOptions& options) {
  return SerialMatcher(network, images, options).Match();
}

}  // namespace sarblock
