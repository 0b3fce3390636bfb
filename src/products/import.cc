// SPDX-License-Identifier: Apache-2.0
#include "import.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "block/plausibility.h"
#include "block_builder.h"
#include "bytes.h"
#include "csm.h"
#include "iceye.h"
#include "image.h"
#include "image_table.h"
#include "isis.h"
#include "sicd.h"
#include "sicd_image.h"
#include "terrasarx.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

void CheckOptions(const ImportOptions& options, std::size_t images) {
  const auto positive = [](const std::optional<double>& value, const char* name) {
    if (value && !(*value > 0.0 && std::isfinite(*value))) {
      throw InputError(name, fmt::format("must be a number above 0, got {}", *value));
    }
  };
  positive(options.grid_sigma_m, "grid-sigma-m");
  positive(options.corner_sigma_m, "corner-sigma-m");
  positive(options.reflector_sigma_m, "reflector-sigma-m");
  positive(options.range_sigma_m, "range-sigma-m");
  positive(options.azimuth_sigma_m, "azimuth-sigma-m");
  positive(options.path_sigma_m, "path-sigma-m");
  positive(options.max_misfit_m, "max-misfit-m");
  positive(options.orbit_margin_s, "orbit-margin-s");
  constexpr double kShortestStep_s = 0.01;
  if (options.orbit_step_s != 0.0 && !(options.orbit_step_s >= kShortestStep_s)) {
    throw InputError(
        "orbit-step-s",
        fmt::format("must be 0, or {1} or more, got {0}", options.orbit_step_s, kShortestStep_s));
  }
  if (images == 0) throw InputError("images", "none given, one or more are needed");
  if (!options.pass_ids.empty() && options.pass_ids.size() != images) {
    throw InputError(
        "id",
        fmt::format("{} ids for {} images, one each is needed", options.pass_ids.size(), images));
  }
  if (options.grid == PointRole::kControl && !options.grid_sigma_m) {
    throw InputError("grid-sigma-m",
                     "is missing, control points need the standard deviation of their position");
  }
  if (options.reflectors && options.reflector_role == PointRole::kControl &&
      !options.reflector_sigma_m) {
    throw InputError("reflector-sigma-m",
                     "is missing, control points need the standard deviation of their position");
  }
}

// Standard deviations of looks in metres, where they are given: asked for, or of the image itself.
struct GivenSigma {
  std::optional<double> range_m, azimuth_m;
};
GivenSigma GivenSigmaOf(const ImagePass& image, const ImportOptions& options) {
  return {options.range_sigma_m ? options.range_sigma_m : image.range_sigma_m,
          options.azimuth_sigma_m ? options.azimuth_sigma_m : image.azimuth_sigma_m};
}

// The given ones, or those of a row and a column, of range and Doppler in the middle of the image.
// A hertz is lambda R/(2 |v|) at the target.
LookSigma SigmaOfAperture(const ImagePass& image, const GivenSigma& given) {
  const SicdImage& sicd = image.aperture->sicd;
  const double hertz_per_mps = 2.0 / image.pass.wavelength_m;
  const auto pixel = SigmaOfPlace(sicd,
                                  0.5 * static_cast<double>(image.lines - 1),
                                  0.5 * static_cast<double>(image.samples - 1),
                                  kEvenly,
                                  kEvenly);
  const auto motion = image.pass.path.At(image.middle->time_s);
  if (!pixel || !motion) {
    throw InputError(sicd.PlaceOf("SICD.Grid"),
                     "range and range rate do not change in the middle of the image");
  }
  LookSigma sigma;
  sigma.range_m = given.range_m.value_or(pixel->range_m);
  const double rate_mps =
      given.azimuth_m ? *given.azimuth_m * motion->velocity_mps.norm() / image.middle->range_m
                      : pixel->range_rate_mps;
  sigma.azimuth = rate_mps * hertz_per_mps;
  sigma.azimuth_unit = AzimuthUnit::kHertz;
  return sigma;
}

