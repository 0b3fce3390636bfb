// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/path.h"

#include <optional>
#include <string>
#include <vector>

#include "product/matched_points.h"
#include "product/reflectors.h"

namespace sarblock {

struct ImportOptions {
  std::string name = "import";        ///< of the block
  std::vector<std::string> pass_ids;  ///< one an image; empty: made of the images' own names
  std::optional<double>
      range_sigma_m;  ///< of looks; left out: what the image says, else a pixel, evenly spread
  std::optional<double>
      azimuth_sigma_m;  ///< of looks; left out: what the image says, else a line, evenly spread

  /// What the points of geolocation grids become; nothing: they are held against the orbit alone.
  std::optional<PointRole> grid = PointRole::kCheck;
  std::optional<double> grid_sigma_m;  ///< of their positions, each axis; needed for control
  /// SICD: the corners that the file places become check points known to this in each axis; left
  /// out: they are not read. Writers place them approximately.
  std::optional<double> corner_sigma_m;
  double max_misfit_m = 10.0;  ///< a grid point that fits its orbit worse is faulty

  double orbit_step_s = 1.0;  ///< spacing of the path's states; 0: as given
  OrbitThrough through = OrbitThrough::kStates;
  double orbit_margin_s = 60.0;  ///< of an orbit file, before and after the product

  std::optional<MatchedPoints> points;
  std::optional<Reflectors> reflectors;
  PointRole reflector_role = PointRole::kControl;  ///< control or check
  std::optional<double> reflector_sigma_m;  ///< of their positions, each axis; needed for control
};

}  // namespace sarblock
