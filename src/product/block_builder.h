// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image_offsets.h"
#include "product/matched_points.h"
#include "product/sicd.h"
#include "product/utc_time.h"

namespace sarblock {

/// How the lines and samples of an image file lie in the raster of its pass (ImageGrid), whose
/// lines are azimuth and whose pixels are range.
enum class RasterAxes : std::uint8_t {
  kAzimuthDown,        ///< as in the raster
  kRangeDown,          ///< lines are range, samples azimuth
  kRangeDownMirrored,  ///< likewise, samples counted against time
};

/// A SICD image whose looks are ranges and measured Dopplers at exact times, with the time of its
/// start from the pass's epoch.
struct ApertureImage {
  SicdImage sicd;
  double start_s = 0.0;
};

/// One image as a pass without looks. Its times count from the epoch that SetEpoch() gave it.
struct ImagePass {
  std::string file;  ///< for messages, and a name of the image
  Ellipsoid ellipsoid;
  UtcTime first_line{};
  Pass pass{};
  std::optional<std::array<double, 2>> span_s{};  ///< of the strip; nothing: that of its looks
  std::size_t lines = 0, samples = 0;             ///< of the raster; 0: not known
  RasterAxes axes = RasterAxes::kAzimuthDown;
  /// What the image itself says of its looks, in metres at the target.
  std::optional<double> range_sigma_m{}, azimuth_sigma_m{};
  std::optional<RadarCoordinates> middle{};  ///< a place about the middle of the image
  /// In place of pass.image; lines are rows, samples are columns.
  std::optional<ApertureImage> aperture{};
};

/// Standard deviation of a step, evenly spread: 1/sqrt(12).
inline constexpr double kEvenly = 0.28867513459481288;

/// Relative; ellipsoids of one body differ by less.
inline constexpr double kSameRadius = 1e-3;

/// What time_s = 0 of a pass is, for every importer: the whole UTC second before the first line,
/// which `pass` is told too.
[[nodiscard]] UtcTime SetEpoch(const UtcTime& first_line, Pass* pass);

/// A position known to `sigma_m` in each axis that is held.
[[nodiscard]] KnownPosition EquallyKnown(std::uint32_t point,
                                         const std::array<bool, 3>& held,
                                         double sigma_m);

struct NewLook {
  std::uint32_t point = 0, pass = 0;
  std::uint8_t flags = 0;
  double time_s = 0.0, range_m = 0.0;
  double doppler_hz = kNotGiven;                                ///< measured; NaN: zero Doppler
  double range_sigma_m = kNotGiven, azimuth_sigma = kNotGiven;  ///< NaN: those of the pass
};

/// Puts images and points of all importers together: one geocentric frame, one pass an image, and
/// looks in any order.
class BlockBuilder {
 public:
  explicit BlockBuilder(const std::string& name) { block_.name = name; }

  /// Adds an image, its index is that of its pass. The first one gives the frame: images of
  /// another body are refused, and ids that stand already.
  std::uint32_t AddImage(ImagePass image);
  [[nodiscard]] const Frame& frame() const { return block_.frame; }
  [[nodiscard]] const Block& block() const { return block_; }

  /// A new tie point without a position; nothing where the name stands already.
  std::optional<std::uint32_t> AddPoint(std::string_view id);
  void SetPosition(std::uint32_t point, const Eigen::Vector3d& position_m);
  /// Makes the point control or check.
  void SetKnown(PointRole role, const KnownPosition& known);
  void AddLook(const NewLook& look);
  /// Adds the looks of matched points, which are new tie points where no point has their name.
  void AddMatches(const MatchedPoints& matches);
  /// Line and sample of the image file where a place is seen; nothing outside of it.
  [[nodiscard]] std::optional<ImageCoordinates> Locate(std::size_t pass,
                                                       const Eigen::Vector3d& p_m) const;

  /// Looks of matched points by pass, and offsets of those whose point has a position.
  [[nodiscard]] const std::vector<std::size_t>& MatchCounts() const { return match_counts_; }
  [[nodiscard]] std::vector<PixelOffset> MatchOffsets() const;
  [[nodiscard]] Block Finish();

 private:
  void AppendTiePoint();
  void SetMatch(const MatchedPoints& matches, const MatchedPoint& row, NewLook* look) const;
  void SetApertureMatch(const MatchedPoints& matches,
                        const MatchedPoint& row,
                        const ImageCoordinates& place,
                        NewLook* look) const;
  [[noreturn]] void FailOutside(const MatchedPoints& matches,
                                const MatchedPoint& row,
                                const ImagePass& image,
                                const char* problem) const;
  void CompareWithGiven(const MatchedPoints& matches, const MatchedPoint& row, const NewLook& look);
  [[nodiscard]] std::uint32_t ImageOf(const MatchedPoints& matches, const MatchedPoint& row) const;
  [[nodiscard]] bool Contains(const ImagePass& image, const ImageCoordinates& place) const;

  Block block_;
  std::vector<ImagePass> images_;
  std::vector<std::uint32_t> point_of_look_;
  std::vector<std::size_t> match_counts_;  // by pass
  OffsetCollector offsets_;
};

}  // namespace sarblock