// The given standard deviations, or those of a line and a pixel.
LookSigma SigmaOf(const ImagePass& image, const ImportOptions& options) {
  const GivenSigma given = GivenSigmaOf(image, options);
  if (image.aperture) return SigmaOfAperture(image, given);
  const ImageGrid& grid = *image.pass.image;
  LookSigma sigma;
  const auto pixel_m =
      image.middle ? SlantRangePerPixel_m(grid, *image.middle) : std::optional<double>();
  if (!given.range_m && !pixel_m) {
    throw InputError(FilePlace{image.file, 0, "range polynomials"},
                     "give no slant range in the middle of the image");
  }
  sigma.range_m = given.range_m ? *given.range_m : kEvenly * *pixel_m;
  if (given.azimuth_m) {
    sigma.azimuth = *given.azimuth_m;
  } else {
    sigma.azimuth = kEvenly * grid.line_interval_s;
    sigma.azimuth_unit = AzimuthUnit::kSeconds;
  }
  return sigma;
}

/// A point of a geolocation grid beside its fit.
struct GridPlace {
  std::string name;  ///< of the point, behind the id of its pass
  GridPoint point;   ///< without its delay
  std::size_t file_line = 0;
  std::optional<ImageCoordinates> pixel{};  ///< whose time and range it gives, where it says so
  LookDelay delay{};                        ///< that the product states
};

/// Where a product has its grid, for messages.
struct GridSource {
  std::string file;
  const char* time;  ///< the element or dataset of its times
};
template <typename Product>
GridSource GridSourceOf(const Product& product) {
  return {product.file, "geolocationGrid/zeroDopplerTime"};
}
GridSource GridSourceOf(const Sentinel1Product& product) {
  return {product.file, "geolocationGridPoint.azimuthTime"};
}
GridSource GridSourceOf(const TerraSarXProduct& product) {
  return {product.georef_file, "geoReference.geolocationGrid.gridPoint.t"};
}

/// Calls `row(line, same_time)` and `point(place)` for a product's grid, row by row.
template <typename Row, typename Point>
void ForGrid(const Sentinel1Product& product,
             const UtcTime& epoch,
             const Row& row,
             const Point& point) {
  const GeolocationGridPoint* before = nullptr;
  for (const GeolocationGridPoint& given : product.grid) {
    if (before == nullptr || before->line != given.line) {
      row(given.line, before != nullptr && SecondsBetween(before->time, given.time) == 0.0);
    }
    before = &given;
    point(GridPlace{
        fmt::format("{}:{}", given.line, given.pixel),
        {SecondsBetween(epoch, given.time), given.slant_range_m, given.place},
        given.file_line,
        ImageCoordinates{static_cast<double>(given.line), static_cast<double>(given.pixel)}});
  }
}

template <typename Row, typename Point>
void ForGrid(const NisarProduct& product,
             const UtcTime& epoch,
             const Row& row,
             const Point& point) {
  const NisarGrid& grid = product.grid;
  for (std::size_t i = 0; i < grid.time.size(); ++i) {
    const double line = SecondsBetween(product.first_line, grid.time[i]) / product.line_interval_s;
    constexpr double kFarthest = 1e9;
    row(static_cast<int>(std::lround(std::clamp(line, -kFarthest, kFarthest))),
        i > 0 && SecondsBetween(grid.time[i - 1], grid.time[i]) == 0.0);
    for (std::size_t h = 0; h < grid.height_m.size(); ++h) {
      for (std::size_t j = 0; j < grid.slant_range_m.size(); ++j) {
        const std::size_t k = grid.Index(h, i, j);
        point(GridPlace{fmt::format("{}:{}:{}", i + 1, j + 1, grid.height_m[h]),
                        {SecondsBetween(epoch, grid.time[i]),
                         grid.slant_range_m[j],
                         {grid.latitude_deg[k] * kRadPerDeg,
                          grid.longitude_deg[k] * kRadPerDeg,
                          grid.height_m[h]}},
                        0});
      }
    }
  }
}

template <typename Row, typename Point>
void ForGrid(const TerraSarXProduct& product,
             const UtcTime& epoch,
             const Row& row,
             const Point& point) {
  const TerraSarXGridPoint* before = nullptr;
  for (const TerraSarXGridPoint& given : product.grid) {
    if (before == nullptr || before->azimuth_index != given.azimuth_index) {
      const double line = SecondsBetween(product.first_line, given.time) / product.line_interval_s;
      row(static_cast<int>(std::lround(line)),
          before != nullptr && SecondsBetween(before->time, given.time) == 0.0);
    }
    before = &given;
    const LookDelay delay = product.effects.At(given.range_m);
    point(GridPlace{fmt::format("{}:{}", given.azimuth_index, given.range_index),
                    {SecondsBetween(epoch, given.time) - delay.time_s,
                     given.range_m - delay.range_m,
                     given.place},
                    given.file_line,
                    std::nullopt,
                    delay});
  }
}

