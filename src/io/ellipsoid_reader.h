// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"

#include "tables/toml.h"

namespace sarblock {

/// The `ellipsoid` of a block's or a scene's frame: a name, or { a_m = ..., f = ... }.
[[nodiscard]] Ellipsoid ReadEllipsoid(const TomlValue& value);

}  // namespace sarblock
