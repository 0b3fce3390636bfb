// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "adjusted_image.h"
#include "core/utc.h"
#include "formats.h"
#include "products/csm.h"
#include "products/image_table.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Smaller differences are not reported.
constexpr double kReported_m = 1e-3;

double EpochOfPass_s(const files::ResultPass& pass) {
  return EphemerisTime_s(EpochOf(pass, "a model state"));
}

FlightPath PathFrom(const RadarImage& image, double epoch_s) {
  std::vector<StateVector> states = image.states;
  for (StateVector& state : states) state.time_s -= epoch_s;
  try {
    return FlightPath(std::move(states));
  } catch (const InputError& error) {
    throw InputError(FilePlace{image.file, 0, ""}, error.what());
  }
}

void RequireBody(const Frame& frame, const RadarImage& image) {
  if (frame.kind() == FrameKind::kGeocentric &&
      std::abs(frame.ellipsoid().a_m - image.ellipsoid.a_m) <= kSameRadius * image.ellipsoid.a_m) {
    return;
  }
  throw InputError(FilePlace{image.file, 0, "radii"},
                   fmt::format("is an image of a body of radius {} km, the frame of the result is "
                               "{}",
                               1e-3 * image.ellipsoid.a_m,
                               frame.kind() == FrameKind::kLocal
                                   ? "local"
                                   : fmt::format("that of {} km", 1e-3 * frame.ellipsoid().a_m)));
}

/// One pass on its way into a model state.
class StateMaker {
 public:
  StateMaker(const files::ResultFile& result, const PassImage& given, RangePolynomialTimes reading)
      : result_(result),
        model_(ReadCsmModel(given.file)),
        epoch_s_(EpochOfPass_s(result.passes[given.pass])),
        antenna_(result, given.pass, PathFrom(model_.image, epoch_s_), given.file),
        image_pass_(PassOfRadarImage(model_.image, RangePolynomialTimes::kGiven)),
        reading_(reading) {
    RequireBody(result.frame, model_.image);
  }

  MadeImage Make() {
    AdjustedCsmModel adjusted;
    adjusted.time_shift_s = antenna_.time_bias_s();
    adjusted.states = States();
    adjusted.ground_range = Polynomials();
    adjusted.covariance = Covariance();
    adjusted.reference_m = ReferencePoint();
    CheckInterpolation(adjusted.states);
    CheckPolynomials(adjusted.ground_range);
    ListUncarried();
    return {CsmStateText(model_, adjusted), std::move(notes_)};
  }

 private:
  [[nodiscard]] double PathTime_s(double ephemeris_s) const { return ephemeris_s - epoch_s_; }
  // One of `count` times evenly over the image, at which its states are read.
  [[nodiscard]] double StateTime_s(int k, int count) const {
    const double first_s = model_.image.first_line_s;
    return antenna_.time_bias_s() + first_s + (model_.end_s - first_s) * k / (count - 1);
  }

  [[nodiscard]] std::vector<StateVector> States() const {
    std::vector<StateVector> states;
    for (std::size_t k = 0; k < model_.times.count; ++k) {
      const Motion motion = antenna_.MotionAt(PathTime_s(model_.times.At(k)));
      states.push_back(
          {model_.times.At(k), motion.position_m, ConeVelocity(antenna_, result_.frame, motion)});
    }
    return states;
  }

  // R = (R(g) - b_r) / (1 + kappa) is the distance of the antenna.
  [[nodiscard]] double Distance_m(double range_m) const {
    return (range_m - antenna_.ValueOf(ParameterKind::kRangeBias)) /
           (1.0 + antenna_.ValueOf(ParameterKind::kRangeScale));
  }
  [[nodiscard]] std::vector<GroundRangePolynomial> Polynomials() const {
    const RadarImage& image = model_.image;
    std::vector<GroundRangePolynomial> polynomials =
        reading_ == RangePolynomialTimes::kGiven
            ? ForUsgscsm(image.ground_range, image.first_line_s, model_.end_s)
            : image.ground_range;
    for (GroundRangePolynomial& polynomial : polynomials) {
      const double zero_m = Distance_m(polynomial.coefficients[0]);
      for (double& c : polynomial.coefficients) {
        c /= 1.0 + antenna_.ValueOf(ParameterKind::kRangeScale);
      }
      polynomial.coefficients[0] = zero_m;
    }
    return polynomials;
  }

