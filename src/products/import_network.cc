// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "block_builder.h"
#include "core/text.h"
#include "image_table.h"
#include "import.h"
#include "isis.h"
#include "linear/dense.h"
#include "network.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kNoMatch = SerialMatches::kNone;

void CheckNetworkOptions(const NetworkImportOptions& options, std::size_t images) {
  const auto positive = [](const std::optional<double>& value, const char* name) {
    if (value && !(*value > 0.0 && std::isfinite(*value))) {
      throw InputError(name, fmt::format("must be a number above 0, got {}", *value));
    }
  };
  positive(options.range_sigma_m, "range-sigma-m");
  positive(options.azimuth_sigma_m, "azimuth-sigma-m");
  positive(options.control_sigma_m, "control-sigma-m");
  positive(options.fixed_sigma_m, "fixed-sigma-m");
  positive(options.height_sigma_m, "height-sigma-m");
  if (images == 0) throw InputError("images", "none given, one or more are needed");
  if (!options.pass_ids.empty() && options.pass_ids.size() != images) {
    throw InputError(
        "id",
        fmt::format("{} ids for {} images, one each is needed", options.pass_ids.size(), images));
  }
}

Ellipsoid KnownEllipsoid(const std::string& body) {
  for (const std::string& name : EllipsoidNames()) {
    if (SameName(name, body)) return NamedEllipsoid(name);
  }
  return {};
}

void RefuseOtherBodies(const ControlNetwork& network, const std::vector<RadarImage>& images) {
  const Ellipsoid known = KnownEllipsoid(network.target);
  for (const RadarImage& image : images) {
    const bool other_name =
        !image.target.empty() && !network.target.empty() && !SameName(image.target, network.target);
    const double radius_m = known.a_m > 0.0 ? known.a_m : images.front().ellipsoid.a_m;
    const bool other_radius = std::abs(image.ellipsoid.a_m - radius_m) > kSameRadius * radius_m;
    if (!other_name && !other_radius) continue;
    throw InputError(
        FilePlace{image.file, 0, "target"},
        fmt::format("is an image of another body: {}radius {} km, but {} is {} and {} km. Give the "
                    "image that the serial number in the network means",
                    image.target.empty() ? "" : image.target + ", ",
                    NumberText(1e-3 * image.ellipsoid.a_m),
                    known.a_m > 0.0 ? network.file : images.front().file,
                    network.target.empty() ? "of a body without a name" : "of " + network.target,
                    NumberText(1e-3 * radius_m)));
  }
  std::vector<double> radii_m;
  for (const NetworkPoint& point : network.points) {
    if (point.position_m) radii_m.push_back(point.position_m->norm());
  }
  if (radii_m.empty()) return;
  const double middle_m = MedianInPlace(&radii_m);
  const double body_m = images.front().ellipsoid.a_m;
  constexpr double kReliefAndFlattening = 0.1;
  if (std::abs(middle_m - body_m) <= kReliefAndFlattening * body_m) return;
  throw InputError(FilePlace{images.front().file, 0, "radii"},
                   fmt::format("is an image of another body: its radius is {} km, but the points "
                               "of {} are {:.1f} km from the centre",
                               NumberText(1e-3 * body_m),
                               network.file,
                               1e-3 * middle_m));
}

/// Collects passes and points.
class NetworkImporter {
 public:
  NetworkImporter(const ControlNetwork& network,
                  const std::vector<RadarImage>& images,
                  const NetworkImportOptions& options)
      : network_(network), images_(images), options_(options), builder_(options.name) {}

  ImportedNetwork Import() {
    SerialMatches matches = MatchSerials(network_, images_, options_);
    result_.warnings = std::move(matches.warnings);
    AddPasses(matches);
    for (const NetworkPoint& point : network_.points) AddPoint(point);
    WarnOfLeftOut();
    const std::vector<PixelOffset> offsets = offsets_.Offsets(result_.images.size());
    for (std::size_t i = 0; i < offsets.size(); ++i) result_.images[i].offset = offsets[i];
    AddRemarks(NameOffsets(
        builder_.block(), offsets, options_.pixel_origin_px, "the network", "--pixel-origin"));
    if (options_.points) AddMatches(*options_.points);
    result_.block = builder_.Finish();
    return std::move(result_);
  }