// The scene centre point, which the metadata place in the image and on the ground.
template <typename Row, typename Point>
void ForGrid(const SicdImage& image, const UtcTime& epoch, const Row& row, const Point& point) {
  row(static_cast<int>(image.centre_column_px - image.first_column_px), false);
  const SicdPoint centre = CentreOfSicd(image, SecondsBetween(epoch, image.start));
  point(GridPlace{centre.name, centre.point, 0});
}

template <typename Row, typename Point>
void ForGrid(const IceyeProduct& /*image*/,
             const UtcTime& /*epoch*/,
             const Row& /*row*/,
             const Point& /*point*/) {}

template <typename Row, typename Point>
void ForGrid(const RadarImage& /*image*/,
             const UtcTime& /*epoch*/,
             const Row& /*row*/,
             const Point& /*point*/) {}

/// Corners are approximate and never a fault.
constexpr double kAnyMisfit_m = 1e9;

/// Collects what all images add to the block.
class Importer {
 public:
  Importer(const std::vector<SensorImage>& images,
           const std::vector<OrbitFile>& orbits,
           const ImportOptions& options)
      : orbits_(orbits), options_(options), builder_(options.name) {
    all_orbits_used_ = std::all_of(orbits.begin(), orbits.end(), [&](const OrbitFile& orbit) {
      return std::any_of(images.begin(), images.end(), [&](const SensorImage& image) {
        const auto* const product = std::get_if<Sentinel1Product>(&image);
        return product != nullptr && Covers(orbit, *product);
      });
    });
  }

