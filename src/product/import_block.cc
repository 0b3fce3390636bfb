// SPDX-License-Identifier: Apache-2.0
#include "sarblock/product/import_block.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "flight/resample.h"
#include "flight/state_noise.h"
#include "grid_fit.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Above it positions and velocities tell two stories: 1 mm/s of 7500 m/s turns the Doppler plane
/// by 0.1 m at 900 km.
constexpr double kContradiction_mps = 1e-3;

const double kEvenly = 1.0 / std::sqrt(12.0);  // standard deviation of one step, evenly spread

void CheckOptions(const ImportOptions& options, std::size_t products) {
  const auto positive = [](const std::optional<double>& value, const char* name) {
    if (value && !(*value > 0.0 && std::isfinite(*value))) {
      throw InputError(name, fmt::format("{} is not allowed, a number above 0 is", *value));
    }
  };
  positive(options.grid_sigma_m, "grid-sigma-m");
  positive(options.range_sigma_m, "sigma-range-m");
  positive(options.azimuth_sigma_m, "sigma-azimuth-m");
  positive(options.max_misfit_m, "max-misfit-m");
  positive(options.orbit_margin_s, "orbit-margin-s");
  constexpr double kShortestStep_s = 0.01;
  if (options.orbit_step_s != 0.0 && !(options.orbit_step_s >= kShortestStep_s)) {
    throw InputError(
        "orbit-step-s",
        fmt::format(
            "{} is not allowed, 0 or {} and more is", options.orbit_step_s, kShortestStep_s));
  }
  if (products == 0) throw InputError("products", "none given, one or more are needed");
  if (!options.pass_ids.empty() && options.pass_ids.size() != products) {
    throw InputError(
        "id",
        fmt::format(
            "{} ids for {} products, one each is needed", options.pass_ids.size(), products));
  }
  if (options.grid == PointRole::kControl && !options.grid_sigma_m) {
    throw InputError("grid-sigma-m",
                     "is missing, control points need the standard deviation of their position");
  }
}

std::string PassId(const Sentinel1Product& product) {
  std::string time = UtcText(product.first_line);
  std::erase_if(time, [](char c) { return c == '-' || c == ':' || c == 'Z'; });
  return product.mission + "_" + product.swath + "_" + product.polarisation + "_" + time;
}

// S1A of an annotation and Sentinel-1A of an orbit file name the same satellite.
bool SameMission(const std::string& product, const std::string& orbit) {
  return !product.empty() && !orbit.empty() &&
         (product == orbit || (orbit.starts_with("Sentinel-") && product == "S" + orbit.substr(9)));
}

/// Times of the product's image and grid, from its epoch.
struct Span {
  double start_s = 0.0, end_s = 0.0;
};
Span SpanOf(const Sentinel1Product& product, const UtcTime& epoch) {
  Span span{SecondsBetween(epoch, product.first_line), SecondsBetween(epoch, product.last_line)};
  for (const GeolocationGridPoint& point : product.grid) {
    span.start_s = std::min(span.start_s, SecondsBetween(epoch, point.time));
    span.end_s = std::max(span.end_s, SecondsBetween(epoch, point.time));
  }
  return span;
}

std::vector<StateVector> StatesFrom(const std::vector<OrbitState>& states, const UtcTime& epoch) {
  std::vector<StateVector> result;
  for (const OrbitState& state : states) {
    result.push_back({SecondsBetween(epoch, state.time), state.position_m, state.velocity_mps});
  }
  return result;
}

// States of the first orbit file of the mission that covers the product, with margin as far as it
// goes.
std::vector<StateVector> StatesOfFiles(const std::vector<OrbitFile>& orbits,
                                       const Sentinel1Product& product,
                                       const UtcTime& epoch,
                                       double margin_s) {
  const Span span = SpanOf(product, epoch);
  for (const OrbitFile& orbit : orbits) {
    if (!SameMission(product.mission, orbit.mission)) continue;
    std::vector<StateVector> states = StatesFrom(orbit.states, epoch);
    if (states.front().time_s > span.start_s || states.back().time_s < span.end_s) continue;
    const auto from = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s >= span.start_s - margin_s;
    });
    const auto to = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s > span.end_s + margin_s;
    });
    // One state more on both sides: the span with its margin then lies inside the path.
    return {from == states.begin() ? from : from - 1, to == states.end() ? to : to + 1};
  }
  std::string files;
  for (const OrbitFile& orbit : orbits) {
    files += fmt::format("{}{} ({}, {} to {})",
                         files.empty() ? "" : "; ",
                         orbit.file,
                         orbit.mission,
                         UtcText(orbit.states.front().time),
                         UtcText(orbit.states.back().time));
  }
  throw InputError(FilePlace{product.file, 0, "orbit"},
                   fmt::format("no orbit file covers this product ({}, {} to {}); given: {}",
                               product.mission,
                               UtcText(product.first_line),
                               UtcText(product.last_line),
                               files));
}

