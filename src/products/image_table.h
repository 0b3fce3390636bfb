// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/block/image_grid.h"
#include "sarblock/geometry/frame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "block_builder.h"
#include "core/utc.h"
#include "image.h"
#include "sentinel1_timing.h"
#include <Eigen/Core>

namespace sarblock {

/// One point of a geolocation grid: time, range and ground of one pixel by the processor.
struct GeolocationGridPoint {
  int line = 0;
  int pixel = 0;
  UtcTime time;                ///< zero-Doppler azimuth time
  double slant_range_m = 0.0;  ///< one way: c/2 times slantRangeTime
  Geodetic place;              ///< WGS84
  std::size_t file_line = 0;   ///< of its element
};

/// Whether invalid values in a part of a file cause a refusal (kUsed), or are left out and counted
/// in the warnings (kCompared): parts that do not become part of a block are only compared with it.
enum class PartUse : std::uint8_t { kUsed, kCompared };

/// First and last sample of a line that are part of the image.
using ValidSamples = std::array<int, 2>;

/// Geometry in a Sentinel-1 annotation file (SLC or GRD). Names and meanings: Sentinel-1 Product
/// Specification, S1-RS-MDA-52-7441.
struct Sentinel1Product {
  std::string file;
  std::string mission, swath, polarisation;  ///< S1A, IW2, VV
  std::string orbit_source;                  ///< Auxiliary, Downlink, ...
  double wavelength_m = 0.0;                 ///< c / radarFrequency
  UtcTime first_line, last_line;
  Presentation presentation = Presentation::kSlant;
  double line_interval_s = 0.0;
  double near_range_m = 0.0;     ///< kSlant: c/2 slantRangeTime; kGround: 0
  double range_spacing_m = 0.0;  ///< kSlant: c/2 / rangeSamplingRate; kGround: rangePixelSpacing
  std::vector<ProductGroundRange> ground_range;
  std::vector<UtcTime> bursts;  ///< azimuthTime of each; empty for images in one piece
  int lines_per_burst = 0;
  std::size_t lines = 0, samples = 0;       ///< of the image; 0: the file does not say
  std::vector<ValidSamples> valid_samples;  ///< by line of all bursts; empty: the file has none
  std::vector<OrbitState> orbit;            ///< two or more, times increasing
  std::vector<GeolocationGridPoint> grid;   ///< by line, then pixel
  Sentinel1Radar radar;                     ///< pulses and Dopplers
  std::vector<std::string> warnings;        ///< what was left out of parts that are not used
};

/// Which parts of an annotation become part of a block.
struct Sentinel1Use {
  PartUse grid = PartUse::kUsed;
  PartUse orbit = PartUse::kUsed;  ///< kCompared: an orbit file takes its place
};

/// Reads an annotation. What it lacks or what makes no sense throws InputError with file, line and
/// element. Slant range products with bursts are taken as one image of bursts.
[[nodiscard]] Sentinel1Product ParseSentinel1(std::string_view text,
                                              const std::string& file,
                                              const Sentinel1Use& use = {});

/// Compares the raster with the grid: throws InputError where a grid point lies more than a line or
/// a sample from where the raster has its time and range. `trusted` are those whose time and
/// position agree with the orbit. Annotations agree within 0.2 lines and 4 mm.
void RequireRasterOfGrid(const Sentinel1Product& product, const std::vector<bool>& trusted);

/// An orbit file (Earth Explorer `List_of_OSVs`: AUX_RESORB, AUX_POEORB, AUX_PREORB).
struct OrbitFile {
  std::string file;
  std::string mission;  ///< as its header names it: Sentinel-1A
  std::vector<OrbitState> states;
  std::vector<std::string> quality{};  ///< of each state, empty where the file says none
};
/// Reads the UTC times of an orbit file; earth-fixed only.
[[nodiscard]] OrbitFile ParseOrbitFile(std::string_view text, const std::string& file);

/// An orbit file's text; `file` is its name without ending. Times are written to the microsecond,
/// so states must be at whole ones (WholeMicrosecond); positions and velocities with the digits
/// that read back to the same double. UT1 and the orbit number, which are not known, are left out.
[[nodiscard]] std::string OrbitFileText(const OrbitFile& orbit,
                                        const UtcTime& created,
                                        const std::string& creator_version);

/// Which of the two images of a product: the main band, or the narrower one beside it.
enum class NisarFrequency : std::uint8_t { kA, kB };

/// The geolocation grid: longitude and latitude (WGS84) by height, time and range, the last one
/// running fastest.
struct NisarGrid {
  std::vector<double> height_m;
  std::vector<UtcTime> time;  ///< zero-Doppler
  std::vector<double> slant_range_m;
  std::vector<double> longitude_deg, latitude_deg;

  [[nodiscard]] std::size_t Index(std::size_t height, std::size_t row, std::size_t column) const {
    return (height * time.size() + row) * slant_range_m.size() + column;
  }
};

/// Geometry in an RSLC product of NISAR (HDF5). Names and meanings: NISAR L1 RSLC product
/// specification, JPL D-102268.
struct NisarProduct : ZeroDopplerImage {
  std::string band;       ///< LSAR or SSAR
  std::string frequency;  ///< frequencyA or frequencyB
  std::string orbit_type;
  NisarGrid grid;  ///< empty where the product has none
  std::vector<std::string> warnings;
};

/// Reads the metadata of an RSLC; its pixels are never read. At most 10,000 states and a grid of at
/// most 33,554,432 points. Throws InputError with the file and the path of the dataset for what is
/// missing, makes no sense, or claims more values than are in the file. docs/import_nisar.md.
[[nodiscard]] NisarProduct ReadNisar(const std::string& file,
                                     NisarFrequency frequency = NisarFrequency::kA,
                                     PartUse grid = PartUse::kUsed);

/// Whether an orbit file is of the satellite of a product and covers its image and grid.
[[nodiscard]] bool Covers(const OrbitFile& orbit, const Sentinel1Product& product);

/// The image of a product as a pass, its id made of the product's own names. An annotation of
/// Sentinel-1 does not give the look side: it follows from the grid.
[[nodiscard]] ImagePass PassOfSentinel1(const Sentinel1Product& product,
                                        const std::vector<OrbitFile>& orbits,
                                        const ImportOptions& options,
                                        std::vector<std::string>* warnings);
/// `orbit_place` is where the product gives its orbit, for messages.
[[nodiscard]] ImagePass PassOfZeroDopplerImage(const ZeroDopplerImage& product,
                                               std::string id,
                                               const char* orbit_place,
                                               OrbitThrough through,
                                               const ImportOptions& options,
                                               std::vector<std::string>* warnings);
/// Delays in times and ranges of its image; `pass` is that of PassOfSentinel1() with its side and
/// `heights_m` are those of its grid points.
[[nodiscard]] Sentinel1Timing TimingOfSentinel1(const Sentinel1Product& product,
                                                const Pass& pass,
                                                const std::vector<double>& heights_m);
[[nodiscard]] ImagePass PassOfNisar(const NisarProduct& product,
                                    const ImportOptions& options,
                                    std::vector<std::string>* warnings);
/// The image of a cube or an ISD as a pass; its id is the file's name without ending.
[[nodiscard]] ImagePass PassOfRadarImage(const RadarImage& image,
                                         RangePolynomialTimes range_polynomial);

}  // namespace sarblock
