// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "block_builder.h"
#include "product/reflectors.h"

namespace sarblock {

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
                                                const BlockBuilder& builder,
                                                std::vector<std::string>* warnings);

}  // namespace sarblock
