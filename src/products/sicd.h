// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/block/image_grid.h"
#include "sarblock/core/error.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/utc.h"
#include "xml.h"
#include <Eigen/Core>

namespace sarblock {

/// Standard deviations of the errors of an image, from ErrorStatistics; nothing where an element is
/// left out.
struct SicdErrorStatistics {
  /// Axes of PosVelErr: earth-fixed, or radial, in-track and cross-track of the earth-fixed or of
  /// the inertial velocity.
  enum class Axes : std::uint8_t { kEcf, kRicEcf, kRicEci };
  struct PositionAndVelocity {
    Axes axes = Axes::kEcf;
    /// Standard deviations of P1, P2, P3 [m] and V1, V2, V3 [m/s] at the aperture of the scene
    /// centre.
    std::array<double, 6> sigma{};
    Eigen::Matrix<double, 6, 6> correlation = Eigen::Matrix<double, 6, 6>::Identity();
    bool correlated = false;  ///< the file has CorrCoefs
  };
  std::optional<PositionAndVelocity> path;
  std::optional<double> range_bias_m;
  std::optional<double> zenith_delay_m;  ///< TropoRangeVertical
  /// Unmodeled: remaining errors of rows and columns, in metres of range and azimuth at the target.
  std::optional<double> row_sigma_m, column_sigma_m;
  std::vector<std::string> not_used;  ///< elements of the file that are not used
};

/// c_0 + c x + c_2 x^2 + ...; times in seconds from SicdImage::start.
using SicdPolynomial = std::vector<double>;
[[nodiscard]] double ValueOf(const SicdPolynomial& polynomial, double x);
[[nodiscard]] SicdPolynomial DerivativeOf(const SicdPolynomial& polynomial);

/// Sum of c_jk x^j y^k: [j] is the polynomial of y that x^j has.
using SicdPolynomial2 = std::vector<SicdPolynomial>;
[[nodiscard]] double ValueOf(const SicdPolynomial2& polynomial, double x_m, double y_m);

/// What gives range and range rate of a place in an image.
enum class SicdKind : std::uint8_t {
  kInca,                ///< grid RGZERO of RMA/INCA: closest approach
  kPolarFormat,         ///< grid RGAZIM of PFA
  kAzimuthCompression,  ///< grid RGAZIM of RGAZCOMP
  kPlane,               ///< grids PLANE, XRGYCR and XCTYAT: the place in the image plane itself
};

/// AdjustableParameterOffsets: what an adjustment found, to be added to path and ranges,
///
///     ARP(t) + position + velocity (t - t_SCP),   R + range,   range = c/2 (dt_Rcv - dt_Tx)
struct SicdOffsets {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< ARPPosSCPCOA
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< ARPVel
  double range_m = 0.0;                                    ///< of RcvTimeSCPCOA less TxTimeSCPCOA
};

/// Geometry in the metadata of a SICD image. Names and meanings: NGA.STND.0024-1, SICD volume 1. x
/// counts metres of rows, y metres of columns from the scene centre point. What another kind of
/// image needs is empty.
struct SicdImage {
  std::string file;
  SicdKind kind = SicdKind::kInca;
  std::string core_name;
  LookSide side = LookSide::kRight;
  double wavelength_m = 0.0;          ///< c / FreqZero, or of the middle of TxFrequencyProc
  std::size_t rows = 0, columns = 0;  ///< of this file, which may be a part of the image
  double first_row_px = 0.0, first_column_px = 0.0;
  double centre_row_px = 0.0, centre_column_px = 0.0;  ///< SCPPixel, of the whole image
  double row_spacing_m = 0.0, column_spacing_m = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< SCP, earth-fixed
  UtcTime start;                                       ///< CollectStart
  double duration_s = 0.0;                             ///< CollectDuration
  std::array<SicdPolynomial, 3> path_m;                ///< ARPPoly, earth-fixed
  double centre_time_s = kNotGiven;                    ///< SCPTime; NaN where the file has none
  std::optional<SicdOffsets> offsets;                  ///< nothing where the file has none
  /// ImageCorners, latitude and longitude [rad] at the height of the scene centre: first row and
  /// first column, first and last, last and last, last and first; nothing where the file has none.
  std::optional<std::array<Geodetic, 4>> corners;
  /// TimeCOAPoly, of x and y; kInca: empty where the file has none.
  SicdPolynomial2 aperture_time_s;

