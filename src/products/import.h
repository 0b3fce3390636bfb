// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "block_builder.h"
#include "iceye.h"
#include "image.h"
#include "image_table.h"
#include "network.h"
#include "sicd.h"
#include "terrasarx.h"

namespace sarblock {

/// An image of any kind that an importer reads.
using SensorImage = std::
    variant<Sentinel1Product, NisarProduct, TerraSarXProduct, IceyeProduct, SicdImage, RadarImage>;

/// Reads an annotation of Sentinel-1 or TerraSAR-X or metadata of ICEYE (XML), an RSLC of NISAR
/// (HDF5), a SICD image (NITF or XML), a cube of ISIS or an ISD of USGSCSM (JSON), known by how the
/// file begins. Throws InputError with what the file's reader says, and for files of other kinds.
/// `use` says which parts become part of a block, of NISAR its grid.
[[nodiscard]] SensorImage ReadSensorImage(const std::string& file,
                                          NisarFrequency frequency = NisarFrequency::kA,
                                          const Sentinel1Use& use = {});

/// Reads a Sentinel-1 annotation.
[[nodiscard]] Sentinel1Product ReadSentinel1(const std::string& file, const Sentinel1Use& use = {});
/// Reads an annotation of TerraSAR-X, and GEOREF.xml where it is in ANNOTATION/ beside it or in its
/// own folder.
[[nodiscard]] TerraSarXProduct ReadTerraSarX(const std::string& file);
/// Reads the metadata of an ICEYE image.
[[nodiscard]] IceyeProduct ReadIceye(const std::string& file);
/// Reads an orbit file.
[[nodiscard]] OrbitFile ReadOrbitFile(const std::string& file);

/// What was found for one image; misfits of its good grid points, predicted minus given.
struct ImportedProduct {
  std::string file, pass, orbit_source;
  std::string orbit_file{};  ///< where one was taken in place of the product's own states
  std::size_t grid_points = 0, good = 0;
  double largest_range_m = 0.0;  ///< |e_r|
  double largest_along_m = 0.0;  ///< |e_d|
  double mean_along_m = 0.0;     ///< e_d
  std::size_t corners = 0;       ///< of ImportOptions::corner_sigma_m
  double corner_range_m = 0.0;   ///< their largest misfits
  double corner_along_m = 0.0;
  ImageDelays delays{};     ///< what was subtracted from its looks
  DelaySize grid_move_m{};  ///< of grid points, to where their reduced looks see them
  std::size_t matches = 0;  ///< looks of ImportOptions::points
  PixelOffset offset{};     ///< of those whose point has a position
  std::string stated{};     ///< what the product states of delays, for people
  std::string priors{};     ///< of SICD: what its own error statistics became, for people
};

/// Where a reflector should be seen, by the path as given.
struct ReflectorInImage {
  std::string id;
  std::size_t pass = 0;                   ///< index
  double line_px = 0.0, sample_px = 0.0;  ///< counted as ImportOptions::points counts
};

/// Images of one flight. They share the errors of its path: one shared group of corrections.
struct DataTake {
  std::vector<std::string> passes;
  double path_sigma_m = 0.0;  ///< prior of each axis
  std::size_t repeated = 0;   ///< looks rejected because another polarisation has the same pixel
};

struct ImportedBlock {
  Block block;
  std::vector<ImportedProduct> products;
  std::vector<ReflectorInImage> reflectors;
  std::vector<FaultyRow> faults;
  std::vector<std::string> warnings;
  std::vector<DataTake> takes;
  /// Corrections and priors that the products' own error statistics and data takes ask for.
  std::vector<CorrectionGroup> corrections;
  std::vector<JointPrior> priors;
};

/// Makes one block of several images of any kinds, one pass each: geocentric frame of their body,
/// times counted from the whole UTC second before an image's first line, leap seconds included;
/// squint 0 (zero-Doppler images), or the Doppler measured at an exact time (SICD images of other
/// kinds). The paths of Sentinel-1 products are their own states or, where
/// `orbits` are given, those of the file that covers the product with margin.
///
/// Known delays are subtracted from times and ranges of looks and stored with them
/// (ImportOptions::reduce); grid points are moved to where their looks, without delays, see the
/// ground of their height.
///
/// A grid point is compared with the orbit: e_r = |p - s(t)| - R, e_d = v.(p - s)/|v|. Beyond
/// max_misfit_m in either it is faulty. Where grid points become points, each has one look, its
/// time and range those of the grid; if a change of height alone makes a faulty one fit, its
/// latitude and longitude are kept, its height is free (control and check points with
/// grid_sigma_m) or its position is dropped (others); else its look is rejected.
///
/// Images of one flight (sub-swaths, polarisations, slices) get one shared position correction. A
/// pixel of one image that is measured in several polarisations counts once: later looks are
/// rejected. A product that no orbit file covers keeps its own states if all files belong to other
/// images.
///
/// Reflectors in the images become points if `points` measures them, or all of them if there is no
/// such table. docs/import.md.
///
/// Throws InputError for options that make no sense, two images with one id, images of different
/// bodies, a product that no orbit file covers, a grid outside the orbit's time span, an orbit that
/// sees all grid points at another time, a raster that contradicts its grid, matched points outside
/// their image, and reflectors that were moved by more than a metre between the
/// images.
[[nodiscard]] ImportedBlock ImportProducts(const std::vector<SensorImage>& images,
                                           const std::vector<OrbitFile>& orbits,
                                           const ImportOptions& options);

/// Makes one block of a control network and its images, one pass an image that is measured in:
/// geocentric frame of the images' ellipsoid, paths body-fixed, times counted from the whole UTC
/// second before the first line. Free points become tie points, constrained and fixed ones control
/// with the covariance that the network gives them; measures ignored or rejected, and those of such
/// points, become rejected looks. docs/import_isis.md.
///
/// Throws InputError for options that make no sense, serial numbers without an image (unless they
/// are to be left out), images of another body than the network's or each other's, constrained
/// points without position or covariance, measures without standard deviations and measures outside
/// their image's path. What is likely a mistake but not certain is a warning: images without
/// measures, a network and an image whose start times are a line apart, offsets of half a pixel or
/// of a line.
[[nodiscard]] ImportedNetwork ImportNetwork(const ControlNetwork& network,
                                            const std::vector<RadarImage>& images,
                                            const NetworkImportOptions& options);

}  // namespace sarblock
