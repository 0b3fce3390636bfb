// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/utc.h"
#include "reduction/reduction.h"
#include "sentinel1_timing.h"
#include "sicd.h"
#include <Eigen/Core>

namespace sarblock {

/// A point as it was measured in one image.
struct MatchedPoint {
  std::string point;
  std::string image;  ///< id of a pass, or name of a file, with or without folder and ending
  double line_px = 0.0, sample_px = 0.0;
  double line_sigma_px = kNotGiven, sample_sigma_px = kNotGiven;
  std::size_t file_line = 0;
};

/// A table of points matched in images by any program.
struct MatchedPoints {
  std::string file;
  /// Line and sample of the centre of the first pixel in the table's numbers. 0: centres at whole
  /// numbers from 0 on; 0.5: the first pixel's upper left corner is 0, 0; 1: as ISIS and MATLAB.
  std::array<double, 2> origin_px{0.0, 0.0};
  std::vector<MatchedPoint> rows;
  std::vector<std::string> warnings;  ///< columns that are not known
};

/// Reads CSV with the columns point, image, line, sample and, optionally, line_sigma_px and
/// sample_sigma_px, plain or gzip. Throws InputError with file, line and column. docs/import.md.
[[nodiscard]] MatchedPoints ReadMatchedPoints(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] MatchedPoints ParseMatchedPoints(std::string_view text, const std::string& file);

/// One survey of a corner reflector.
struct ReflectorSurvey {
  std::string id;
  Geodetic place;                                          ///< WGS84, at the time of the survey
  std::optional<UtcTime> surveyed;                         ///< nothing: for all times
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< east, north, up
  bool usable = true;  ///< its validity says that geometry may be calibrated with it
  std::size_t file_line = 0;
};

/// Corner reflectors with the history of their surveys.
struct Reflectors {
  std::string file;
  std::vector<ReflectorSurvey> surveys;
};

/// Reads a table of corner reflectors as those of NISAR (JPL D-107698) and UAVSAR are published:
/// CSV with the columns `Corner reflector ID`, `Latitude (deg)`, `Longitude (deg)`, `Height above
/// ellipsoid (m)`, and optionally `Survey Date`, `Validity`, `Velocity East (m/s)` and so on. Only
/// bit 4 (geometry) of `Validity` is read. Throws InputError with file, line and column.
[[nodiscard]] Reflectors ReadReflectors(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] Reflectors ParseReflectors(std::string_view text, const std::string& file);

/// Where a reflector is at a time, in the axes of a geocentric frame.
struct ReflectorPosition {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::size_t file_line = 0;  ///< of the survey
};

/// The reflectors at a time: the latest survey of each before it, moved on by its velocity. Those
/// surveyed only later and those whose latest survey is not usable are left out.
[[nodiscard]] std::vector<ReflectorPosition> ReflectorsAt(const Reflectors& reflectors,
                                                          const UtcTime& time,
                                                          const Frame& frame);

/// Looks of one image: measured minus where the given positions of their points lie in it, median
/// over those that take part; NaN where there are none.
struct PixelOffset {
  std::size_t looks = 0;
  double line_px = kNotGiven;
  double sample_px = kNotGiven;
  double line_sigma_px = kNotGiven;  ///< standard deviation of the median
  double sample_sigma_px = kNotGiven;
};

/// Delays contained in a measured range and time (Looks::range_delay_m).
struct LookDelay {
  double range_m = 0.0, time_s = 0.0;
};
/// The delay at a time and range of an image, both as measured.
using DelayOfPlace = std::function<LookDelay(const RadarCoordinates& measured)>;

/// Time and range at which the given path of a pass sees a place at zero Doppler; nothing where it
/// does not.
[[nodiscard]] std::optional<RadarCoordinates> SeenBy(const Pass& pass, const Eigen::Vector3d& p_m);
/// Where that lies in the image of the pass.
[[nodiscard]] std::optional<ImageCoordinates> PlaceInImage(const Pass& pass,
                                                           const Eigen::Vector3d& p_m);

/// Collects offsets by pass.
class OffsetCollector {
 public:
  /// A look, without its delay, of a point whose given position is `p_m`; left out where one of
  /// both is outside.
  void Add(std::size_t index,
           const Pass& pass,
           const RadarCoordinates& measured,
           const Eigen::Vector3d& p_m);
  /// The same of lines and samples.
  void Add(std::size_t index,
           const ImageCoordinates& measured_px,
           const ImageCoordinates& given_px);
  /// One per pass.
  [[nodiscard]] std::vector<PixelOffset> Offsets(std::size_t passes) const;

