// SPDX-License-Identifier: Apache-2.0
// The program that a careful user of Ceres would write in place of this library: an adjustment with
// position polynomials, automatic derivatives, one residual block a look, points eliminated first
// (SPARSE_SCHUR, SuiteSparse), covariances of points by ceres::Covariance.
//     plain_ceres BLOCK [--threads N] [--covariance POINTS] [--result RESULT] [--form time|library]
// Prints one JSON object. With --covariance the 3 x 3 matrices of the first POINTS points; with
// --result the largest differences from a result of `sarblock adjust` as well, in its standard
// deviations. Run by scripts/bench.sh peer.
//
// Of this library it uses the readers and the vertical of the ellipsoid, nothing else, but with
// --form library, which takes looks and priors from the public cost functions in place of its own:
// `evaluate_ns`, one Evaluate() of a look with all its Jacobians, and `solve_s` compare them. The
// errors of a look are those of the range sphere and the Doppler cone at the measured time
// (docs/theory/observations.md, eqs. (1) and (2)), each over its standard deviation. With --form
// time they are those of the predicted range and time, as in the library (eqs. (9) and (10)), found
// by one step. The plain form is faster. It leaves out that a drift changes the speed, and with it
// the seconds that a metre of azimuth is.
// It does what the scenes leberl-aircraft, block-12-strips and earth-same-side need: azimuth in
// metres, no squint, one position polynomial a pass, at most a drift. Anything else is refused.
#include "sarblock/cost/look_cost.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <sys/resource.h>

namespace sarblock {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

constexpr std::size_t kMaxTerms = 2;  // constant and drift

double UserTime_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

/// Everything of a look that does not change: the path is read at the measured time.
struct LookData {
  Vector3d position_m, velocity_mps, acceleration_mps2;
  Matrix3d axes, axes_rate_per_s;         ///< columns: axes of the corrections, and how they turn
  std::array<double, kMaxTerms> basis{};  ///< Legendre polynomials at the time
  std::array<double, kMaxTerms> basis_per_s{};
  double range_m = 0.0, range_sigma_m = 0.0, azimuth_sigma_m = 0.0;
  double time_sigma_s = 0.0;  ///< azimuth_sigma_m as time, at the start
};

/// What the error of azimuth is: that of the Doppler cone at the measured time, or of the time at
/// which the cone holds the point; or whatever the library's cost functions say.
enum class Form { kCone, kTime, kLibrary };

/// Metres on the cone that a second is: -q, q = u'.d - |v|.
template <typename T>
T MetresASecond(const Vector3<T>& velocity_mps,
                const Vector3<T>& acceleration_mps2,
                const Vector3<T>& los_m) {
  const T speed_mps = velocity_mps.norm();
  const Vector3<T> direction = velocity_mps / speed_mps;
  const Vector3<T> turning = acceleration_mps2 - direction * direction.dot(acceleration_mps2);
  return speed_mps - turning.dot(los_m) / speed_mps;
}

/// Errors of range and azimuth by the point (from its start) and the coefficients of the pass,
/// three for each degree.
template <std::size_t kTerms, Form kForm>
struct LookError {
  LookData look;
  Vector3d start_m;

