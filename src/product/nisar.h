// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "product/orbit_state.h"
#include "product/utc_time.h"

namespace sarblock {

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

/// What an RSLC product of NISAR (HDF5) says of geometry. Names and meanings: NISAR L1 RSLC product
/// specification, JPL D-102268.
struct NisarProduct {
  std::string file;
  std::string band;       ///< LSAR or SSAR
  std::string frequency;  ///< frequencyA or frequencyB
  std::string orbit_type;
  LookSide side = LookSide::kLeft;
  double wavelength_m = 0.0;  ///< c / processedCenterFrequency
  std::size_t lines = 0, samples = 0;
  UtcTime first_line, last_line;  ///< zero-Doppler times of the centres of lines
  double line_interval_s = 0.0;
  double near_range_m = 0.0;  ///< one way, of the centre of the first sample
  double range_spacing_m = 0.0;
  std::vector<OrbitState> orbit;  ///< two or more, times increasing
  NisarGrid grid;                 ///< empty where the product has none
};

/// Reads the metadata of an RSLC; its pixels are never read. At most 10,000 states and a grid of at
/// most 33,554,432 points. Throws InputError with the file and the path of the dataset for what is
/// missing, makes no sense, or claims more values than are in the file. docs/import_nisar.md.
[[nodiscard]] NisarProduct ReadNisar(const std::string& file,
                                     NisarFrequency frequency = NisarFrequency::kA);

}  // namespace sarblock