 private:
  std::vector<std::vector<double>> lines_px_, samples_px_;
};

/// Names offsets that are half a pixel or one line, within 0.15 pixels and three standard
/// deviations of the median: mistakes of the origin of pixels or of start times. One sentence for
/// all passes with the same one; `measured_by` is the source of the lines and samples and `option`
/// what sets their origin.
[[nodiscard]] std::vector<std::string> NameOffsets(const Block& block,
                                                   const std::vector<PixelOffset>& offsets,
                                                   const std::array<double, 2>& pixel_origin_px,
                                                   const std::string& measured_by,
                                                   const std::string& option);

/// How the lines and samples of an image file lie in the raster of its pass (ImageGrid), whose
/// lines are azimuth and whose pixels are range.
enum class RasterAxes : std::uint8_t {
  kAzimuthDown,        ///< as in the raster
  kRangeDown,          ///< lines are range, samples azimuth
  kRangeDownMirrored,  ///< the same, samples counted against time
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
  /// First and last sample of each line that belong to the image; empty: all.
  std::vector<std::array<int, 2>> valid_samples{};
  const char* counting = "";  ///< added to the message on places outside: which images count
                              ///< otherwise
  std::string orbit_file{};   ///< that the path was taken from; empty: the image's own
  RasterAxes axes = RasterAxes::kAzimuthDown;
  DelayOfPlace delay{};  ///< delays in its looks, as the product states; empty: 0
  /// Standard deviations of its looks that the image itself gives, in metres at the target.
  std::optional<double> range_sigma_m{}, azimuth_sigma_m{};
  std::optional<RadarCoordinates> middle{};  ///< a place about the middle of the image
  /// In place of pass.image; lines are rows, samples are columns.
  std::optional<ApertureImage> aperture{};
  /// Delays of Sentinel-1 in times and ranges by place; null: they are not subtracted.
  std::shared_ptr<const Sentinel1Timing> timing{};
};

/// Standard deviation of a step, evenly spread: 1/sqrt(12).
inline constexpr double kEvenly = 0.28867513459481288;

/// Relative; ellipsoids of one body differ by less.
inline constexpr double kSameRadius = 1e-3;

/// The epoch time_s = 0 of a pass, for every importer: the whole UTC second before the first line,
/// which is stored in `pass` too.
[[nodiscard]] UtcTime SetEpoch(const UtcTime& first_line, Pass* pass);

/// A position known to `sigma_m` in each fixed axis.
[[nodiscard]] KnownPosition EquallyKnown(std::uint32_t point,
                                         const std::array<bool, 3>& fixed,
                                         double sigma_m);

/// Delays of a look that follow from its place in the image.
struct PlaceDelay {
  Sentinel1Delay timing;
  double troposphere_m = 0.0;  ///< of the model of its pass, at the ground then known
};

struct NewLook {
  std::uint32_t point = 0, pass = 0;
  std::uint8_t flags = 0;
  double time_s = 0.0, range_m = 0.0;
  double doppler_hz = kNotGiven;                                ///< measured; NaN: zero Doppler
  double range_sigma_m = kNotGiven, azimuth_sigma = kNotGiven;  ///< NaN: those of the pass
  /// Delays contained in `range_m` and `time_s` (Looks::range_delay_m), not yet subtracted here.
  double range_delay_m = 0.0, time_shift_s = 0.0;
  std::optional<PlaceDelay> by_place{};  ///< of SetDelays(), whose sum is in the two above
};

/// Smallest, largest and mean value of one kind of delay in looks.
struct DelaySize {
  std::size_t looks = 0;
  double least = 0.0, largest = 0.0, sum = 0.0;

  void Add(double value);
  [[nodiscard]] double Mean() const { return looks > 0 ? sum / static_cast<double>(looks) : 0.0; }
};
/// Delays of the looks of one pass: measured minus geometric.
struct ImageDelays {
  DelaySize bistatic_s, fm_rate_s, pulse_motion_m;  ///< Sentinel1Delay
  DelaySize troposphere_m;  ///< of Pass::reduction, at the ground then known
};

/// Puts images and points of all importers together: one geocentric frame, one pass an image, and
/// looks in any order.
class BlockBuilder {
 public:
  explicit BlockBuilder(const std::string& name) { block_.name = name; }