  template <typename T>
  bool operator()(const T* const point, const T* const corrections, T* errors) const {
    Vector3<T> correction = Vector3<T>::Zero(), rate = Vector3<T>::Zero();
    for (std::size_t k = 0; k < kTerms; ++k) {
      const Eigen::Map<const Vector3<T>> c(corrections + 3 * k);
      correction += c * T(look.basis[k]);
      rate += c * T(look.basis_per_s[k]);
    }
    Vector3<T> velocity_mps = look.velocity_mps.cast<T>();
    velocity_mps += look.axes * rate + look.axes_rate_per_s * correction;
    Vector3<T> los_m = (start_m - look.position_m).cast<T>();
    los_m += Eigen::Map<const Vector3<T>>(point) - look.axes * correction;
    const T cone_error_m = velocity_mps.dot(los_m) / velocity_mps.norm();
    if constexpr (kForm == Form::kCone) {
      errors[1] = cone_error_m / look.azimuth_sigma_m;
    } else {
      Vector3<T> acceleration_mps2 = look.acceleration_mps2.cast<T>();
      acceleration_mps2 += look.axes_rate_per_s * (T(2.0) * rate);
      const T time_s = cone_error_m / MetresASecond(velocity_mps, acceleration_mps2, los_m);
      errors[1] = time_s / look.time_sigma_s;
      los_m -= velocity_mps * time_s;
    }
    errors[0] = (los_m.norm() - look.range_m) / look.range_sigma_m;
    return true;
  }
};

/// A known position: its held components, whitened.
struct ControlError {
  Eigen::MatrixXd whitening;  ///< L^-1 of the held rows of east, north, up
  Vector3d offset_m;          ///< start less known position

  template <typename T>
  bool operator()(const T* const point, T* errors) const {
    Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, 1>>(errors, whitening.rows()) =
        whitening.cast<T>() * (offset_m + Eigen::Map<const Vector3<T>>(point));
    return true;
  }
};

struct PriorError {
  double sigma_m;
  std::size_t index;
  template <typename T>
  bool operator()(const T* const corrections, T* error) const {
    error[0] = corrections[index] / sigma_m;
    return true;
  }
};

struct PathMotion {
  Vector3d position_m, velocity_mps, acceleration_mps2;
};

/// The cubic through the positions and velocities of two states.
PathMotion At(const std::vector<StateVector>& states, double time_s) {
  auto next = std::upper_bound(
      states.begin() + 1, states.end() - 1, time_s, [](double t, const StateVector& s) {
        return t < s.time_s;
      });
  const StateVector &a = *(next - 1), &b = *next;
  const double h = b.time_s - a.time_s, x = time_s - a.time_s;
  const Vector3d mean = (b.position_m - a.position_m) / h;
  const Vector3d c2 = (3.0 * mean - 2.0 * a.velocity_mps - b.velocity_mps) / h;
  const Vector3d c3 = (a.velocity_mps + b.velocity_mps - 2.0 * mean) / (h * h);
  return {a.position_m + x * (a.velocity_mps + x * (c2 + x * c3)),
          a.velocity_mps + x * (2.0 * c2 + 3.0 * x * c3),
          2.0 * c2 + 6.0 * x * c3};
}

/// Along, across and up with their rates; the rates by automatic derivatives by time.
void SetTrackAxes(const Frame& frame, const PathMotion& motion, LookData* look) {
  using Jet = ceres::Jet<double, 1>;
  const VerticalMotion vertical =
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2);
  Vector3<Jet> along, up;
  for (int i = 0; i < 3; ++i) {
    along[i] = Jet(motion.velocity_mps[i]);
    along[i].v[0] = motion.acceleration_mps2[i];
    up[i] = Jet(vertical.up[i]);
    up[i].v[0] = vertical.rate[i];
  }
  along /= along.norm();
  up -= along * along.dot(up);
  up /= up.norm();
  Matrix3<Jet> axes;
  axes << along, up.cross(along), up;
  for (int i = 0; i < 9; ++i) {
    look->axes.data()[i] = axes.data()[i].a;
    look->axes_rate_per_s.data()[i] = axes.data()[i].v[0];
  }
}

/// The position polynomial of a pass.
const PositionCorrection& CorrectionOf(const std::string& pass, const AdjustOptions& options) {
  const PositionCorrection* found = nullptr;
  for (const CorrectionGroup& group : options.groups) {
    const auto* position = std::get_if<PositionCorrection>(&group.model);
    if (position == nullptr || position->basis != PositionCorrection::Basis::kPolynomial ||
        group.shared || position->degree + 1 > static_cast<int>(kMaxTerms) ||
        position->components != std::array{true, true, true}) {
      throw std::invalid_argument(
          "corrections: position polynomials of degree 0 or 1 alone, all components, not shared");
    }
    const auto& passes = group.passes;
    if (passes.empty() || std::find(passes.begin(), passes.end(), pass) != passes.end())
      found = position;
  }
  if (found == nullptr) throw std::invalid_argument("pass " + pass + " has no position polynomial");
  return *found;
}

