// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "block_builder.h"
#include "image.h"
#include <Eigen/Core>

namespace sarblock {

/// A point measured in one image. Line and sample as the file counts them: the centre of the first
/// pixel is 1, 1 where ISIS wrote it.
struct NetworkMeasure {
  std::uint32_t serial = 0;  ///< index into ControlNetwork::serials
  double line_px = 0.0, sample_px = 0.0;
  double line_sigma_px = std::numeric_limits<double>::quiet_NaN();    ///< NaN: not given
  double sample_sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not given
  bool unused = false;  ///< ignored by its user, or rejected by jigsaw
};

enum class NetworkPointType : std::uint8_t { kFree = 2, kConstrained = 3, kFixed = 4 };

struct NetworkPoint {
  std::string id;
  NetworkPointType type = NetworkPointType::kFree;
  bool unused = false;  ///< ignored, or rejected by jigsaw
  /// A-priori position, body-fixed; where there is none, the adjusted one.
  std::optional<Eigen::Vector3d> position_m;
  std::optional<Eigen::Matrix3d> covariance_m2;    ///< a priori, body-fixed axes
  std::optional<std::array<bool, 3>> constrained;  ///< longitude, latitude, radius
  std::vector<NetworkMeasure> measures;
};

/// A control network of ISIS: points and where they were measured in images, which it names by
/// their serial numbers.
struct ControlNetwork {
  std::string file;
  std::string target;  ///< name of the body as given, such as MOON
  int version = 0;
  std::vector<std::string> serials;  ///< in order of appearance
  std::vector<NetworkPoint> points;
};

/// Reads binary networks of versions 2 and 5: a PVL label, a header message and one message per
/// point, in the wire format of protocol buffers. Memory is that of the points: every size is
/// checked against the file before anything is read. Throws InputError with the file and the byte
/// of what cannot be read, and for text networks and other versions, naming what converts them.
[[nodiscard]] ControlNetwork ReadControlNetwork(const std::string& file);
/// The same of bytes in memory; `file` is for messages.
[[nodiscard]] ControlNetwork ParseControlNetwork(std::string_view bytes, const std::string& file);

/// Serial numbers of a network and their images.
struct SerialMatches {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> image_of_serial;  ///< kNone: no image
  std::vector<std::size_t> serial_of_image;  ///< kNone: no measure of the network is in it
  std::vector<std::string> warnings;
};

/// Finds the image of every serial number: as the options say, else the image's own serial number,
/// else instrument and start time of it, else the file's name (which Ames Stereo Pipeline writes as
/// serial number), else the start time at its end, within two lines. Warns of images that no
/// measure is in and of start times a line apart. Throws InputError where two images have one
/// serial number and, unless they are to be left out, where one has no image.
[[nodiscard]] SerialMatches MatchSerials(const ControlNetwork& network,
                                         const std::vector<RadarImage>& images,
                                         const NetworkImportOptions& options);

}  // namespace sarblock