  /// Adds an image, its index is that of its pass. The first one gives the frame: images of
  /// another body are refused, and ids that exist already.
  std::uint32_t AddImage(ImagePass image);
  [[nodiscard]] const Frame& frame() const { return block_.frame; }
  [[nodiscard]] const Block& block() const { return block_; }

  /// A new tie point without a position; nothing if the name exists already.
  std::optional<std::uint32_t> AddPoint(std::string_view id);
  void SetPosition(std::uint32_t point, const Eigen::Vector3d& position_m);
  /// Makes the point control or check.
  void SetKnown(PointRole role, const KnownPosition& known);
  void AddLook(const NewLook& look);
  /// Sets the delays of a look at a place in the raster of its pass, for the ground that it shows:
  /// `p_m`, else that of the geolocation grid. Its time may be one that the product gives for the
  /// place instead of the raster's.
  void SetDelays(const ImageCoordinates& place,
                 const std::optional<Eigen::Vector3d>& p_m,
                 NewLook* look);
  /// Time and range of a look without its delays at p_m, those by the models of its pass included.
  [[nodiscard]] RadarCoordinates GeometricOf(const NewLook& look, const Eigen::Vector3d& p_m);
  /// Adds the looks of matched points, which are new tie points where no point has their name.
  void AddMatches(const MatchedPoints& matches);
  /// Line and sample of the image file where a place is seen, delays and shifts of the image
  /// included; nothing outside of it.
  [[nodiscard]] std::optional<ImageCoordinates> Locate(std::size_t pass,
                                                       const Eigen::Vector3d& p_m);

  /// Looks of matched points by pass, and offsets of those whose point has a position.
  [[nodiscard]] const std::vector<std::size_t>& MatchCounts() const { return match_counts_; }
  [[nodiscard]] std::vector<PixelOffset> MatchOffsets() const;
  /// By pass.
  [[nodiscard]] const std::vector<ImageDelays>& Delays() const { return delays_; }
  [[nodiscard]] Block Finish();

 private:
  void AppendTiePoint();
  [[nodiscard]] std::optional<ImageCoordinates> SeenAt(std::size_t pass,
                                                       const Eigen::Vector3d& p_m);
  [[nodiscard]] LookReduction ModelsAt(std::size_t pass, double time_s, const Eigen::Vector3d& p_m);
  void SetMatch(const MatchedPoints& matches, const MatchedPoint& row, NewLook* look);
  void SetDelaysWhereLooksMeet(const MatchedPoints& matches, std::vector<NewLook>* looks);
  void SetApertureMatch(const MatchedPoints& matches,
                        const MatchedPoint& row,
                        const ImageCoordinates& place,
                        NewLook* look) const;
  [[noreturn]] void FailOutside(const MatchedPoints& matches,
                                const MatchedPoint& row,
                                const std::string& problem) const;
  void RequireValid(const MatchedPoints& matches,
                    const MatchedPoint& row,
                    const ImagePass& image,
                    const ImageCoordinates& place) const;
  void CompareWithGiven(const MatchedPoints& matches, const MatchedPoint& row, const NewLook& look);
  [[nodiscard]] std::uint32_t ImageOf(const MatchedPoints& matches, const MatchedPoint& row) const;
  [[nodiscard]] bool Contains(const ImagePass& image, const ImageCoordinates& place) const;

  Block block_;
  std::vector<ImagePass> images_;
  std::vector<std::uint32_t> point_of_look_;
  std::vector<std::size_t> match_counts_;   // by pass
  std::vector<ImageDelays> delays_;         // by pass
  std::optional<ReductionOfLooks> models_;  // of the passes; none before they are asked for
  OffsetCollector offsets_;
};

/// A reflector and where it should be seen.
struct SeenReflector {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< mean over the dates of the images
  std::vector<std::pair<std::size_t, ImageCoordinates>> places;  ///< by pass
};

struct SeenReflectors {
  std::vector<SeenReflector> reflectors;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< id and why
};

/// The reflectors that lie in images, each where it was at the dates of those images. A block holds
/// a point once: positions of several dates are averaged, which is a warning from 1 mm on and
/// refused from 1 m on. `first_lines` are the times of the images.
[[nodiscard]] SeenReflectors ReflectorsInImages(const Reflectors& reflectors,
                                                const std::vector<UtcTime>& first_lines,
                                                BlockBuilder* builder,
                                                std::vector<std::string>* warnings);

struct ImportOptions {
  std::string name = "import";        ///< of the block
  std::vector<std::string> pass_ids;  ///< one per image; empty: made of the images' own names
  std::optional<double>
      range_sigma_m;  ///< of looks; left out: what the image says, else a pixel, evenly spread
  std::optional<double>
      azimuth_sigma_m;  ///< of looks; left out: what the image says, else a line, evenly spread