LookData MakeLook(const Block& block, std::size_t index, const PositionCorrection& correction) {
  const Pass& pass = block.passes[block.looks.pass[index]];
  const LookSigma sigma = block.SigmaOf(index);
  if (sigma.azimuth_unit != AzimuthUnit::kMetres || block.ConeOf(index).Sine(1.0) != 0.0) {
    throw std::invalid_argument("looks: azimuth in metres alone, without squint");
  }
  const double time_s = block.looks.time_s[index];
  const PathMotion motion = At(pass.path.states(), time_s);
  LookData look;
  look.position_m = motion.position_m;
  look.velocity_mps = motion.velocity_mps;
  look.acceleration_mps2 = motion.acceleration_mps2;
  look.axes.setIdentity();
  look.axes_rate_per_s.setZero();
  if (correction.axes == PositionCorrection::Axes::kTrack) SetTrackAxes(block.frame, motion, &look);
  const double x = (2.0 * time_s - pass.start_s - pass.end_s) / (pass.end_s - pass.start_s);
  const double per_s = 2.0 / (pass.end_s - pass.start_s);
  look.basis = {1.0, x};
  look.basis_per_s = {0.0, per_s};
  look.range_m = block.looks.range_m[index];
  look.range_sigma_m = sigma.range_m;
  look.azimuth_sigma_m = sigma.azimuth;
  return look;
}

/// Where a look sees the ground of a height, on the sphere (local frames: the plane) below.
Vector3d AtHeight(const Block& block, const LookData& look, LookSide side, double height_m) {
  const Vertical vertical = block.frame.VerticalAt(look.position_m);
  const double drop_m = vertical.height_m - height_m, r_m = look.range_m;
  double cosine = drop_m / r_m;
  if (block.frame.kind() == FrameKind::kGeocentric) {
    const double high_m = look.position_m.norm(), low_m = high_m - drop_m;
    cosine = (high_m * high_m + r_m * r_m - low_m * low_m) / (2.0 * high_m * r_m);
  }
  cosine = std::clamp(cosine, -1.0, 1.0);
  const Vector3d along = look.velocity_mps.normalized();
  const Vector3d up = (vertical.up - along * along.dot(vertical.up)).normalized();
  const double sign = side == LookSide::kLeft ? 1.0 : -1.0;
  return look.position_m +
         r_m * (sign * std::sqrt(1.0 - cosine * cosine) * up.cross(along) - cosine * up);
}

class PlainAdjustment {
 public:
  PlainAdjustment(const files::BlockFile& file, Form form)
      : block_(file.block), options_(file.adjust), form_(form) {
    if (options_.robust != RobustLoss::kNone || !options_.priors.empty() ||
        options_.corrections != CorrectionChoice::kGiven) {
      throw std::invalid_argument(
          "[adjust]: given corrections with priors of their own and no robust loss");
    }
    for (const Pass& pass : block_.passes) {
      corrections_of_.push_back(&CorrectionOf(pass.id, options_));
      corrections_.push_back({});
    }
    StartPoints();
    AddResiduals();
  }

  /// Least time of one evaluation of a look with all its Jacobians, over all looks in turn.
  [[nodiscard]] double EvaluationTime_ns() const {
    double least_s = std::numeric_limits<double>::infinity();
    std::vector<double*> blocks, jacobians;
    std::array<double, 2 * 3 * (1 + kMaxTerms)> memory{};
    std::array<double, 2> errors{};
    for (int sweep = 0; sweep < 20; ++sweep) {
      double taken_s = 0.0;
      for (std::size_t first = 0; first < looks_.size(); first += 256) {
        const std::size_t end = std::min(looks_.size(), first + 256);
        std::vector<std::vector<double*>> of(end - first);
        for (std::size_t i = first; i < end; ++i) {
          problem_.GetParameterBlocksForResidualBlock(looks_[i], &of[i - first]);
        }
        jacobians.assign({memory.data(), memory.data() + 6});
        const auto begin = std::chrono::steady_clock::now();
        for (std::size_t i = first; i < end; ++i) {
          static_cast<void>(problem_.GetCostFunctionForResidualBlock(looks_[i])->Evaluate(
              of[i - first].data(), errors.data(), jacobians.data()));
        }
        taken_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      }
      least_s = std::min(least_s, taken_s);
    }
    return 1e9 * least_s / static_cast<double>(looks_.size());
  }