// States 5 minutes apart leave the polynomial of degree 7 some 6 mm from a low orbit; farther ones
// no longer tell where the satellite was.
void RefuseGaps(const std::string& file, const std::vector<StateVector>& states) {
  constexpr double kLongest_s = 300.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double gap_s = states[k].time_s - states[k - 1].time_s;
    if (gap_s <= kLongest_s) continue;
    throw InputError(FilePlace{file, 0, "orbit"},
                     fmt::format("states {} and {} are {} s apart, {} s at most is allowed",
                                 k,
                                 k + 1,
                                 gap_s,
                                 kLongest_s));
  }
}

ImageGrid ImageOf(const Sentinel1Product& product, const UtcTime& epoch) {
  ImageGrid image;
  image.presentation = product.presentation;
  image.first_line_s = SecondsBetween(epoch, product.first_line);
  image.line_interval_s = product.line_interval_s;
  image.near_range_m = product.near_range_m;
  image.range_spacing_m = product.range_spacing_m;
  for (const ProductGroundRange& polynomial : product.ground_range) {
    image.ground_range.push_back(
        {SecondsBetween(epoch, polynomial.time), polynomial.origin_m, polynomial.coefficients});
  }
  for (const UtcTime& burst : product.bursts) {
    image.burst_start_s.push_back(SecondsBetween(epoch, burst));
  }
  image.lines_per_burst = static_cast<std::size_t>(product.lines_per_burst);
  return image;
}

// The given standard deviations, or those of a line and a pixel.
LookSigma SigmaOf(const Sentinel1Product& product,
                  const ImageGrid& image,
                  double mid_time_s,
                  const ImportOptions& options) {
  LookSigma sigma;
  const double mid_range_m = product.grid[product.grid.size() / 2].slant_range_m;
  const auto pixel_m = SlantRangePerPixel_m(image, {mid_time_s, mid_range_m});
  if (!options.range_sigma_m && !pixel_m) {
    throw InputError(FilePlace{product.file, 0, "grsrCoefficients"},
                     "give no ground range to the grid's slant ranges");
  }
  sigma.range_m = options.range_sigma_m ? *options.range_sigma_m : kEvenly * *pixel_m;
  if (options.azimuth_sigma_m) {
    sigma.azimuth = *options.azimuth_sigma_m;
  } else {
    sigma.azimuth = kEvenly * image.line_interval_s;
    sigma.azimuth_unit = AzimuthUnit::kSeconds;
  }
  return sigma;
}

LookSide SideOfMost(const std::vector<GridFit>& fits) {
  const auto left = std::count_if(
      fits.begin(), fits.end(), [](const GridFit& fit) { return fit.side == LookSide::kLeft; });
  return 2 * left > static_cast<std::ptrdiff_t>(fits.size()) ? LookSide::kLeft : LookSide::kRight;
}

/// Collects what all products add to the block.
class Importer {
 public:
  Importer(const std::vector<OrbitFile>& orbits, const ImportOptions& options)
      : orbits_(orbits), options_(options) {
    result_.block.name = options.name;
    result_.block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  }

  void Add(const Sentinel1Product& product, const std::string& id) {
    const UtcTime epoch = WholeSecond(product.first_line);
    Pass pass;
    pass.id = id;
    for (const Pass& other : result_.block.passes) {
      if (other.id != id) continue;
      throw InputError(FilePlace{product.file, 0, "id"},
                       "'" + id + "' is the id of another product too, give ids of your own");
    }
    pass.epoch_utc = UtcText(epoch);
    pass.wavelength_m = product.wavelength_m;
    pass.path = PathOf(product, epoch);
    pass.image = ImageOf(product, epoch);
    CheckImageGrid(*pass.image);
    const std::vector<GridFit> fits =
        FitGrid(product, result_.block.frame, pass.path, epoch, options_.max_misfit_m);
    pass.side = SideOfMost(fits);
    pass.sigma = SigmaOf(product, *pass.image, fits[fits.size() / 2].time_s, options_);
    const Span span = SpanOf(product, epoch);
    spans_s_.push_back(std::array{span.start_s, span.end_s});
    const auto index = static_cast<std::uint32_t>(result_.block.passes.size());
    for (std::size_t i = 0; i < fits.size(); ++i) {
      AddGridPoint(index, id, product.grid[i], fits[i]);
    }
    Summarise(product, id, fits);
    result_.block.passes.push_back(std::move(pass));
  }