  /// What the points of geolocation grids become; nothing: they are only compared with the orbit.
  std::optional<PointRole> grid = PointRole::kCheck;
  std::optional<double> grid_sigma_m;  ///< of their positions, each axis; needed for control
  /// SICD: the corners that the file places become check points known to this in each axis; left
  /// out: they are not read. Writers place them approximately.
  std::optional<double> corner_sigma_m;
  double max_misfit_m = 10.0;  ///< a grid point that fits its orbit worse is faulty

  double orbit_step_s = 1.0;            ///< spacing of the path's states; 0: as given
  std::optional<OrbitThrough> through;  ///< left out: positions of TerraSAR-X, states of others
  double orbit_margin_s = 60.0;         ///< of an orbit file, before and after the product

  std::optional<MatchedPoints> points;
  std::optional<Reflectors> reflectors;
  PointRole reflector_role = PointRole::kControl;  ///< control or check
  std::optional<double> reflector_sigma_m;  ///< of their positions, each axis; needed for control

  /// Subtracts the known delays from ranges and times.
  bool reduce = true;
  /// Prior of the path of a flight with several images, each axis; left out: kPathSigma_m, of an
  /// on-board orbit kOnBoardSigma_m.
  std::optional<double> path_sigma_m;
  /// Requirements of Sentinel-1: restituted orbits 0.1 m; on-board orbits have a metre.
  static constexpr double kPathSigma_m = 0.1, kOnBoardSigma_m = 1.0;
};

/// Which ground range polynomial is valid at a time between two that are given.
enum class RangePolynomialTimes : std::uint8_t {
  kGiven,    ///< linear between their own times, as ISIS reads them
  kUsgscsm,  ///< Lagrange's of up to eight at even times that USGSCSM gives them: N polynomials
             ///< divide the span of their times by N, not by N - 1
};

enum class MissingImages : std::uint8_t { kRefuse, kLeaveOut };

/// Which image a serial number of the network means.
struct SerialOfImage {
  std::string serial;
  std::size_t image = 0;  ///< index into the images
};

struct NetworkImportOptions {
  std::string name = "import";         ///< of the block
  std::vector<std::string> pass_ids;   ///< one per image; empty: the files' names without endings
  std::vector<SerialOfImage> serials;  ///< take precedence over the files
  /// Line and sample of the centre of the first pixel in the network's numbers: 1 of ISIS, 0.5 of
  /// CSM.
  std::array<double, 2> pixel_origin_px{1.0, 1.0};
  RangePolynomialTimes range_polynomial = RangePolynomialTimes::kGiven;
  std::optional<double> range_sigma_m;    ///< of measures to which the network gives none
  std::optional<double> azimuth_sigma_m;  ///< of measures to which the network gives none
  bool jigsaw_sigma = false;              ///< RadarImage::jigsaw for all measures instead
  std::optional<double> control_sigma_m;  ///< each axis, of constrained points without covariance
  double fixed_sigma_m = 1e-3;            ///< each axis, of fixed points
  std::optional<double> height_sigma_m;   ///< constrains free points with a position in height
  MissingImages missing = MissingImages::kRefuse;
  std::optional<MatchedPoints> points;  ///< more looks, beside those of the network
};

/// Result for one image.
struct ImportedImage {
  std::string file, pass, serial;
  std::size_t looks = 0, rejected = 0;
  PixelOffset offset{};  ///< of the network's measures
};

struct ImportedNetwork {
  Block block;
  std::vector<ImportedImage> images;  ///< one per pass
  std::size_t fixed_points = 0;
  std::size_t matches = 0;  ///< looks of NetworkImportOptions::points
  std::vector<std::string> warnings;
};

}  // namespace sarblock