 private:
  void AddPasses(const SerialMatches& matches) {
    pass_of_serial_.assign(network_.serials.size(), kNoMatch);
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (matches.serial_of_image[i] == kNoMatch) continue;
      const std::string& serial = network_.serials[matches.serial_of_image[i]];
      pass_of_serial_[matches.serial_of_image[i]] = result_.images.size();
      image_of_pass_.push_back(&images_[i]);
      AddPass(images_[i], options_.pass_ids.empty() ? "" : options_.pass_ids[i], serial);
    }
    if (result_.images.empty()) {
      throw InputError(FilePlace{network_.file, 0, "serial number"},
                       "no image is one that the network was measured in; --serial SERIAL=FILE "
                       "says which file a serial number means");
    }
  }

  void AddPass(const RadarImage& image, const std::string& given_id, const std::string& serial) {
    ImagePass made = PassOfRadarImage(image, options_.range_polynomial);
    // A crop whose end is not in the label does not give the number of lines.
    made.lines = made.samples = 0;
    Pass& pass = made.pass;
    if (!given_id.empty()) pass.id = given_id;
    if (options_.range_sigma_m) pass.sigma.range_m = *options_.range_sigma_m;
    if (options_.azimuth_sigma_m) pass.sigma.azimuth = *options_.azimuth_sigma_m;
    if (options_.jigsaw_sigma) {
      if (!image.jigsaw) {
        throw InputError(FilePlace{image.file, 0, "AzimuthResolution"},
                         "the weights of jigsaw need a cube whose label gives IncidenceAngle, "
                         "RangeResolution and AzimuthResolution");
      }
      pass.sigma.range_m = image.jigsaw->range_m;
      pass.sigma.azimuth = kNotGiven;
    }
    result_.images.push_back({.file = image.file, .pass = pass.id, .serial = serial});
    builder_.AddImage(std::move(made));
  }

  void AddRemarks(std::vector<std::string> remarks) {
    for (std::string& remark : remarks) result_.warnings.push_back(std::move(remark));
  }

  void AddMatches(const MatchedPoints& points) {
    AddRemarks(points.warnings);
    builder_.AddMatches(points);
    result_.matches = points.rows.size();
    AddRemarks(NameOffsets(builder_.block(),
                           builder_.MatchOffsets(),
                           points.origin_px,
                           points.file,
                           "--points-origin"));
  }

  void AddPoint(const NetworkPoint& given) {
    const bool seen = std::any_of(given.measures.begin(), given.measures.end(), [this](auto& m) {
      return pass_of_serial_[m.serial] != kNoMatch;
    });
    if (!seen) {
      ++points_left_out_;
      return;
    }
    const auto point = builder_.AddPoint(given.id);
    if (!point) throw InputError(FilePlace{network_.file, 0, given.id}, "is in the network twice");
    if (given.position_m) builder_.SetPosition(*point, *given.position_m);
    // A point that takes no part holds nothing.
    if (!given.unused) AddKnownPosition(given, *point);
    passes_of_point_.clear();
    for (const NetworkMeasure& measure : given.measures) AddLook(given, measure, *point);
  }

  void AddKnownPosition(const NetworkPoint& given, std::uint32_t point) {
    KnownPosition known{point, {true, true, true}, Eigen::Matrix3d::Zero()};
    Eigen::Matrix3d& covariance_m2 = known.covariance_enu_m2;
    if (given.type == NetworkPointType::kFree) {
      if (!options_.height_sigma_m || !given.position_m) return;
      known.fixed = {false, false, true};
      covariance_m2(2, 2) = *options_.height_sigma_m * *options_.height_sigma_m;
    } else if (!given.position_m) {
      throw InputError(FilePlace{network_.file, 0, given.id},
                       "is constrained or fixed but has no position: give it one, or make it free");
    } else if (given.type == NetworkPointType::kFixed) {
      ++result_.fixed_points;
      covariance_m2.diagonal().setConstant(options_.fixed_sigma_m * options_.fixed_sigma_m);
    } else {
      known.fixed = given.constrained.value_or(known.fixed);
      covariance_m2 = ConstrainedCovariance_m2(given, &known.fixed);
    }
    builder_.SetKnown(PointRole::kControl, known);
  }

  // East, north and up at the place, of the constrained components.
  [[nodiscard]] Eigen::Matrix3d ConstrainedCovariance_m2(const NetworkPoint& given,
                                                         std::array<bool, 3>* fixed) const {
    Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
    if (given.covariance_m2) {
      const Eigen::Matrix3d enu = builder_.frame().EnuFromFrame(*given.position_m);
      covariance_m2 = enu * *given.covariance_m2 * enu.transpose();
    }
    if (!(covariance_m2.diagonal().maxCoeff() > 0.0)) {
      if (!options_.control_sigma_m) {
        throw InputError(FilePlace{network_.file, 0, given.id},
                         "is constrained but has no a-priori covariance; --control-sigma-m gives "
                         "such points a standard deviation");
      }
      covariance_m2.setZero();
      covariance_m2.diagonal().setConstant(*options_.control_sigma_m * *options_.control_sigma_m);
    }
    constexpr double kRounding = 1e-9;
    const Eigen::Vector3d variances_m2 = covariance_m2.diagonal();
    for (Eigen::Index i = 0; i < 3; ++i) {
      bool& holds = (*fixed)[static_cast<std::size_t>(i)];
      holds = holds && variances_m2[i] > kRounding * variances_m2.maxCoeff();
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        const bool both =
            (*fixed)[static_cast<std::size_t>(i)] && (*fixed)[static_cast<std::size_t>(j)];
        const double scale_m2 = std::sqrt(variances_m2[i] * variances_m2[j]);
        if (!both || !(std::abs(covariance_m2(i, j)) > kRounding * scale_m2)) {
          covariance_m2(i, j) = 0.0;
        }
      }
    }
    if (!covariance_m2.allFinite() || !dense::LowerFactor(covariance_m2 + FreeOnes(*fixed))) {
      throw InputError(FilePlace{network_.file, 0, given.id},
                       "its a-priori covariance is none of a position");
    }
    return covariance_m2;
  }

  static Eigen::Matrix3d FreeOnes(const std::array<bool, 3>& fixed) {
    Eigen::Matrix3d ones = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < 3; ++i)
      ones(i, i) = fixed[static_cast<std::size_t>(i)] ? 0.0 : 1.0;
    return ones;
  }

  void AddLook(const NetworkPoint& point, const NetworkMeasure& measure, std::uint32_t index) {
    const std::size_t pass_index = pass_of_serial_[measure.serial];
    if (pass_index == kNoMatch) {
      ++measures_left_out_;
      return;
    }
    const Pass& pass = builder_.block().passes[pass_index];
    const bool rejected = measure.unused || point.unused;
    const ImageCoordinates image{measure.line_px - options_.pixel_origin_px[0],
                                 measure.sample_px - options_.pixel_origin_px[1]};
    const auto fail = [&](const std::string& problem) {
      throw InputError(
          FilePlace{network_.file, 0, point.id + " in " + network_.serials[measure.serial]},
          problem);
    };
    if (std::count(passes_of_point_.begin(), passes_of_point_.end(), pass_index) > 0) {
      fail("is measured twice in this image");
    }
    const auto radar = RadarFromImage(*pass.image, image);
    if (!radar || !pass.path.At(radar->time_s)) {
      if (rejected) {
        ++rejected_left_out_;
        return;
      }
      fail(
          fmt::format("line {} and sample {} are outside the image: {}; --serial SERIAL=FILE says "
                      "which file a serial number means",
                      NumberText(measure.line_px),
                      NumberText(measure.sample_px),
                      radar ? "its path does not cover the time" : "they have no slant range"));
    }
    const auto [range_sigma_m, azimuth] = SigmaOf(measure, pass_index, *radar, fail);
    passes_of_point_.push_back(pass_index);
    builder_.AddLook(
        {.point = index,
         .pass = static_cast<std::uint32_t>(pass_index),
         .flags = static_cast<std::uint8_t>((rejected ? Looks::kRejected : 0) |
                                            (azimuth.in_seconds ? Looks::kAzimuthSeconds : 0)),
         .time_s = radar->time_s,
         .range_m = radar->range_m,
         .range_sigma_m = range_sigma_m,
         .azimuth_sigma = azimuth.sigma});
    if (!rejected && point.position_m) offsets_.Add(pass_index, pass, *radar, *point.position_m);
    ++result_.images[pass_index].looks;
    if (rejected) ++result_.images[pass_index].rejected;
  }

  struct AzimuthSigma {
    double sigma = kNotGiven;
    bool in_seconds = false;
  };
  // The look's own; NaN where that of its pass holds.
  template <typename Fail>
  [[nodiscard]] std::pair<double, AzimuthSigma> SigmaOf(const NetworkMeasure& measure,
                                                        std::size_t pass_index,
                                                        const RadarCoordinates& radar,
                                                        const Fail& fail) const {
    const Pass& pass = builder_.block().passes[pass_index];
    if (options_.jigsaw_sigma) {
      // A shift along track by v changes the Doppler shift by 2 v / (wavelength R).
      const double speed_mps = pass.path.At(radar.time_s)->velocity_mps.norm();
      return {kNotGiven,
              {image_of_pass_[pass_index]->jigsaw->doppler_hz * pass.wavelength_m * radar.range_m /
                   (2.0 * speed_mps),
               false}};
    }
    double range_sigma_m = kNotGiven;
    if (!std::isnan(measure.sample_sigma_px)) {
      const auto pixel_m = SlantRangePerPixel_m(*pass.image, radar);
      if (pixel_m) range_sigma_m = measure.sample_sigma_px * *pixel_m;
    }
    AzimuthSigma azimuth;
    if (!std::isnan(measure.line_sigma_px)) {
      azimuth = {measure.line_sigma_px * pass.image->line_interval_s, true};
    }
    const auto need = [&](double own, double of_pass, const char* axis) {
      if (!std::isnan(own) || !std::isnan(of_pass)) return;
      fail(fmt::format(
          "the network gives no standard deviation of the {}; --{}-sigma-m gives one{}",
          std::string_view(axis) == "range" ? "sample" : "line",
          axis,
          image_of_pass_[pass_index]->jigsaw ? ", --jigsaw-weights that of jigsaw" : ""));
    };
    need(range_sigma_m, pass.sigma.range_m, "range");
    need(azimuth.sigma, pass.sigma.azimuth, "azimuth");
    return {range_sigma_m, azimuth};
  }

  void WarnOfLeftOut() {
    const auto warn = [this](std::size_t count, const char* what) {
      if (count > 0)
        result_.warnings.push_back(fmt::format("{}: {} {}", network_.file, count, what));
    };
    warn(points_left_out_, "points are left out, no image given shows them");
    warn(measures_left_out_, "measures are left out, their images are not given");
    warn(rejected_left_out_, "ignored measures are left out, they lie outside their images");
    if (builder_.block().looks.size() == 0) {
      throw InputError(FilePlace{network_.file, 0, "measures"}, "no measure is in an image given");
    }
  }

  const ControlNetwork& network_;
  const std::vector<RadarImage>& images_;
  const NetworkImportOptions& options_;
  ImportedNetwork result_;
  std::vector<std::size_t> pass_of_serial_;
  std::vector<const RadarImage*> image_of_pass_;
  BlockBuilder builder_;
  OffsetCollector offsets_;
  std::vector<std::size_t> passes_of_point_;  // that have a look of the current point
  std::size_t points_left_out_ = 0, measures_left_out_ = 0, rejected_left_out_ = 0;
};

}  // namespace

ImportedNetwork ImportNetwork(const ControlNetwork& network,
                              const std::vector<RadarImage>& images,
                              const NetworkImportOptions& options) {
  CheckNetworkOptions(options, images.size());
  RefuseOtherBodies(network, images);
  return NetworkImporter(network, images, options).Import();
}

}  // namespace sarblock