  ceres::Solver::Summary Solve(int threads) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.num_threads = threads;
    options.max_num_iterations = 500;
    options.function_tolerance = 1e-12;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (const std::uint32_t point : solved_)
      ordering->AddElementToGroup(displacement_m_[point].data(), 0);
    for (auto& corrections : corrections_) {
      if (problem_.HasParameterBlock(corrections.data()))
        ordering->AddElementToGroup(corrections.data(), 1);
    }
    options.linear_solver_ordering.reset(ordering);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error(summary.message);
    return summary;
  }

  /// Covariances of the first points, frame axes.
  std::vector<Matrix3d> Covariances(std::size_t count, int threads) {
    count = std::min(count, solved_.size());
    ceres::Covariance::Options options;
    options.num_threads = threads;
    ceres::Covariance covariance(options);
    std::vector<std::pair<const double*, const double*>> blocks;
    for (std::size_t i = 0; i < count; ++i) {
      const double* point = displacement_m_[solved_[i]].data();
      blocks.emplace_back(point, point);
    }
    if (!covariance.Compute(blocks, &problem_))
      throw std::runtime_error("the Jacobian has no full rank");
    std::vector<Matrix3d> out(count);
    for (std::size_t i = 0; i < count; ++i) {
      covariance.GetCovarianceBlock(blocks[i].first, blocks[i].second, out[i].data());
    }
    return out;
  }

  [[nodiscard]] const std::vector<std::uint32_t>& solved() const { return solved_; }
  [[nodiscard]] Vector3d Position(std::uint32_t point) const {
    return start_m_[point] + displacement_m_[point];
  }
  [[nodiscard]] std::size_t looks() const { return looks_.size(); }
  /// Coefficient of an axis and a degree.
  [[nodiscard]] double Correction_m(std::size_t pass, std::size_t axis, std::size_t degree) const {
    return corrections_[pass]
                       [form_ == Form::kLibrary ? axis * Terms(pass) + degree : 3 * degree + axis];
  }
  [[nodiscard]] std::size_t Terms(std::size_t pass) const {
    return static_cast<std::size_t>(corrections_of_[pass]->degree) + 1;
  }

 private:
  template <typename F>
  void ForLooks(std::uint32_t point, F&& f) const {
    for (std::size_t i = block_.looks.offsets[point]; i < block_.looks.offsets[point + 1]; ++i) {
      if (!block_.looks.rejected(i)) f(i);
    }
  }

  [[nodiscard]] const KnownPosition* ControlOf(std::uint32_t point) const {
    return block_.points.role[point] == PointRole::kControl ? block_.points.FindKnown(point)
                                                            : nullptr;
  }

  /// From the place at the height of the control, a few steps of Gauss and Newton with the paths
  /// held. Points with one look and no control are left out.
  void StartPoints() {
    double height_m = 0.0;
    int known = 0;
    for (const KnownPosition& k : block_.points.known) {
      if (ControlOf(k.point) == nullptr) continue;
      height_m += block_.frame.VerticalAt(block_.points.given_m[k.point]).height_m;
      ++known;
    }
    if (known > 0) height_m /= known;
    start_m_.resize(block_.points.size());
    displacement_m_.assign(block_.points.size(), Vector3d::Zero());
    std::vector<LookData> looks;
    for (std::uint32_t point = 0; point < block_.points.size(); ++point) {
      looks.clear();
      std::optional<LookSide> side;
      ForLooks(point, [&](std::size_t i) {
        looks.push_back(MakeLook(block_, i, *corrections_of_[block_.looks.pass[i]]));
        if (!side) side = block_.passes[block_.looks.pass[i]].side;
      });
      const bool control = ControlOf(point) != nullptr;
      if (looks.size() < 2 && !(control && !looks.empty())) continue;
      start_m_[point] =
          control ? block_.points.given_m[point] : AtHeight(block_, looks[0], *side, height_m);
      if (!control) Intersect(looks, &start_m_[point]);
      solved_.push_back(point);
    }
  }

  static void Intersect(const std::vector<LookData>& looks, Vector3d* point_m) {
    using Jet = ceres::Jet<double, 3>;
    const std::array<Jet, 3> none{};
    for (int step = 0; step < 10; ++step) {
      Matrix3d normal = Matrix3d::Zero();
      Vector3d right = Vector3d::Zero();
      for (const LookData& look : looks) {
        const std::array<Jet, 3> d{Jet(0.0, 0), Jet(0.0, 1), Jet(0.0, 2)};
        std::array<Jet, 2> errors;
        LookError<1, Form::kCone>{look, *point_m}(d.data(), none.data(), errors.data());
        for (const Jet& e : errors) {
          normal += e.v * e.v.transpose();
          right -= e.v * e.a;
        }
      }
      const Vector3d move_m = normal.ldlt().solve(right);
      *point_m += move_m;
      if (!(move_m.norm() > 1e-3)) return;
    }
  }

  template <std::size_t kTerms, Form kForm>
  void AddLook(const LookData& look, std::uint32_t point, std::size_t pass) {
    using Error = LookError<kTerms, kForm>;
    using Cost = ceres::AutoDiffCostFunction<Error, 2, 3, static_cast<int>(3 * kTerms)>;
    looks_.push_back(problem_.AddResidualBlock(new Cost(new Error{look, start_m_[point]}),
                                               nullptr,
                                               displacement_m_[point].data(),
                                               corrections_[pass].data()));
  }

  void AddLookOfLibrary(std::size_t index, std::uint32_t point) {
    const std::size_t pass = block_.looks.pass[index];
    const FlightPointer& flight = flights_[pass];
    const LookMeasurement look = MeasurementOf(block_, index, *flight, start_m_[point]);
    double* const arrays[] = {corrections_[pass].data()};
    looks_.push_back(problem_.AddResidualBlock(
        RangeDopplerCost(flight, look, start_m_[point]).release(),
        nullptr,
        flight->Blocks(displacement_m_[point].data(), arrays, look.time_s)));
  }

  template <Form kForm>
  void AddLook(std::size_t index, std::uint32_t point) {
    const std::size_t pass = block_.looks.pass[index];
    LookData look = MakeLook(block_, index, *corrections_of_[pass]);
    const Vector3d los_m = start_m_[point] - look.position_m;
    look.time_sigma_s =
        look.azimuth_sigma_m / MetresASecond(look.velocity_mps, look.acceleration_mps2, los_m);
    if (Terms(pass) == 1) AddLook<1, kForm>(look, point, pass);
    if (Terms(pass) == 2) AddLook<2, kForm>(look, point, pass);
  }

  void AddResiduals() {
    for (std::size_t pass = 0; form_ == Form::kLibrary && pass < block_.passes.size(); ++pass) {
      flights_.push_back(std::make_shared<CorrectedFlight>(
          block_, pass, std::vector<FlightCorrection>{{*corrections_of_[pass], {}}}));
    }
    for (const std::uint32_t point : solved_) {
      ForLooks(point, [&](std::size_t i) {
        if (form_ == Form::kCone) AddLook<Form::kCone>(i, point);
        if (form_ == Form::kTime) AddLook<Form::kTime>(i, point);
        if (form_ == Form::kLibrary) AddLookOfLibrary(i, point);
      });
      if (const KnownPosition* known = ControlOf(point)) AddControl(*known);
    }
    for (std::size_t pass = 0; pass < block_.passes.size(); ++pass) {
      if (form_ != Form::kLibrary) {
        AddPriors(pass);
      } else if (CostPointer prior = PriorCost(*flights_[pass], 0)) {
        problem_.AddResidualBlock(prior.release(), nullptr, corrections_[pass].data());
      }
    }
  }

  void AddControl(const KnownPosition& known) {
    std::vector<int> fixed;
    for (int i = 0; i < 3; ++i) {
      if (known.fixed[static_cast<std::size_t>(i)]) fixed.push_back(i);
    }
    const Matrix3d enu_from_frame = block_.frame.EnuFromFrame(block_.points.given_m[known.point]);
    const Eigen::MatrixXd covariance_m2 = known.covariance_enu_m2(fixed, fixed);
    const Eigen::MatrixXd rows = enu_from_frame(fixed, Eigen::all);
    const Eigen::MatrixXd whitening = covariance_m2.llt().matrixL().solve(rows);
    using Cost = ceres::AutoDiffCostFunction<ControlError, ceres::DYNAMIC, 3>;
    problem_.AddResidualBlock(
        new Cost(
            new ControlError{whitening, start_m_[known.point] - block_.points.given_m[known.point]},
            static_cast<int>(fixed.size())),
        nullptr,
        displacement_m_[known.point].data());
  }

  template <std::size_t kTerms>
  void AddPrior(double sigma_m, std::size_t index, std::size_t pass) {
    using Cost = ceres::AutoDiffCostFunction<PriorError, 1, static_cast<int>(3 * kTerms)>;
    problem_.AddResidualBlock(
        new Cost(new PriorError{sigma_m, index}), nullptr, corrections_[pass].data());
  }

  void AddPriors(std::size_t pass) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<double>& sigmas_m = corrections_of_[pass]->prior_sigma_m[axis];
      for (std::size_t degree = 0; degree < Terms(pass) && !sigmas_m.empty(); ++degree) {
        const double sigma_m = sigmas_m[sigmas_m.size() == 1 ? 0 : degree];
        if (std::isnan(sigma_m)) continue;
        if (Terms(pass) == 1) AddPrior<1>(sigma_m, 3 * degree + axis, pass);
        if (Terms(pass) == 2) AddPrior<2>(sigma_m, 3 * degree + axis, pass);
      }
    }
  }

  const Block& block_;
  const AdjustOptions& options_;
  std::vector<const PositionCorrection*> corrections_of_;       // by pass
  std::vector<std::array<double, 3 * kMaxTerms>> corrections_;  // by pass
  std::vector<Vector3d> start_m_, displacement_m_;              // by point
  std::vector<std::uint32_t> solved_;
  Form form_;
  std::vector<FlightPointer> flights_;  // by pass, of Form::kLibrary
  std::vector<ceres::ResidualBlockId> looks_;
  ceres::Problem problem_;  // after what it points to
};