  void Add(const Sentinel1Product& product, const std::string& id) {
    const bool covered = std::any_of(orbits_.begin(), orbits_.end(), [&](const OrbitFile& orbit) {
      return Covers(orbit, product);
    });
    // A file that is of no image is a mistake, which PassOfSentinel1() names.
    const bool annotated = !covered && all_orbits_used_;
    if (annotated && !orbits_.empty()) {
      result_.warnings.push_back(product.file +
                                 ": no orbit file covers it, its annotated orbit is taken");
    }
    if (annotated && product.orbit_source == kOnBoard) {
      result_.warnings.push_back(
          product.file +
          ": its orbit was determined on board (Downlink) and is a metre or two off along track: "
          "its "
          "geolocation grid is no control; an orbit file (--orbit) takes its place");
    }
    Add(product,
        PassOfSentinel1(
            product, annotated ? std::vector<OrbitFile>() : orbits_, options_, &result_.warnings),
        product.orbit_source,
        id);
  }
  void Add(const NisarProduct& product, const std::string& id) {
    Add(product, PassOfNisar(product, options_, &result_.warnings), product.orbit_type, id);
  }
  void Add(const TerraSarXProduct& given, const std::string& id) {
    TerraSarXProduct product = given;
    if (!options_.reduce) product.effects = {};
    Add(product, PassOfTerraSarX(product, options_, &result_.warnings), product.orbit_accuracy, id);
    const std::string effects = Describe(product.effects);
    if (!effects.empty()) {
      result_.products.back().stated = "taken off its looks, as the product states: " + effects;
    }
  }
  void Add(const IceyeProduct& product, const std::string& id) {
    std::string stated;
    ImagePass pass = PassOfIceye(product, options_, &result_.warnings, &stated);
    Add(product, std::move(pass), product.orbit_level, id);
    result_.products.back().stated = std::move(stated);
  }
  void Add(const SicdImage& image, const std::string& id) {
    ImagePass pass = PassOfSicd(image);
    if (!id.empty()) pass.pass.id = id;
    const SicdPriors priors = PriorsOfSicd(image, pass);
    if (image.errors) {
      pass.range_sigma_m = image.errors->row_sigma_m;
      pass.azimuth_sigma_m = image.errors->column_sigma_m;
    }
    Add(image,
        std::move(pass),
        image.offsets ? "ARPPoly with its AdjustableParameterOffsets" : "ARPPoly",
        "");
    result_.products.back().priors = priors.says;
    const auto append = [](const auto& from, auto* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    append(priors.corrections, &result_.corrections);
    append(priors.priors, &result_.priors);
    append(priors.warnings, &result_.warnings);
    if (options_.corner_sigma_m) AddCorners(image);
  }
  void Add(const RadarImage& image, const std::string& id) {
    Add(image, PassOfRadarImage(image, RangePolynomialTimes::kGiven), "", id);
  }

  ImportedBlock Finish() {
    if (options_.reflectors) AddReflectors();
    if (options_.points) {
      builder_.AddMatches(*options_.points);
      CountMatches();
    }
    for (std::size_t i = 0; i < result_.products.size(); ++i) {
      result_.products[i].delays = builder_.Delays()[i];
    }
    result_.block = builder_.Finish();
    ShareFlights();
    for (std::string& remark : FindSameFlights(result_.block, [this](std::size_t a, std::size_t b) {
           return take_of_[a] != kNoTake && take_of_[a] == take_of_[b];
         })) {
      result_.warnings.push_back(std::move(remark));
    }
    return std::move(result_);
  }

 private:
  template <typename Product>
  void Add(const Product& product,
           ImagePass image,
           const std::string& orbit_source,
           const std::string& id) {
    if (!id.empty()) image.pass.id = id;
    const UtcTime first_line = image.first_line;
    image.pass.sigma = SigmaOf(image, options_);
    ImportedProduct summary{
        .file = image.file, .pass = image.pass.id, .orbit_source = orbit_source};
    summary.orbit_file = image.orbit_file;
    const std::vector<GridFit> fits = FitGrid(product, &image.pass, first_line, &summary);
    AttachTiming(product, fits, &image);
    const std::uint32_t pass = builder_.AddImage(std::move(image));
    first_lines_.push_back(first_line);
    result_.products.push_back(std::move(summary));
    if (options_.grid) AddGrid(product, pass, first_line, fits);
  }

  // Holds the grid against the path. The fits are kept where they become looks.
  template <typename Product>
  std::vector<GridFit> FitGrid(const Product& product,
                               Pass* pass,
                               const UtcTime& first_line,
                               ImportedProduct* summary) {
    // A grid is that of the Earth's ellipsoid.
    const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
    const GridSource source = GridSourceOf(product);
    FaultyRows rows(source.file);
    std::vector<GridFit> fits;
    std::vector<bool> trusted;  // time and position agree
    std::vector<double> late_s;
    std::size_t left = 0;
    ForGrid(
        product,
        WholeSecond(first_line),
        [&](int line, bool same_time) { rows.Begin(line, same_time); },
        [&](const GridPlace& place) {
          const auto fit = FitGridPoint(place.point, earth, pass->path, options_.max_misfit_m);
          if (!fit) FailOutside(source, *pass, place);
          rows.Add(*fit, place.file_line);
          Count(*fit, summary);
          trusted.push_back(fit->fault != GridFault::kPosition);
          if (!trusted.back()) AppendLateness(place.point, *fit, *pass, &late_s);
          left += fit->side == LookSide::kLeft ? 1U : 0U;
          if (options_.grid || place.pixel) fits.push_back(*fit);
        });
    if (summary->good > 0) summary->mean_along_m /= static_cast<double>(summary->good);
    if (summary->grid_points > 0 && late_s.size() == summary->grid_points) {
      RefuseOtherClock(*summary, std::move(late_s));
    }
    HoldRaster(product, trusted);
    for (FaultyRow& row : rows.Take()) {
      row.used = options_.grid.has_value();
      result_.faults.push_back(std::move(row));
    }
    if (summary->grid_points > 0) SetSide(product, 2 * left > summary->grid_points, pass);
    return fits;
  }

  // By how much later the path sees a grid point than its time says.
  static void AppendLateness(const GridPoint& point,
                             const GridFit& fit,
                             const Pass& pass,
                             std::vector<double>* late_s) {
    const auto seen_s =
        FindConeTime(pass.path, fit.position_m, point.cone, pass.path.start_s(), pass.path.end_s());
    if (seen_s) late_s->push_back(*seen_s - point.time_s);
  }

  // Where all points are seen later by the same time, the times are those of another clock.
  static void RefuseOtherClock(const ImportedProduct& summary, std::vector<double> late_s) {
    constexpr std::size_t kFewest = 4;
    constexpr double kAlike_s = 0.01;
    const auto [least, most] = std::minmax_element(late_s.begin(), late_s.end());
    if (late_s.size() < kFewest || *most - *least > kAlike_s) return;
    const double all_s = Median(std::move(late_s));
    constexpr double kGpsFrom_s = 13.0, kGpsTo_s = 18.0;  // ahead of UTC, 1999 to 2017 and later
    const double whole_s = std::abs(std::round(all_s));
    const bool gps = std::abs(std::abs(all_s) - whole_s) < kAlike_s && whole_s >= kGpsFrom_s &&
                     whole_s <= kGpsTo_s;
    const bool given = !summary.orbit_file.empty();
    throw InputError(
        FilePlace{given ? summary.orbit_file : summary.file, 0, "orbit"},
        fmt::format(
            "sees all {} grid points{} {:.3f} s {} than their azimuthTime: its times must be "
            "UTC{}",
            summary.grid_points,
            given ? " of " + summary.file : "",
            std::abs(all_s),
            all_s > 0.0 ? "later" : "earlier",
            gps ? fmt::format(", and GPS time differs from UTC by {:.0f} s", whole_s) : ""));
  }

  // What stays in the times and ranges of the image although it was to be taken off is a warning.
  void AttachTiming(const Sentinel1Product& product,
                    const std::vector<GridFit>& fits,
                    ImagePass* image) {
    if (!options_.reduce) return;
    std::vector<double> heights_m;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      heights_m.push_back(product.grid[i].place.h_m + fits[i].height_change_m);
    }
    auto timing =
        std::make_shared<const Sentinel1Timing>(TimingOfSentinel1(product, image->pass, heights_m));
    if (!timing->left_out().empty()) {
      result_.warnings.push_back(product.file +
                                 ": stays in its times and ranges: " + timing->left_out());
    }
    image->timing = std::move(timing);
  }
  template <typename Product>
  static void AttachTiming(const Product& /*product*/,
                           const std::vector<GridFit>& /*fits*/,
                           ImagePass* /*image*/) {}

