// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plants.h"

namespace sarblock::test {

[[nodiscard]] std::vector<Plant> ControlPlants();

}  // namespace sarblock::test
