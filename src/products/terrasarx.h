// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "block_builder.h"
#include "core/utc.h"
#include "image.h"

namespace sarblock {

/// One term of the delays in annotated times, as a polynomial of the two-way range time tau:
///
///     sum_k c_k (tau - tau_0)^k  [s]
struct RangeTimePolynomial {
  std::string source;                ///< ATMOS, IONO, TIMING
  double reference_s = 0.0;          ///< tau_0
  std::vector<double> coefficients;  ///< c_k [s^(1-k)]

  [[nodiscard]] double At_s(double tau_s) const;
};

/// `signalPropagationEffects` of a product: annotated minus geometric.
struct PropagationEffects {
  std::vector<RangeTimePolynomial> range_delays;    ///< of the two-way range time
  std::vector<RangeTimePolynomial> azimuth_shifts;  ///< of the azimuth time

  /// Their sums at an annotated one-way range.
  [[nodiscard]] LookDelay At(double range_m) const;
};

/// `range 2.2085 m (IONO 0.0279, ATMOS 2.1806), azimuth time -180 us (TIMING -180)`, in the middle
/// of where each term is valid; empty where there is none.
[[nodiscard]] std::string Describe(const PropagationEffects& effects);

/// One point of a geolocation grid: time, range and ground of one place by the processor.
struct TerraSarXGridPoint {
  int azimuth_index = 0, range_index = 0;  ///< `iaz`, `irg`
  UtcTime time;                            ///< annotated, zero-Doppler
  double range_m = 0.0;                    ///< annotated, one way
  Geodetic place;                          ///< WGS84
  std::size_t file_line = 0;               ///< of its element
};

/// Geometry in a product of TerraSAR-X, TanDEM-X or PAZ in slant range (SSC). Names and meanings:
/// TerraSAR-X Ground Segment, Level 1b Product Format Specification, TX-GS-DD-3307.
struct TerraSarXProduct : ZeroDopplerImage {
  std::string mission, mode;   ///< TSX-1, SM
  std::string orbit_accuracy;  ///< SCIE, RAPD, ...
  std::string georef_file;     ///< GEOREF.xml; empty: none was read
  PropagationEffects effects;  ///< of GEOREF.xml
  std::vector<TerraSarXGridPoint> grid;
};

/// Reads an annotation. What it lacks or what makes no sense throws InputError with file, line and
/// element; products in ground range and map geometry too.
[[nodiscard]] TerraSarXProduct ParseTerraSarX(std::string_view text, const std::string& file);

/// Adds what GEOREF.xml of the same product says to its annotation: delays and the geolocation
/// grid. A grid point at latitude phi, longitude lambda and "height" h lies on the ellipsoid whose
/// semi-axes are both longer by h, where phi is that ellipsoid's own geodetic latitude:
///
///     p = (N cos phi cos lambda, N cos phi sin lambda, N (1 - e^2) sin phi),
///     N = (a + h) / sqrt(1 - e^2 sin^2 phi),  1 - e^2 = (b + h)^2 / (a + h)^2
///
/// found on a grid, which agrees with its orbit to 1 um in this way, but only to 2 mm with heights
/// above the ellipsoid (docs/import_terrasarx.md). Throws InputError likewise, and for a grid whose
/// rows and columns have other times than the image: that of another product.
void AddGeoref(std::string_view text, const std::string& file, TerraSarXProduct* product);

/// Its image as a pass; its id is such as TSX-1_SM_20080310T133220. The path goes through the
/// positions unless `options` says otherwise: velocities are rounded to 1 mm/s. Where delays are
/// reduced but the product has no GEOREF.xml, the standard troposphere is left to the reduction.
[[nodiscard]] ImagePass PassOfTerraSarX(const TerraSarXProduct& product,
                                        const ImportOptions& options,
                                        std::vector<std::string>* warnings);

}  // namespace sarblock