Matrix3d MatrixOf(const SymmetricEnu& c) {
  Matrix3d out;
  out << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return out;
}

struct Differences {
  double points_sigmas = 0.0, corrections_sigmas = 0.0, covariance = 0.0;
  std::size_t points = 0;
};

/// The largest differences from a result, in its standard deviations: of positions the length in
/// the metric of each point's covariance.
Differences Compare(const PlainAdjustment& plain,
                    const std::vector<Matrix3d>& covariances,
                    const files::BlockFile& file,
                    const std::string& folder) {
  const files::ResultFile result =
      files::ReadResult(folder, {.looks = false, .pairs = false, .paths = false});
  Differences out;
  const PointResults& points = result.points.results;
  for (std::size_t i = 0; i < plain.solved().size(); ++i) {
    const std::uint32_t point = plain.solved()[i];
    if (!IsSolved(points.status[point]) || points.covariance_m2.empty()) continue;
    const Matrix3d enu_from_frame = file.block.frame.EnuFromFrame(points.position_m[point]);
    const Matrix3d covariance_m2 = MatrixOf(points.covariance_m2[point]);
    const Vector3d d_m = enu_from_frame * (plain.Position(point) - points.position_m[point]);
    out.points_sigmas =
        std::max(out.points_sigmas, std::sqrt(d_m.dot(covariance_m2.ldlt().solve(d_m))));
    ++out.points;
    if (i >= covariances.size()) continue;
    const Matrix3d own_m2 = enu_from_frame * covariances[i] * enu_from_frame.transpose();
    out.covariance = std::max(
        out.covariance,
        (own_m2 - covariance_m2).cwiseAbs().maxCoeff() / covariance_m2.cwiseAbs().maxCoeff());
  }
  std::size_t next = 0;  // as passes.csv: by pass, by axis, by degree
  for (std::size_t pass = 0; pass < file.block.passes.size(); ++pass) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t degree = 0; degree < plain.Terms(pass); ++degree) {
        const ParameterResult& parameter = result.parameters.at(next++);
        out.corrections_sigmas = std::max(
            out.corrections_sigmas,
            std::abs(plain.Correction_m(pass, axis, degree) - parameter.value) / parameter.sigma);
      }
    }
  }
  return out;
}

