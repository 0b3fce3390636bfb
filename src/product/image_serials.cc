// SPDX-License-Identifier: Apache-2.0
#include "image_serials.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/text.h"
#include "ephemeris_time.h"
#include <fmt/core.h>

namespace sarblock {
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
      throw Failure(images_[image].file + " stands behind two serial numbers of --serial");
    }
    result_.image_of_serial[serial] = image;
    result_.serial_of_image[image] = serial;
  }

  static std::string SomeOf(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 3;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
      text += (i > 0 ? ", " : "") + Quoted(names[i]);
    }
    return names.size() > kMost ? text + fmt::format(" and {} more", names.size() - kMost) : text;
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

  // A cube takes its start time from the label that made the serial number: of ISDs both are known.
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
