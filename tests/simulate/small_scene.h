// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/simulate/scene.h"

namespace sarblock::test {

/// Two parallel strips, 7.3 km apart at 9.1 km height, looking left over flat ground.
inline Scene SmallScene() {
  SceneFlight flight;
  flight.id = "A";
  flight.side = LookSide::kLeft;
  flight.count = 2;
  flight.spacing_m = 7300.0;
  flight.height_m = 9100.0;
  flight.length_m = 21000.0;
  flight.speed_mps = 173.0;
  flight.heading_rad = 90.0 * kRadPerDeg;
  flight.start_m << -500.0, 300.0;
  flight.swath = {SwathKind::kGroundRange, {5200.0, 26000.0}};
  Scene scene;
  scene.name = "small";
  scene.seed = 77;
  scene.flights.push_back(flight);
  scene.looks.range_sigma_m = 0.7;
  scene.looks.azimuth.azimuth = 1.3;
  scene.points.count = 60;
  scene.points.east_m = {700.0, 19700.0};
  scene.points.north_m = {13100.0, 24900.0};
  return scene;
}

}  // namespace sarblock::test