  static void HoldRaster(const Sentinel1Product& product, const std::vector<bool>& trusted) {
    RequireRasterOfGrid(product, trusted);
  }
  template <typename Product>
  static void HoldRaster(const Product& /*product*/, const std::vector<bool>& /*trusted*/) {}

  [[noreturn]] static void FailOutside(const GridSource& source,
                                       const Pass& pass,
                                       const GridPlace& place) {
    throw InputError(
        FilePlace{source.file, place.file_line, source.time},
        fmt::format("{:.6f} s after {} is outside the orbit, which goes from {:.6f} to {:.6f} s",
                    place.point.time_s,
                    pass.epoch_utc,
                    pass.path.start_s(),
                    pass.path.end_s()));
  }

  // The corners of the image added last, known as well as the option says.
  void AddCorners(const SicdImage& image) {
    const auto pass = static_cast<std::uint32_t>(builder_.block().passes.size() - 1);
    const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
    ImportedProduct& summary = result_.products.back();
    const double start_s = SecondsBetween(WholeSecond(first_lines_.back()), image.start);
    for (const SicdPoint& corner : CornersOfSicd(image, start_s)) {
      const auto fit =
          FitGridPoint(corner.point, earth, builder_.block().passes[pass].path, kAnyMisfit_m);
      if (!fit) {
        throw InputError(image.PlaceOf("SICD.GeoData.ImageCorners"),
                         corner.name + " has a time outside the path");
      }
      ++summary.corners;
      summary.corner_range_m = std::max(summary.corner_range_m, std::abs(fit->range_error_m));
      summary.corner_along_m = std::max(summary.corner_along_m, std::abs(fit->along_error_m));
      AddPlace(
          pass, {corner.name, corner.point, 0}, *fit, PointRole::kCheck, options_.corner_sigma_m);
    }
  }

  // One set of path errors for the images of each flight, unless they brought their own.
  void ShareFlights() {
    take_of_.assign(result_.block.passes.size(), kNoTake);
    for (const std::vector<std::size_t>& flight : FindFlights(result_.block)) {
      DataTake take;
      bool on_board = false, own = false;
      for (const std::size_t i : flight) {
        const std::string& id = result_.block.passes[i].id;
        take.passes.push_back(id);
        const ImportedProduct& product = result_.products[i];
        on_board = on_board || (product.orbit_file.empty() && product.orbit_source == kOnBoard);
        own = own || std::any_of(result_.corrections.begin(),
                                 result_.corrections.end(),
                                 [&](const CorrectionGroup& group) {
                                   return std::holds_alternative<PositionCorrection>(group.model) &&
                                          group.passes.front() == id;
                                 });
      }
      take.repeated = RejectRepeated(flight);
      if (take.repeated > 0) {
        result_.warnings.push_back(fmt::format(
            "{} looks at pixels that another polarisation of the same image has too are rejected: "
            "they are no independent measurements",
            take.repeated));
      }
      if (own) continue;
      take.path_sigma_m = options_.path_sigma_m.value_or(on_board ? ImportOptions::kOnBoardSigma_m
                                                                  : ImportOptions::kPathSigma_m);
      PositionCorrection position;
      position.prior_sigma_m.fill({take.path_sigma_m});
      for (const std::size_t i : flight) take_of_[i] = result_.takes.size();
      result_.corrections.push_back({"position", position, take.passes, true});
      result_.takes.push_back(std::move(take));
    }
  }