int Run(int count, char** arguments) {
  std::string block, result;
  std::size_t covariance_points = 0;
  int threads = 1;
  Form form = Form::kCone;
  for (int i = 1; i < count; ++i) {
    const std::string word = arguments[i];
    if (word.substr(0, 2) != "--") {
      block = word;
    } else if (i + 1 == count) {
      throw std::invalid_argument(word + " needs a value");
    } else if (word == "--threads") {
      threads = std::stoi(arguments[++i]);
    } else if (word == "--covariance") {
      covariance_points = std::stoul(arguments[++i]);
    } else if (word == "--result") {
      result = arguments[++i];
    } else if (word == "--form") {
      const std::string name = arguments[++i];
      form = name == "time" ? Form::kTime : name == "library" ? Form::kLibrary : Form::kCone;
    } else {
      throw std::invalid_argument(word + " is not known");
    }
  }
  if (block.empty()) throw std::invalid_argument("BLOCK is missing");
  const files::BlockFile file = files::ReadBlock(block);
  const double read_s = UserTime_s();
  PlainAdjustment plain(file, form);
  const double started_s = UserTime_s();
  const double evaluate_ns = plain.EvaluationTime_ns();
  const double made_s = UserTime_s();
  const ceres::Solver::Summary summary = plain.Solve(threads);
  const double solved_s = UserTime_s();
  std::vector<Matrix3d> covariances;
  if (covariance_points > 0) covariances = plain.Covariances(covariance_points, threads);
  const double all_s = UserTime_s();
  std::printf(
      "{\"points\": %zu, \"looks\": %zu, \"iterations\": %d, \"converged\": %s, \"cost\": %.15g,\n"
      " \"read_s\": %.4f, \"start_s\": %.4f, \"solve_s\": %.4f, \"covariance_s\": %.4f, "
      "\"covariance_points\": %zu, \"evaluate_ns\": %.0f",
      plain.solved().size(),
      plain.looks(),
      static_cast<int>(summary.iterations.size()) - 1,
      summary.termination_type == ceres::CONVERGENCE ? "true" : "false",
      summary.final_cost,
      read_s,
      started_s - read_s,
      solved_s - made_s,
      all_s - solved_s,
      covariances.size(),
      evaluate_ns);
  if (!result.empty()) {
    const Differences d = Compare(plain, covariances, file, result);
    std::printf(
        ",\n \"compared\": %zu, \"points_sigmas\": %.3g, \"corrections_sigmas\": %.3g, "
        "\"covariance\": %.3g",
        d.points,
        d.points_sigmas,
        d.corrections_sigmas,
        d.covariance);
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace sarblock

int main(int count, char** arguments) {
  try {
    return sarblock::Run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "plain_ceres: %s\n", error.what());
    return 3;
  }
}