  ImportedBlock Finish() {
    Block& block = result_.block;
    SortLooksByPoint(point_of_look_, block.points.size(), &block.looks);
    SetStripSpans(spans_s_, &block);
    return std::move(result_);
  }

 private:
  FlightPath PathOf(const Sentinel1Product& product, const UtcTime& epoch) {
    const std::vector<StateVector> states =
        orbits_.empty() ? StatesFrom(product.orbit, epoch)
                        : StatesOfFiles(orbits_, product, epoch, options_.orbit_margin_s);
    RefuseGaps(product.file, states);
    const double contradiction_mps = LargestContradiction_mps(states);
    const bool through_states = options_.through == OrbitThrough::kStates;
    if (through_states && contradiction_mps > kContradiction_mps) {
      result_.warnings.push_back(
          fmt::format("{}: velocities of the orbit differ from the motion of its positions by up "
                      "to {:.4f} m/s; "
                      "the path swings between the states, --orbit-through positions avoids it",
                      product.file,
                      contradiction_mps));
    }
    if (options_.orbit_step_s == 0.0) return FlightPath(states);
    return FlightPath(ResampleOrbit(states, options_.orbit_step_s, options_.through));
  }

  void AddGridPoint(std::uint32_t pass,
                    const std::string& pass_id,
                    const GeolocationGridPoint& grid_point,
                    const GridFit& fit) {
    Points& points = result_.block.points;
    Looks& looks = result_.block.looks;
    const auto point = static_cast<std::uint32_t>(points.size());
    points.ids.Append(fmt::format("{}:{}:{}", pass_id, grid_point.line, grid_point.pixel));
    const bool wrong_height = fit.fault == GridFault::kHeight;
    const bool known = options_.grid != PointRole::kTie && (!wrong_height || options_.grid_sigma_m);
    points.role.push_back(known ? options_.grid : PointRole::kTie);
    const bool usable = known || (!fit.fault && options_.grid == PointRole::kTie);
    points.given_m.push_back(usable ? fit.position_m
                                    : Eigen::Vector3d(Eigen::Vector3d::Constant(kNotGiven)));
    if (known) {
      KnownPosition position{point, {true, true, !wrong_height}, Eigen::Matrix3d::Zero()};
      const double sigma_m = options_.grid_sigma_m.value_or(0.0);
      for (Eigen::Index k = 0; k < 3; ++k) {
        if (position.held[static_cast<std::size_t>(k)]) {
          position.covariance_enu_m2(k, k) = sigma_m * sigma_m;
        }
      }
      points.known.push_back(position);
    }
    looks.pass.push_back(pass);
    looks.flags.push_back(fit.fault == GridFault::kPosition ? Looks::kRejected : 0);
    looks.time_s.push_back(fit.time_s);
    looks.range_m.push_back(grid_point.slant_range_m);
    point_of_look_.push_back(point);
  }

  void Summarise(const Sentinel1Product& product,
                 const std::string& id,
                 const std::vector<GridFit>& fits) {
    ImportedProduct summary{.file = product.file, .pass = id, .orbit_source = product.orbit_source};
    summary.grid_points = fits.size();
    for (const GridFit& fit : fits) {
      if (fit.fault) continue;
      ++summary.good;
      summary.largest_range_m = std::max(summary.largest_range_m, std::abs(fit.range_error_m));
      summary.largest_along_m = std::max(summary.largest_along_m, std::abs(fit.along_error_m));
      summary.mean_along_m += fit.along_error_m;
    }
    if (summary.good > 0) summary.mean_along_m /= static_cast<double>(summary.good);
    result_.products.push_back(std::move(summary));
    for (FaultyRow& row : FaultyRowsOf(product, fits)) result_.faults.push_back(std::move(row));
  }

  const std::vector<OrbitFile>& orbits_;
  const ImportOptions& options_;
  ImportedBlock result_;
  std::vector<std::uint32_t> point_of_look_;
  std::vector<std::optional<std::array<double, 2>>> spans_s_;
};

}  // namespace

ImportedBlock ImportProducts(const std::vector<Sentinel1Product>& products,
                             const std::vector<OrbitFile>& orbits,
                             const ImportOptions& options) {
  CheckOptions(options, products.size());
  Importer importer(orbits, options);
  for (std::size_t i = 0; i < products.size(); ++i) {
    importer.Add(products[i], options.pass_ids.empty() ? PassId(products[i]) : options.pass_ids[i]);
  }
  return importer.Finish();
}

}  // namespace sarblock