  // Of the antenna over the image: the parameters of USGSCSM move all positions and all velocities
  // alike, so the fit is the mean over the times.
  Eigen::Matrix<double, 6, 6> Covariance() {
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
    if (!antenna_.HasCovariance()) {
      notes_.not_carried.emplace_back(
          "m_covariance is the unit matrix that USGSCSM begins with: the result has no covariance");
      return covariance;
    }
    if (antenna_.parameters().empty()) return Eigen::Matrix<double, 6, 6>::Zero();
    std::vector<FitTime> times;
    constexpr int kTimes = 65;
    for (int k = 0; k < kTimes; ++k) {
      times.push_back({Eigen::MatrixXd::Identity(6, 6),
                       antenna_.InfluenceAt(PathTime_s(StateTime_s(k, kTimes)),
                                            AdjustedAntenna::Direction::kOfCone)});
    }
    const Eigen::MatrixXd fit = FitParameters(times);
    const double rest_m = UnfittedSigma_m(times, 3, fit, antenna_.covariance());
    if (rest_m > kReported_m) {
      notes_.not_carried.push_back(fmt::format(
          "m_covariance holds what is common to all positions; that they err by up to {:.3g} m (1 "
          "sigma) about it",
          rest_m));
    }
    covariance = fit * antenna_.covariance() * fit.transpose();
    return 0.5 * (covariance + covariance.transpose());
  }

  [[nodiscard]] FixedPathLook MiddleLook() const {
    const Motion motion = antenna_.MotionAt(MiddleTime_s());
    FixedPathLook observation;
    observation.antenna_m = motion.position_m;
    observation.velocity_mps = ConeVelocity(antenna_, result_.frame, motion);
    observation.acceleration_mps2 = motion.acceleration_mps2;
    observation.range_m = Distance_m(MiddleRange_m());
    observation.side = static_cast<int>(antenna_.pass().side);
    return observation;
  }
  [[nodiscard]] double MiddleTime_s() const {
    const double line = 0.5 * static_cast<double>(model_.image.lines - 1);
    return antenna_.time_bias_s() +
           PathTime_s(model_.image.first_line_s + line * model_.image.line_interval_s);
  }
  [[nodiscard]] double MiddleRange_m() const {
    if (image_pass_.middle) return image_pass_.middle->range_m;
    throw InputError(FilePlace{model_.image.file, 0, "range polynomials"},
                     "give no slant range in the middle of the image");
  }
  // Zeros, which USGSCSM takes for not given, where the middle of the image is not on the ground.
  [[nodiscard]] Eigen::Vector3d ReferencePoint() const {
    const Intersection place = IntersectWithHeight(MiddleLook(), result_.frame, 0.0);
    if (place.outcome != IntersectionOutcome::kDetermined) return Eigen::Vector3d::Zero();
    return place.position_m;
  }

  // Between its states USGSCSM takes Lagrange's polynomial of eight.
  void CheckInterpolation(const std::vector<StateVector>& states) {
    std::vector<std::vector<double>> rows;
    for (const StateVector& state : states) {
      rows.emplace_back(state.position_m.data(), state.position_m.data() + 3);
    }
    double largest_m = 0.0;
    constexpr int kTimes = 1001;
    for (int k = 0; k < kTimes; ++k) {
      const double ephemeris_s = StateTime_s(k, kTimes);
      const double place = (ephemeris_s - model_.times.first_s) / model_.times.step_s;
      const std::vector<double> read = AsUsgscsmInterpolates(rows, place);
      const Eigen::Vector3d& true_m = antenna_.MotionAt(PathTime_s(ephemeris_s)).position_m;
      largest_m = std::max(largest_m, (Eigen::Vector3d(read.data()) - true_m).norm());
    }
    if (largest_m > kReported_m) {
      notes_.not_carried.push_back(
          fmt::format("between its states, {:.3g} s apart, the path is up to {:.3g} m from that of "
                      "the result",
                      model_.times.step_s,
                      largest_m));
    }
  }