  // Polarisations: one raster.
  [[nodiscard]] bool SameRaster(std::size_t a, std::size_t b) const {
    const Pass &one = result_.block.passes[a], &other = result_.block.passes[b];
    if (!one.image || !other.image) return false;
    const ImageGrid &first = *one.image, &second = *other.image;
    constexpr double kSame = 0.5;  // pixels
    return first.presentation == second.presentation &&
           std::abs(SecondsBetween(first_lines_[a], first_lines_[b])) <
               kSame * first.line_interval_s &&
           std::abs(first.near_range_m - second.near_range_m) < kSame * first.range_spacing_m &&
           first.range_spacing_m == second.range_spacing_m &&
           first.line_interval_s == second.line_interval_s &&
           one.wavelength_m == other.wavelength_m;
  }

  // Rejects the looks of a point at a pixel that it has been seen at already; their number.
  std::size_t RejectRepeated(const std::vector<std::size_t>& flight) {
    Looks& looks = result_.block.looks;
    std::size_t rejected = 0;
    for (std::size_t point = 0; point + 1 < looks.offsets.size(); ++point) {
      for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
        for (std::size_t j = looks.offsets[point]; j < i; ++j) {
          const std::size_t a = looks.pass[j], b = looks.pass[i];
          if (looks.rejected(i) || looks.rejected(j) || a == b ||
              !std::binary_search(flight.begin(), flight.end(), a) ||
              !std::binary_search(flight.begin(), flight.end(), b) || !SameRaster(a, b)) {
            continue;
          }
          looks.flags[i] |= Looks::kRejected;
          ++rejected;
        }
      }
    }
    return rejected;
  }

  static void Count(const GridFit& fit, ImportedProduct* summary) {
    ++summary->grid_points;
    if (fit.fault) return;
    ++summary->good;
    summary->largest_range_m = std::max(summary->largest_range_m, std::abs(fit.range_error_m));
    summary->largest_along_m = std::max(summary->largest_along_m, std::abs(fit.along_error_m));
    summary->mean_along_m += fit.along_error_m;
  }

  void SetSide(const Sentinel1Product& /*product*/, bool left, Pass* pass) {
    pass->side = left ? LookSide::kLeft : LookSide::kRight;
  }
  void SetSide(const ZeroDopplerImage& product, bool left, Pass* pass) {
    if (left == (pass->side == LookSide::kLeft)) return;
    result_.warnings.push_back(fmt::format(
        "{}: lookDirection is {}, but the geolocation grid lies to the {} of the flight",
        product.file,
        left ? "right" : "left",
        left ? "left" : "right"));
  }
  // The scene centre is one point, which the metadata place exactly.
  static void SetSide(const SicdImage& image, bool left, Pass* pass) {
    if (left == (pass->side == LookSide::kLeft)) return;
    throw InputError(image.PlaceOf("SICD.SCPCOA.SideOfTrack"),
                     fmt::format("must be {}, the side of the flight on which the scene centre "
                                 "point (GeoData.SCP) is, got {}",
                                 left ? "L" : "R",
                                 left ? "R" : "L"));
  }
  void SetSide(const RadarImage& /*image*/, bool /*left*/, Pass* /*pass*/) {}

  template <typename Product>
  void AddGrid(const Product& product,
               std::uint32_t pass,
               const UtcTime& first_line,
               const std::vector<GridFit>& fits) {
    std::size_t i = 0;
    ForGrid(
        product,
        WholeSecond(first_line),
        [](int, bool) {},
        [&](const GridPlace& place) {
          AddPlace(pass, place, fits[i++], *options_.grid, options_.grid_sigma_m);
        });
  }

  void AddPlace(std::uint32_t pass,
                const GridPlace& place,
                const GridFit& fit,
                PointRole role,
                const std::optional<double>& sigma_m) {
    const std::string id = builder_.block().passes[pass].id + ":" + place.name;
    const auto point = builder_.AddPoint(id);
    if (!point) throw InputError("id", "'" + id + "' would be the name of two grid points");
    const bool wrong_height = fit.fault == GridFault::kHeight;
    const bool known = role != PointRole::kTie && (!wrong_height || sigma_m);
    const bool usable = known || (!fit.fault && role == PointRole::kTie);
    NewLook look{.point = *point, .pass = pass};
    look.flags = fit.fault == GridFault::kPosition ? Looks::kRejected : 0;
    look.time_shift_s = place.delay.time_s;
    look.range_delay_m = place.delay.range_m;
    look.time_s = place.point.time_s + place.delay.time_s;
    look.range_m = place.point.range_m + place.delay.range_m;
    if (place.point.cone.kind == Cone::Kind::kDoppler) {
      look.doppler_hz =
          2.0 * place.point.cone.closing_mps / builder_.block().passes[pass].wavelength_m;
    }
    if (place.pixel) builder_.SetDelays(*place.pixel, std::nullopt, &look);
    // A product that states its delays has placed its grid without them.
    const bool reduced = place.delay.range_m != 0.0 || place.delay.time_s != 0.0;
    if (usable) builder_.SetPosition(*point, reduced ? fit.position_m : Moved(look, fit));
    if (known) {
      builder_.SetKnown(role,
                        EquallyKnown(*point, {true, true, !wrong_height}, sigma_m.value_or(0.0)));
    }
    builder_.AddLook(look);
  }

  // Where the ground of a grid point is. The product placed it by its time and range as they are
  // measured; without their delays the same look sees another place of that height.
  Eigen::Vector3d Moved(const NewLook& look, const GridFit& fit) {
    const RadarCoordinates measured{look.time_s, look.range_m};
    const RadarCoordinates geometric = builder_.GeometricOf(look, fit.position_m);
    if (geometric.time_s == measured.time_s && geometric.range_m == measured.range_m) {
      return fit.position_m;
    }
    const Pass& pass = builder_.block().passes[look.pass];
    const double h_m = builder_.frame().GeodeticFromFrame(fit.position_m).h_m + fit.height_change_m;
    const auto ground = [&](const RadarCoordinates& radar) {
      return GroundOf(pass.path, fit.side, builder_.frame(), radar, h_m);
    };
    const auto before_m = ground(measured);
    auto after_m = before_m;
    for (int step = 0; after_m && step < 2; ++step) {
      after_m = ground(builder_.GeometricOf(look, *after_m));
    }
    if (!after_m) return fit.position_m;
    const Eigen::Vector3d move_m = *after_m - *before_m;
    result_.products[look.pass].grid_move_m.Add(move_m.norm());
    return fit.position_m + move_m;
  }

  // Only those that are measured, where it is known which are.
  void AddReflectors() {
    std::set<std::string> measured;
    if (options_.points) {
      for (const MatchedPoint& row : options_.points->rows) measured.insert(row.point);
    }
    const SeenReflectors seen =
        ReflectorsInImages(*options_.reflectors, first_lines_, &builder_, &result_.warnings);
    for (const SeenReflector& reflector : seen.reflectors) {
      if (options_.points && !measured.contains(reflector.id)) continue;
      const auto point = builder_.AddPoint(reflector.id);
      if (!point)
        throw InputError("reflectors", "'" + reflector.id + "' is the name of a grid point");
      builder_.SetPosition(*point, reflector.position_m);
      builder_.SetKnown(
          options_.reflector_role,
          EquallyKnown(*point, {true, true, true}, options_.reflector_sigma_m.value_or(0.0)));
      for (const auto& [pass, place] : reflector.places) {
        const std::array<double, 2> origin_px =
            options_.points ? options_.points->origin_px : std::array<double, 2>{};
        result_.reflectors.push_back(
            {reflector.id, pass, place.line_px + origin_px[0], place.pixel_px + origin_px[1]});
      }
    }
    for (const auto& [id, why] : seen.left_out) {
      if (measured.contains(id)) {
        result_.warnings.push_back(options_.reflectors->file + ": " + id +
                                   " is measured but left as a tie point: " + why);
      }
    }
  }

  void CountMatches() {
    const MatchedPoints& points = *options_.points;
    const std::vector<std::size_t> matches = builder_.MatchCounts();
    const std::vector<PixelOffset> offsets = builder_.MatchOffsets();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      result_.products[i].matches = matches[i];
      result_.products[i].offset = offsets[i];
    }
    for (const std::string& warning : points.warnings) result_.warnings.push_back(warning);
    for (std::string& remark :
         NameOffsets(builder_.block(), offsets, points.origin_px, points.file, "--points-origin")) {
      result_.warnings.push_back(std::move(remark));
    }
  }

  static constexpr const char* kOnBoard = "Downlink";
  static constexpr std::size_t kNoTake = std::numeric_limits<std::size_t>::max();

  const std::vector<OrbitFile>& orbits_;
  const ImportOptions& options_;
  bool all_orbits_used_ = false;
  BlockBuilder builder_;
  ImportedBlock result_;
  std::vector<UtcTime> first_lines_;
  std::vector<std::size_t> take_of_;  // by pass
};

}  // namespace

