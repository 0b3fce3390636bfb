// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>

#include "product/nisar.h"
#include "product/radar_image.h"
#include "product/sentinel1.h"
#include "product/sicd.h"

namespace sarblock {

/// An image of any kind that an importer reads.
using SensorImage = std::variant<Sentinel1Product, NisarProduct, SicdImage, RadarImage>;

/// Reads a Sentinel-1 annotation (XML), an RSLC of NISAR (HDF5), a SICD image (NITF or XML), a cube
/// of ISIS or an ISD of USGSCSM (JSON), known by how the file begins. Throws InputError with what
/// the file's reader says, and for files of other kinds.
[[nodiscard]] SensorImage ReadSensorImage(const std::string& file,
                                          NisarFrequency frequency = NisarFrequency::kA);

/// Reads a Sentinel-1 annotation.
[[nodiscard]] Sentinel1Product ReadSentinel1(const std::string& file);
/// Reads an orbit file.
[[nodiscard]] OrbitFile ReadOrbitFile(const std::string& file);

}  // namespace sarblock