  SicdPolynomial closest_time_s;  ///< kInca: TimeCAPoly, of y
  double closest_range_m = 0.0;   ///< kInca: R_CA_SCP
  SicdPolynomial2 rate_scale;     ///< kInca: DRateSFPoly, of x and y; empty where there is none

  SicdPolynomial polar_angle_rad;         ///< kPolarFormat: PolarAngPoly, of time
  SicdPolynomial frequency_scale;         ///< kPolarFormat: SpatialFreqSFPoly, of the polar angle
  double cone_cosine_per_m = 0.0;         ///< kAzimuthCompression: AzSF
  std::array<Eigen::Vector3d, 2> axes{};  ///< kPlane: UVectECF of rows and of columns

  /// Lines of elements, for refusals that come after reading.
  std::vector<std::pair<std::string, std::size_t>> element_lines;
  /// Path of an element, as `SICD.Position.ARPPoly`.
  [[nodiscard]] FilePlace PlaceOf(const char* element) const;
  std::optional<SicdErrorStatistics> errors;  ///< ErrorStatistics

  /// x of a row.
  [[nodiscard]] double Row_m(double row_px) const {
    return (row_px + first_row_px - centre_row_px) * row_spacing_m;
  }
  /// y of a column.
  [[nodiscard]] double Azimuth_m(double column_px) const {
    return (column_px + first_column_px - centre_column_px) * column_spacing_m;
  }
  /// Slant range of closest approach of a row, the offset of the ranges added.
  [[nodiscard]] double ClosestRange_m(double row_px) const {
    return closest_range_m + Row_m(row_px) + RangeOffset_m();
  }
  [[nodiscard]] double RangeOffset_m() const { return offsets ? offsets->range_m : 0.0; }
};

/// Reads the metadata of a SICD image: a NITF file (2.1, or NSIF 1.0) with the XML in a data
/// extension segment, or the XML alone; pixels are never read. Throws InputError with file, line
/// and element for what is missing or makes no sense, for sizes beyond the end of the file, for
/// bistatic images (by name, or whose transmitter and receiver are apart) and for kinds that
/// SicdKind does not have. docs/import_sicd.md.
[[nodiscard]] SicdImage ReadSicd(const std::string& file);
/// The same of bytes in memory; `file` is for messages.
[[nodiscard]] SicdImage ParseSicd(std::string_view bytes, const std::string& file);

/// Reads SICD.ErrorStatistics; nothing if the file has none. Throws InputError with file, line
/// and element for standard deviations below 0 and correlations beyond 1.
[[nodiscard]] std::optional<SicdErrorStatistics> ReadErrorStatistics(const XmlElement& root);

/// What a place in a SICD image measured: range and its rate at an exact time, the centre of the
/// aperture (COA).
struct ApertureLook {
  double time_s = 0.0;  ///< from SicdImage::start
  double range_m = 0.0;
  double range_rate_mps = 0.0;  ///< positive: the range grows
};

/// The look of a row and column (0, 0 is the middle of the first pixel of the file), by the image
/// projections of NGA.STND.0024-3, SICD volume 3. Nothing where the polynomials give no range above
/// 0, a range rate that is not below the speed, or no finite numbers.
[[nodiscard]] std::optional<ApertureLook> LookOfPlace(const SicdImage& image,
                                                      double row_px,
                                                      double column_px);

/// Standard deviations of range and range rate of a look whose row and column have these. The time
/// is fixed: an error of it changes measured and predicted range and rate alike.
struct ApertureSigma {
  double range_m = 0.0;
  double range_rate_mps = 0.0;
};
[[nodiscard]] std::optional<ApertureSigma> SigmaOfPlace(const SicdImage& image,
                                                        double row_px,
                                                        double column_px,
                                                        double row_sigma_px,
                                                        double column_sigma_px);

/// Row (line_px) and column (pixel_px) at which an earth-fixed place is seen, by Newton's method
/// from the scene centre. Nothing where it finds none.
[[nodiscard]] std::optional<ImageCoordinates> PlaceInSicd(const SicdImage& image,
                                                          const Eigen::Vector3d& p_m);

/// Position and velocity of the antenna: MotionOf() as the polynomials give them,
/// AdjustedMotionOf() with the file's offsets. Projections form ranges and rates of the first and
/// compare them with the second.
struct SicdMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};
[[nodiscard]] SicdMotion MotionOf(const SicdImage& image, double time_s);
[[nodiscard]] SicdMotion AdjustedMotionOf(const SicdImage& image, double time_s);

}  // namespace sarblock