ImportedBlock ImportProducts(const std::vector<SensorImage>& images,
                             const std::vector<OrbitFile>& orbits,
                             const ImportOptions& options) {
  CheckOptions(options, images.size());
  Importer importer(images, orbits, options);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string id = options.pass_ids.empty() ? "" : options.pass_ids[i];
    std::visit([&](const auto& image) { importer.Add(image, id); }, images[i]);
  }
  return importer.Finish();
}

namespace {

std::string ReadXml(const std::string& file) {
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 30U;
  ByteSource source = ByteSource::FromFile(file);
  if (source.size() > kLargest) {
    throw InputError(FilePlace{file, 0, ""}, "is larger than 1 GiB, which no such file is");
  }
  return source.Read(0, source.size(), "text");
}

// The first characters, without a byte order mark and blanks.
std::string FrontOf(const std::string& file) {
  constexpr std::uint64_t kFront = 256;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf", kBlanks = " \t\r\n";
  ByteSource source = ByteSource::FromFile(file);
  std::string front = source.Read(0, std::min(kFront, source.size()), "text");
  if (front.starts_with(kByteOrderMark)) front.erase(0, kByteOrderMark.size());
  front.erase(0, std::min(front.size(), front.find_first_not_of(kBlanks)));
  return front;
}

}  // namespace

