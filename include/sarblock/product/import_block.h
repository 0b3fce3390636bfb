// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/flight/path_through.h"
#include "sarblock/product/faulty_row.h"
#include "sarblock/product/sentinel1.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

struct ImportOptions {
  std::string name = "import";            ///< of the block
  std::vector<std::string> pass_ids;      ///< one a product; empty: made of the product's own names
  PointRole grid = PointRole::kCheck;     ///< what the geolocation grid points become
  std::optional<double> grid_sigma_m;     ///< of their positions, each axis; needed for control
  std::optional<double> range_sigma_m;    ///< of looks; left out: a pixel, evenly spread
  std::optional<double> azimuth_sigma_m;  ///< of looks; left out: a line, evenly spread
  double max_misfit_m = 10.0;             ///< a grid point that fits its orbit worse is faulty
  double orbit_step_s = 1.0;              ///< spacing of the path's states; 0: as given
  OrbitThrough through = OrbitThrough::kStates;
  double orbit_margin_s = 60.0;  ///< of an orbit file, before and after the product
};

/// What was found for one product; misfits of its good grid points, predicted minus given.
struct ImportedProduct {
  std::string file, pass, orbit_source;
  std::size_t grid_points = 0, good = 0;
  double largest_range_m = 0.0;  ///< |e_r|
  double largest_along_m = 0.0;  ///< |e_d|
  double mean_along_m = 0.0;     ///< e_d
};

struct ImportedBlock {
  Block block;
  std::vector<ImportedProduct> products;
  std::vector<FaultyRow> faults;
  std::vector<std::string> warnings;
};

/// Makes one block of several products, one pass each: geocentric WGS84 frame, path from the
/// product's states or, where `orbits` are given, from the one that covers the product with margin;
/// times counted from the whole second before the product's first line, leap seconds included; look
/// side from the grid; squint 0 (zero-Doppler products); one look and one point for every grid
/// point, time and range as the grid gives them. docs/import.md.
///
/// A grid point is held against the orbit: e_r = |p - s(t)| - R, e_d = v.(p - s)/|v|. Beyond
/// max_misfit_m in either it is faulty. If a change of height alone makes it fit, its latitude and
/// longitude are kept, its height is free (control and check points with grid_sigma_m) or its
/// position is dropped (others); else its look is rejected.
///
/// Throws InputError for options that make no sense, two products with one id, a product that no
/// orbit file covers and a grid outside the orbit's time span.
[[nodiscard]] ImportedBlock ImportProducts(const std::vector<Sentinel1Product>& products,
                                           const std::vector<OrbitFile>& orbits,
                                           const ImportOptions& options);

}  // namespace sarblock