  void CheckPolynomials(const std::vector<GroundRangePolynomial>& written) {
    if (reading_ != RangePolynomialTimes::kGiven || written.size() < 2) return;
    std::vector<std::vector<double>> rows;
    for (const GroundRangePolynomial& polynomial : written) rows.push_back(polynomial.coefficients);
    const double step_s =
        (written.back().time_s - written.front().time_s) / static_cast<double>(written.size());
    const RadarImage& image = model_.image;
    const double far_px = static_cast<double>(image.samples - 1);
    const double far_m = far_px * image.sample_spacing_m;
    const double offset_s = image_pass_.pass.image->first_line_s - image.first_line_s;
    double largest_m = 0.0;
    constexpr int kTimes = 1001;
    for (int k = 0; k < kTimes; ++k) {
      const double line = static_cast<double>(image.lines - 1) * k / (kTimes - 1);
      const auto given = RadarFromImage(*image_pass_.pass.image, {line, far_px});
      if (!given) continue;
      const double ephemeris_s = given->time_s - offset_s;
      const std::vector<double> c =
          AsUsgscsmInterpolates(rows, (ephemeris_s - written.front().time_s) / step_s);
      const double read_m = c[0] + far_m * (c[1] + far_m * (c[2] + far_m * c[3]));
      largest_m = std::max(largest_m, std::abs(read_m - Distance_m(given->range_m)));
    }
    if (largest_m > kReported_m) {
      notes_.not_carried.push_back(fmt::format(
          "between the range polynomials slant ranges are read up to {:.3g} m apart", largest_m));
    }
  }

  void ListUncarried() {
    const FixedPathLook middle = MiddleLook();
    for (std::size_t k = 0; k < antenna_.parameters().size(); ++k) {
      const double value = antenna_.value(k), sigma = antenna_.sigma(k);
      switch (antenna_.parameter(k).kind) {
        case ParameterKind::kSquintBias:
          List(k,
               fmt::format("{:.3g} m along the track in the middle of the image",
                           middle.range_m * std::sin(value)));
          break;
        case ParameterKind::kZenithDelay:
          List(k,
               fmt::format("{:.3g} m of slant range in the middle of the image",
                           value * DelaysPerZenith(middle)));
          break;
        case ParameterKind::kRangeBias:
          if (sigma > 0.0) ListSigma(k, sigma);
          break;
        case ParameterKind::kRangeScale:
          if (sigma > 0.0) ListSigma(k, sigma * middle.range_m);
          break;
        default:
          break;
      }
    }
    if (model_.sun_position_m.empty()) {
      notes_.not_carried.emplace_back("the place of the Sun: " + model_.image.file +
                                      " does not give it, so USGSCSM has no illumination");
    }
  }
  void List(std::size_t k, const std::string& size) {
    notes_.not_carried.push_back(antenna_.parameter(k).name + ": " + size);
  }
  void ListSigma(std::size_t k, double sigma_m) {
    notes_.not_carried.push_back(
        fmt::format("the standard deviation of {}, {:.3g} m of slant range",
                    antenna_.parameter(k).name,
                    sigma_m));
  }
  // One over the cosine of the incidence on the sphere of the ground below.
  [[nodiscard]] double DelaysPerZenith(const FixedPathLook& observation) const {
    const double ground_m = result_.frame.ellipsoid().a_m;
    const double cosine = (observation.antenna_m.squaredNorm() - ground_m * ground_m -
                           observation.range_m * observation.range_m) /
                          (2.0 * ground_m * observation.range_m);
    return 1.0 / cosine;
  }

  const files::ResultFile& result_;
  CsmModel model_;
  double epoch_s_;
  AdjustedAntenna antenna_;
  ImagePass image_pass_;
  RangePolynomialTimes reading_;
  ImageNotes notes_;
};

}  // namespace

void WriteCsmStates(const std::filesystem::path& folder,
                    const ExportView& view,
                    ExportReport* report) {
  const auto make = [&view](const PassImage& image) {
    return StateMaker(view.result, image, view.options.range_polynomial).Make();
  };
  WriteImageFiles(folder, view, ".adjusted_state.json", make, report);
}

}  // namespace sarblock