Sentinel1Product ReadSentinel1(const std::string& file, const Sentinel1Use& use) {
  return ParseSentinel1(ReadXml(file), file, use);
}

TerraSarXProduct ReadTerraSarX(const std::string& file) {
  namespace fs = std::filesystem;
  TerraSarXProduct product = ParseTerraSarX(ReadXml(file), file);
  const fs::path folder = fs::path(file).parent_path();
  for (const fs::path& georef : {folder / "ANNOTATION" / "GEOREF.xml", folder / "GEOREF.xml"}) {
    if (!fs::exists(georef)) continue;
    AddGeoref(ReadXml(georef.string()), georef.string(), &product);
    break;
  }
  return product;
}

IceyeProduct ReadIceye(const std::string& file) { return ParseIceye(ReadXml(file), file); }

OrbitFile ReadOrbitFile(const std::string& file) { return ParseOrbitFile(ReadXml(file), file); }

SensorImage ReadSensorImage(const std::string& file,
                            NisarFrequency frequency,
                            const Sentinel1Use& use) {
  const std::string front = FrontOf(file);
  if (front.starts_with("\x89HDF")) return ReadNisar(file, frequency, use.grid);
  if (front.starts_with("NITF") || front.starts_with("NSIF")) return ReadSicd(file);
  if (front.starts_with("<")) {
    if (front.find("<SICD") != std::string::npos) return ReadSicd(file);
    if (front.find("<level1Product") != std::string::npos) return ReadTerraSarX(file);
    if (front.find("<Metadata") != std::string::npos) return ReadIceye(file);
    return ReadSentinel1(file, use);
  }
  if (front.starts_with("{") || front.starts_with(kCsmModelName)) return ReadCsmIsd(file);
  if (front.starts_with("Object")) return ReadIsisCube(file);
  throw InputError(
      FilePlace{file, 0, ""},
      "is no image that is read: an annotation of Sentinel-1 or TerraSAR-X or metadata of ICEYE "
      "(XML), an "
      "RSLC of NISAR (HDF5), a SICD image (NITF, XML), a cube of ISIS or an ISD (JSON) is needed");
}

}  // namespace sarblock
