// SPDX-License-Identifier: Apache-2.0
#include "covariance.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "core/threads.h"
#include "geometry/track_axes.h"
#include "linear/dense.h"
#include "normals/back.h"
#include "point_sweep.h"
#include "solve/ceres_engine.h"
#include "solve/reduced_engine.h"
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <ceres/covariance.h>

namespace sarblock {

Eigen::Matrix3d PointSensitivity(const AdjustmentProblem& problem,
                                 const BlockState& state,
                                 std::size_t point,
                                 PointFactor* factor,
                                 PointColumns* columns,
                                 Eigen::Ref<Eigen::MatrixXd> full) {
  FactorPoint(problem, state, {}, 0.0, point, factor);
  const Eigen::Matrix3d r_inverse =
      factor->r.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  if (full.cols() == 0) return r_inverse;
  ProjectColumns(problem, *factor, columns);
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> t(
      columns->t.data(), 3, columns->width);
  full.setZero();
  for (std::size_t b = 0; b < columns->blocks.size(); ++b) {
    const ParameterBlock& block =
        problem.layout.blocks[static_cast<std::size_t>(columns->blocks[b])];
    full.middleRows(block.offset, block.size) =
        (r_inverse * t.middleCols(columns->begin[b], block.size)).transpose();
  }
  return r_inverse;
}

std::vector<ParameterCovariance> ParameterCovariances(const ReducedSystem& system,
                                                      const CorrectionCovariance& covariance) {
  std::vector<ParameterCovariance> out;
  const BlockSymmetricMatrix& inverse = covariance.blocks;
  const int n = inverse.rows();
  if (n <= kFullParameterCovariance) {
    const Eigen::MatrixXd full = system.SolveFor(Eigen::MatrixXd::Identity(n, n));
    for (int i = 0; i < n; ++i) {
      for (int j = i; j < n; ++j) {
        out.push_back({static_cast<std::uint32_t>(i),
                       static_cast<std::uint32_t>(j),
                       0.5 * (full(i, j) + full(j, i))});
      }
    }
    return out;
  }
  for (int j = 0; j < inverse.block_count(); ++j) {
    for (const int i : inverse.RowsOfColumn(j)) {
      const auto block = inverse.Block(i, j);
      for (int c = 0; c < inverse.size(j); ++c) {
        for (int r = i == j ? c : 0; r < inverse.size(i); ++r) {
          const int a = inverse.offset(j) + c, b = inverse.offset(i) + r;
          out.push_back({static_cast<std::uint32_t>(std::min(a, b)),
                         static_cast<std::uint32_t>(std::max(a, b)),
                         block(r, c)});
        }
      }
    }
  }
  return out;
}

std::vector<PairResult> PairDifferences(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  std::vector<PairResult> out;
  for (const auto& [a, b] : pairs) {
    if (!problem.Solves(a) || !problem.Solves(b)) continue;
    PairResult pair;
    pair.a = a;
    pair.b = b;
    const Eigen::Vector3d a_m = state.Position(a);
    pair.difference_enu_m = problem.block.frame.EnuFromFrame(a_m) * (state.Position(b) - a_m);
    pair.covariance_m2.fill(kNaN);
    out.push_back(pair);
  }
  return out;
}

std::vector<PairResult> PairCovariances(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem* system,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    ProgressSink* progress) {
  std::vector<PairResult> out = PairDifferences(problem, state, pairs);
  constexpr std::size_t kPairsPerChunk = 32;
  const Eigen::Index n = system != nullptr ? problem.layout.size() : 0;
  Step(progress, "pairs", 0, out.size());
  std::vector<Eigen::Matrix3d> own(out.size());
  // D of the pairs of a chunk, three columns each, and C D; as many chunks at a time as threads.
  std::vector<Eigen::MatrixXd> differences, solved;
  const std::size_t at_a_time = kPairsPerChunk * static_cast<std::size_t>(ThreadsAllowed());
  for (std::size_t first = 0; first < out.size(); first += at_a_time) {
    const std::size_t count = std::min(at_a_time, out.size() - first);
    differences.resize((count + kPairsPerChunk - 1) / kPairsPerChunk);
    ParallelForChunks(
        count, kPairsPerChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
          PointFactor factor;
          PointColumns columns_of_point;
          Eigen::MatrixXd& difference = differences[chunk];
          difference.resize(n, 3 * static_cast<Eigen::Index>(end - begin));
          Eigen::MatrixXd sides(n, 6);  // Y_a', Y_b'
          for (std::size_t q = first + begin; q < first + end; ++q) {
            own[q].setZero();
            for (const Eigen::Index side : {0, 1}) {
              const Eigen::Matrix3d r_inverse =
                  PointSensitivity(problem,
                                   state,
                                   side == 0 ? out[q].a : out[q].b,
                                   &factor,
                                   &columns_of_point,
                                   sides.middleCols(3 * side, n > 0 ? 3 : 0));
              own[q] += r_inverse * r_inverse.transpose();
            }
            const auto local = static_cast<Eigen::Index>(q - first - begin);
            difference.middleCols(3 * local, 3) = sides.rightCols(3) - sides.leftCols(3);
          }
        });
    if (n > 0) {
      // cov(b - a) = V_a^-1 + V_b^-1 + D' C D with D = Y_b' - Y_a': one solve, no cancellation.
      solved = differences;
      system->SolveEach(solved);
    }
    for (std::size_t q = first; q < first + count; ++q) {
      const std::size_t chunk = (q - first) / kPairsPerChunk;
      const auto local = static_cast<Eigen::Index>((q - first) % kPairsPerChunk);
      if (n > 0) {
        own[q] += differences[chunk].middleCols(3 * local, 3).transpose() *
                  solved[chunk].middleCols(3 * local, 3);
      }
      const Eigen::Vector3d a_m = state.Position(out[q].a);
      out[q].covariance_m2 = ToEnu(problem.block.frame, a_m, 0.5 * (own[q] + own[q].transpose()));
    }
  }
  Step(progress, "pairs", out.size(), out.size());
  return out;
}

double CheckFreedom(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::vector<CheckResult>& checks,
                    double variance_factor) {
  std::vector<const CheckResult*> used;
  double components = 0.0;
  for (const CheckResult& check : checks) {
    if (!std::isfinite(check.chi_square)) continue;
    used.push_back(&check);
    components += check.components;
  }
  const std::size_t stride =
      std::max<std::size_t>(1, (used.size() + kMaxCheckPoints - 1) / kMaxCheckPoints);
  std::vector<const CheckResult*> part;
  for (std::size_t i = 0; i < used.size(); i += stride) part.push_back(used[i]);
  const auto count = static_cast<Eigen::Index>(part.size());
  const Eigen::Index n = problem.layout.size();
  if (count == 0 || n == 0) return components;

  const double sigma_scale = std::sqrt(variance_factor);
  // By point: the directions known, Y = s0 (R^-1 T)' along them, and Q_i.
  Eigen::MatrixXd y(n, 3 * count);
  std::vector<Eigen::Matrix3d> weight(part.size());
  std::vector<Eigen::Matrix3d> own(part.size());
  PointFactor factor;
  PointColumns columns;
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::uint32_t point = part[static_cast<std::size_t>(i)]->point;
    const KnownPosition& known = *problem.block.points.FindKnown(point);
    Eigen::Matrix3d direction = problem.block.frame.EnuFromFrame(state.Position(point));
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (!known.fixed[static_cast<std::size_t>(k)]) direction.row(k).setZero();
    }
    const Eigen::Matrix3d r_inverse =
        sigma_scale *
        PointSensitivity(problem, state, point, &factor, &columns, y.middleCols(3 * i, 3));
    y.middleCols(3 * i, 3) *= sigma_scale * direction.transpose();
    own[static_cast<std::size_t>(i)] =
        direction * r_inverse * r_inverse.transpose() * direction.transpose();
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (Eigen::Index l = 0; l < 3; ++l) {
        if (known.fixed[static_cast<std::size_t>(k)] && known.fixed[static_cast<std::size_t>(l)]) {
          own[static_cast<std::size_t>(i)](k, l) += known.covariance_enu_m2(k, l);
        }
      }
    }
  }
  const Eigen::MatrixXd solved = system.SolveFor(y);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    Eigen::Matrix3d q = own[at] + y.middleCols(3 * i, 3).transpose() * solved.middleCols(3 * i, 3);
    // A component that is not known has a row and a column of zeros, and no weight.
    const KnownPosition& known = *problem.block.points.FindKnown(part[at]->point);
    Eigen::Vector3d fixed_part;
    for (Eigen::Index k = 0; k < 3; ++k) {
      fixed_part[k] = known.fixed[static_cast<std::size_t>(k)] ? 1.0 : 0.0;
      q(k, k) += 1.0 - fixed_part[k];
    }
    weight[at] = dense::Cholesky(q).Inverse() * fixed_part.asDiagonal();
  }
  double of_part = 0.0, shared = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    of_part += part[static_cast<std::size_t>(i)]->components;
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::Matrix3d cross =
          y.middleCols(3 * i, 3).transpose() * solved.middleCols(3 * j, 3);
      shared += 2.0 * (weight[static_cast<std::size_t>(i)] * cross *
                       weight[static_cast<std::size_t>(j)] * cross.transpose())
                          .trace();
    }
  }
  const double scale = components / of_part;
  return components * components / (components + shared * scale * scale);
}

namespace {

/// Corrections whose curvature is formed, and how many of the largest are kept.
constexpr std::size_t kMaxFormed = 200, kMaxCurvatures = 8;
/// Control points and other points that it is formed with: few, and many where a curvature of
/// kMinRefined or more was found with few.
constexpr std::size_t kFewPoints = 100, kManyPoints = 1000;
constexpr double kMinRefined = 0.01, kMinReported = 0.1;
/// Length of the steps, in standard deviations.
constexpr double kStepOfCurvature = 0.5;

/// So many of these points at most, each for as many: spread over them without a period.
void AddSample(const std::vector<std::size_t>& points,
               std::size_t most,
               std::vector<SampledPoint>* sample) {
  constexpr double kGolden = 0.6180339887498949;
  const std::size_t count = std::min(points.size(), most);
  const double each = static_cast<double>(points.size()) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double part = kGolden * static_cast<double>(i);
    const double place = (static_cast<double>(i) + part - std::floor(part)) * each;
    const std::size_t at = each > 1.0 ? static_cast<std::size_t>(place) : i;
    sample->push_back({points[std::min(at, points.size() - 1)], each});
  }
}

}  // namespace

std::vector<CorrectionCurvature> CurvaturesOfCorrections(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem& system,
    const std::vector<ParameterResult>& parameters) {
  // Standard deviation over that with all other unknowns known.
  const auto dilution = [&](std::uint32_t k) {
    return parameters[k].sigma * std::sqrt(system.full_diagonal()[static_cast<Eigen::Index>(k)]);
  };
  std::vector<std::uint32_t> formed;
  for (std::uint32_t k = 0; k < parameters.size(); ++k) {
    if (std::isfinite(dilution(k))) formed.push_back(k);
  }
  std::stable_sort(formed.begin(), formed.end(), [&](std::uint32_t a, std::uint32_t b) {
    return dilution(a) > dilution(b);
  });
  formed.resize(std::min(formed.size(), kMaxFormed));
  if (formed.empty()) return {};

  Eigen::MatrixXd steps =
      Eigen::MatrixXd::Zero(system.rows(), static_cast<Eigen::Index>(formed.size()));
  for (std::size_t i = 0; i < formed.size(); ++i) {
    steps(static_cast<Eigen::Index>(formed[i]), static_cast<Eigen::Index>(i)) = 1.0;
  }
  steps = system.SolveFor(steps);
  for (std::size_t i = 0; i < formed.size(); ++i) {
    auto step = steps.col(static_cast<Eigen::Index>(i));
    step *= kStepOfCurvature / std::sqrt(step[static_cast<Eigen::Index>(formed[i])]);
  }
  std::vector<std::size_t> control, others;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) (problem.control_of[point] >= 0 ? control : others).push_back(point);
  }
  // x'd of a step of one standard deviation: x is linear in its length, d quadratic.
  const auto curvatures_of = [&](std::size_t most) {
    std::vector<SampledPoint> sample;
    AddSample(control, most, &sample);
    AddSample(others, most, &sample);
    return Eigen::VectorXd(BendsAlongSteps(problem, state, steps, sample) /
                           std::pow(kStepOfCurvature, 3));
  };
  Eigen::VectorXd curvatures = curvatures_of(kFewPoints);
  if (!(curvatures.cwiseAbs().maxCoeff() < kMinRefined)) {
    curvatures = curvatures_of(kManyPoints);
  }
  std::vector<CorrectionCurvature> out;
  for (std::size_t i = 0; i < formed.size(); ++i) {
    const double curvature = curvatures[static_cast<Eigen::Index>(i)];
    if (std::isfinite(curvature)) out.push_back({formed[i], curvature});
  }
  std::stable_sort(
      out.begin(), out.end(), [](const CorrectionCurvature& a, const CorrectionCurvature& b) {
        return std::abs(a.curvature) > std::abs(b.curvature);
      });
  out.resize(std::min(out.size(), kMaxCurvatures));
  return out;
}

void WarnOfCurvatures(AdjustResult* result) {
  if (result->curvatures.empty()) return;
  const CorrectionCurvature& worst = result->curvatures.front();
  if (std::abs(worst.curvature) < kMinReported) return;
  const ParameterResult& parameter = result->parameters[worst.parameter];
  Warn(result,
       "the equations are not linear within the standard deviation of " + parameter.owner + " " +
           parameter.name + " (" + Digits(parameter.sigma, 2) + " " + parameter.unit +
           "): its curvature is " + Digits(worst.curvature, 2) +
           ", and 0.1 already moves a limit of 95 % by a third. Standard deviations of corrections "
           "are not reliable here, those of points may be; fewer corrections, narrower priors or "
           "more control determine it better");
}

ErrorEllipse EllipseOf(const SymmetricEnu& covariance_m2, double sigma_scale) {
  const double ee = covariance_m2[0], nn = covariance_m2[1], en = covariance_m2[3];
  const double mean = 0.5 * (ee + nn);
  const double radius = std::hypot(0.5 * (nn - ee), en);
  ErrorEllipse ellipse;
  ellipse.major_m = sigma_scale * std::sqrt(mean + radius);
  ellipse.minor_m = sigma_scale * std::sqrt(std::max(mean - radius, 0.0));
  ellipse.azimuth_rad = 0.5 * std::atan2(2.0 * en, nn - ee);
  if (ellipse.azimuth_rad < 0.0) ellipse.azimuth_rad += std::numbers::pi;
  return ellipse;
}

double EllipseScale(double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw InputError("confidence",
                     "must be a number between 0 and 1, got " + std::to_string(confidence));
  }
  return std::sqrt(-2.0 * std::log1p(-confidence));
}

std::array<Eigen::Vector2d, kEllipseCorners> EllipseCorners(const ErrorEllipse& ellipse) {
  const double sin_azimuth = std::sin(ellipse.azimuth_rad);
  const double cos_azimuth = std::cos(ellipse.azimuth_rad);
  std::array<Eigen::Vector2d, kEllipseCorners> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double angle = -2.0 * std::numbers::pi * static_cast<double>(i) / kEllipseCorners;
    const double along_m = ellipse.major_m * std::cos(angle);
    const double across_m = ellipse.minor_m * std::sin(angle);
    corners[i] = {along_m * sin_azimuth + across_m * cos_azimuth,
                  along_m * cos_azimuth - across_m * sin_azimuth};
  }
  return corners;
}

namespace {

/// Geodetic places near one of them, for the corners of an ellipse.
class PlacesNear {
 public:
  PlacesNear(const Ellipsoid& ellipsoid, const Geodetic& centre) : centre_(centre) {
    sine_ = std::sin(centre.lat_rad);
    cosine_ = std::cos(centre.lat_rad);
    const double e2 = ellipsoid.flattening * (2.0 - ellipsoid.flattening);
    const double q = 1.0 - e2 * sine_ * sine_;
    const double prime_vertical_m = ellipsoid.a_m / std::sqrt(q);
    const double meridian_m = prime_vertical_m * (1.0 - e2) / q;
    radius_m_ = meridian_m + centre.h_m;
    from_axis_m_ = (prime_vertical_m + centre.h_m) * cosine_;
    stretch_ = 3.0 * e2 * sine_ * cosine_ / q * meridian_m / radius_m_;
    flattening_ = ellipsoid.flattening;
  }
  /// Whether places this far away are right to 2e-9 m, but for rounding.
  [[nodiscard]] bool Reach(double away_m) const {
    return radius_m_ > away_m &&
           flattening_ * away_m * away_m * away_m < 1e-9 * radius_m_ * radius_m_;
  }
  /// The place east and north of the centre in its tangent plane, at the centre's height. The
  /// longitude is exact: the turn about the axis. The latitude is that of a meridian with the
  /// curvature at the centre, M + h, exact on a sphere, less half of what M changes by,
  /// (dM/dlat) dlat^2 / 2.
  [[nodiscard]] Geodetic At(const Eigen::Vector2d& east_north_m) const {
    const double east_m = east_north_m.x(), north_m = east_north_m.y();
    const double inwards_m = from_axis_m_ - sine_ * north_m;  // before the step to the east
    const double axis_m = std::hypot(inwards_m, east_m);
    const double outwards_m =
        inwards_m > 0.0 ? east_m * east_m / (axis_m + inwards_m) : axis_m - inwards_m;
    const double along_m = north_m - sine_ * outwards_m;
    const double turn_rad = std::atan2(along_m, radius_m_ + cosine_ * outwards_m);
    return {.lat_rad = centre_.lat_rad + turn_rad - 0.5 * stretch_ * turn_rad * turn_rad,
            .lon_rad = centre_.lon_rad + std::atan2(east_m, inwards_m),
            .h_m = centre_.h_m};
  }

 private:
  Geodetic centre_;
  double sine_ = 0.0, cosine_ = 0.0;
  double radius_m_ = 0.0;     // of the meridian at the centre's height, M + h
  double from_axis_m_ = 0.0;  // (N + h) cos(lat)
  double stretch_ = 0.0;      // (dM/dlat) / (M + h)
  double flattening_ = 0.0;
};

}  // namespace

std::array<Geodetic, kEllipseCorners> EllipseRing(const Frame& frame,
                                                  const Eigen::Vector3d& p_m,
                                                  const ErrorEllipse& ellipse) {
  const Geodetic centre = frame.GeodeticFromFrame(p_m);
  const auto corners = EllipseCorners(ellipse);
  std::array<Geodetic, kEllipseCorners> ring;
  const PlacesNear near(frame.ellipsoid(), centre);
  if (near.Reach(ellipse.major_m)) {
    std::transform(corners.begin(), corners.end(), ring.begin(), [&near](const auto& corner) {
      return near.At(corner);
    });
    return ring;
  }
  const Eigen::Matrix3d frame_from_enu = frame.EnuFromFrame(p_m).transpose();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    ring[i] = frame.GeodeticFromFrame(p_m + frame_from_enu.leftCols<2>() * corners[i]);
    ring[i].h_m = centre.h_m;
    ring[i].lon_rad =
        centre.lon_rad + std::remainder(ring[i].lon_rad - centre.lon_rad, 2.0 * std::numbers::pi);
  }
  return ring;
}

namespace {

namespace bg = boost::geometry;
using PlaceInSpace = bg::model::point<double, 3, bg::cs::cartesian>;
using Entry = std::pair<PlaceInSpace, std::uint32_t>;

PlaceInSpace PlaceOf(const Eigen::Vector3d& p_m) { return {p_m.x(), p_m.y(), p_m.z()}; }

std::vector<Entry> SolvedPoints(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<Entry> out;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    out.emplace_back(PlaceOf(state.Position(point)), static_cast<std::uint32_t>(point));
  }
  return out;
}

using Tree = bg::index::rtree<Entry, bg::index::quadratic<16>>;

void AppendPair(std::uint32_t a, std::uint32_t b, PointPairs* pairs) {
  if (a != b) pairs->emplace_back(std::min(a, b), std::max(a, b));
}

PointPairs Sorted(PointPairs pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

/// Along and across the track of the first pass at its middle, frame axes.
std::optional<std::array<Eigen::Vector3d, 2>> DirectionsOf(const Block& block) {
  if (block.passes.empty()) return std::nullopt;
  const Pass& pass = block.passes.front();
  const std::optional<Motion> motion = pass.path.At(0.5 * (pass.start_s + pass.end_s));
  if (!motion) return std::nullopt;
  const Eigen::Matrix3d axes = TrackAxesOf(block.frame, *motion).axes;
  return std::array<Eigen::Vector3d, 2>{axes.col(0), axes.col(1)};
}

}  // namespace

PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state) {
  const std::vector<Entry> entries = SolvedPoints(problem, state);
  const Tree tree(entries);
  PointPairs pairs;
  std::vector<Entry> nearest;
  for (const Entry& entry : entries) {
    nearest.clear();
    tree.query(bg::index::nearest(entry.first, 2), std::back_inserter(nearest));
    for (const Entry& other : nearest) AppendPair(entry.second, other.second, &pairs);
  }
  return Sorted(std::move(pairs));
}

PointPairs AllPairs(const AdjustmentProblem& problem, std::size_t most) {
  std::vector<std::uint32_t> solved;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) solved.push_back(static_cast<std::uint32_t>(point));
  }
  const std::size_t count = solved.size() < 2 ? 0 : solved.size() * (solved.size() - 1) / 2;
  if (count > most) {
    throw InputError("adjust.pairs",
                     "'all' means " + std::to_string(count) + " pairs, at most " +
                         std::to_string(most) + " are allowed; name the pairs in a file");
  }
  PointPairs pairs;
  for (std::size_t i = 0; i < solved.size(); ++i) {
    for (std::size_t j = i + 1; j < solved.size(); ++j) pairs.emplace_back(solved[i], solved[j]);
  }
  return pairs;
}

PointPairs DistancePairs(const AdjustmentProblem& problem, const BlockState& state) {
  constexpr int kDistances = 8, kTrials = 256;
  constexpr std::size_t kMost = 32;
  constexpr double kLongest = 0.7, kOffPlace = 0.25;
  const std::vector<Entry> entries = SolvedPoints(problem, state);
  const auto directions = DirectionsOf(problem.block);
  if (!directions || entries.size() < 2) return {};
  const Tree tree(entries);
  PointPairs pairs;
  for (const Eigen::Vector3d& direction : *directions) {
    const auto along = [&](const Entry& entry) {
      return direction.dot(state.Position(entry.second));
    };
    const auto [first, last] =
        std::minmax_element(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
          return along(a) < along(b);
        });
    double distance_m = kLongest * (along(*last) - along(*first));
    for (int halved = 0; halved < kDistances; ++halved, distance_m *= 0.5) {
      PointPairs found;
      RandomStream random(static_cast<std::uint64_t>(halved), entries.size());
      for (int trial = 0; trial < kTrials && found.size() < kMost; ++trial) {
        const auto drawn =
            static_cast<std::size_t>(random.Uniform() * static_cast<double>(entries.size()));
        const std::uint32_t from = entries[drawn].second;
        const Eigen::Vector3d aim_m = state.Position(from) + distance_m * direction;
        std::vector<Entry> nearest;
        tree.query(bg::index::nearest(PlaceOf(aim_m), 1), std::back_inserter(nearest));
        const std::uint32_t to = nearest.front().second;
        if ((state.Position(to) - aim_m).norm() > kOffPlace * distance_m) continue;
        AppendPair(from, to, &found);
      }
      pairs.insert(pairs.end(), found.begin(), found.end());
    }
  }
  return Sorted(std::move(pairs));
}

std::array<double, 3> AlongAcrossUp(const SymmetricEnu& covariance_m2,
                                    const Eigen::Vector2d& along) {
  const auto& q = covariance_m2;  // ee, nn, uu, en, eu, nu
  const double e = along.x(), n = along.y();
  const double along_m2 = e * e * q[0] + n * n * q[1] + 2.0 * e * n * q[3];
  return {along_m2, q[0] + q[1] - along_m2, q[2]};
}

std::vector<DifferenceClass> SummariseDifferences(const Block& block, const AdjustResult& result) {
  const auto directions = DirectionsOf(block);
  if (!directions) return {};
  double longest_m = 0.0;
  for (const PairResult& pair : result.pairs) {
    longest_m = std::max(longest_m, pair.difference_enu_m.norm());
  }
  constexpr std::size_t kFewest = 4;  // of which a median is shown
  struct Values {
    std::vector<double> distance_m, along_m, across_m, up_m;
  };
  std::map<std::pair<int, int>, Values> classes;  // direction, then minus the power of two
  const double within = std::cos(20.0 * std::numbers::pi / 180.0);
  for (const PairResult& pair : result.pairs) {
    if (std::isnan(pair.covariance_m2[0])) continue;
    const Eigen::Matrix3d enu = block.frame.EnuFromFrame(result.points.position_m[pair.a]);
    const Eigen::Vector2d along = (enu * (*directions)[0]).head<2>().normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    const double distance_m = pair.difference_enu_m.norm();
    const Eigen::Vector2d level = pair.difference_enu_m.head<2>() / distance_m;
    const bool is_along = std::abs(level.dot(along)) > within;
    if (!is_along && !(std::abs(level.dot(across)) > within)) continue;
    const auto [along_m2, across_m2, up_m2] = AlongAcrossUp(pair.covariance_m2, along);
    const int power = static_cast<int>(std::lround(std::log2(longest_m / distance_m)));
    Values& values = classes[{is_along ? 0 : 1, -power}];
    values.distance_m.push_back(distance_m);
    values.along_m.push_back(std::sqrt(along_m2));
    values.across_m.push_back(std::sqrt(across_m2));
    values.up_m.push_back(std::sqrt(up_m2));
  }
  std::vector<DifferenceClass> out;
  for (const auto& [key, values] : classes) {
    if (values.up_m.size() < kFewest) continue;
    out.push_back({key.first == 0,
                   values.up_m.size(),
                   Median(values.distance_m),
                   Median(values.along_m),
                   Median(values.across_m),
                   Median(values.up_m)});
  }
  return out;
}

namespace {

using Blocks = std::vector<std::pair<const double*, const double*>>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Pairs of parameter blocks (i <= j) that are reported.
std::set<std::pair<int, int>> ParameterPairs(const AdjustmentProblem& problem) {
  std::set<std::pair<int, int>> wanted;
  const int count = static_cast<int>(problem.layout.blocks.size());
  if (problem.layout.size() <= kFullParameterCovariance) {
    for (int i = 0; i < count; ++i) {
      for (int j = i; j < count; ++j) wanted.emplace(i, j);
    }
    return wanted;
  }
  for (int i = 0; i < count; ++i) wanted.emplace(i, i);
  std::vector<int> seen;
  LookColumns columns;
  const Looks& looks = problem.block.looks;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    seen.clear();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      problem.model.ColumnsOf(i, &columns);
      seen.insert(seen.end(), columns.block.begin(), columns.block.begin() + columns.block_count);
    }
    for (const int i : seen) {
      for (const int j : seen) wanted.emplace(std::min(i, j), std::max(i, j));
    }
  }
  return wanted;
}

class CeresRoute {
 public:
  CeresRoute(const AdjustmentProblem& problem, const BlockState& state, int threads)
      : problem_(problem),
        state_(state),
        unknowns_(UnknownsOf(state)),
        ceres_problem_(MakeCeresProblem(
            problem, {}, state, {unknowns_.data(), unknowns_.data() + CorrectionsBegin()})),
        covariance_(OptionsFor(threads)) {}

  CeresCovariances Run(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
    CeresCovariances out;
    out.pairs = PairDifferences(problem_, state_, pairs);
    const std::set<std::pair<int, int>> parameters = ParameterPairs(problem_);
    Compute(parameters, out.pairs);
    FillPoints(&out);
    FillParameters(parameters, &out);
    for (PairResult& pair : out.pairs) {
      const Eigen::Matrix3d cross = Get(PointAt(pair.a), 3, PointAt(pair.b), 3);
      const Eigen::Matrix3d difference = Point(pair.a) + Point(pair.b) - cross - cross.transpose();
      pair.covariance_m2 = ToEnu(problem_.block.frame, state_.Position(pair.a), difference);
    }
    return out;
  }

 private:
  static std::vector<double> UnknownsOf(const BlockState& state) {
    std::vector<double> out;
    for (const Eigen::Vector3d& point_m : state.displacement_m) {
      out.insert(out.end(), point_m.begin(), point_m.end());
    }
    out.insert(out.end(), state.corrections.begin(), state.corrections.end());
    return out;
  }
  static ceres::Covariance::Options OptionsFor(int threads) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.num_threads = threads;
    return options;
  }

  [[nodiscard]] std::size_t CorrectionsBegin() const { return 3 * state_.displacement_m.size(); }
  [[nodiscard]] const double* PointAt(std::size_t point) const {
    return unknowns_.data() + 3 * point;
  }
  [[nodiscard]] const ParameterBlock& BlockOf(int block) const {
    return problem_.layout.blocks[static_cast<std::size_t>(block)];
  }
  [[nodiscard]] const double* ParametersAt(int block) const {
    return unknowns_.data() + CorrectionsBegin() + BlockOf(block).offset;
  }

  void Compute(const std::set<std::pair<int, int>>& parameters,
               const std::vector<PairResult>& pairs) {
    Blocks wanted;
    for (std::size_t point = 0; point < problem_.block.points.size(); ++point) {
      if (problem_.Solves(point)) wanted.emplace_back(PointAt(point), PointAt(point));
    }
    for (const auto& [i, j] : parameters) wanted.emplace_back(ParametersAt(i), ParametersAt(j));
    std::set<std::pair<std::uint32_t, std::uint32_t>>
        unordered;  // Ceres refuses a pair named twice
    for (const PairResult& pair : pairs) {
      if (pair.a != pair.b && unordered.insert(std::minmax(pair.a, pair.b)).second) {
        wanted.emplace_back(PointAt(pair.a), PointAt(pair.b));
      }
    }
    if (!covariance_.Compute(wanted, ceres_problem_.get())) {
      throw UndeterminedError(
          "covariance_method = \"ceres\" finds the equations rank deficient; allowed here: "
          "\"reduced\", which names what is not determined",
          {});
    }
  }

  [[nodiscard]] RowMajor Get(const double* a, int rows, const double* b, int columns) const {
    RowMajor out(rows, columns);
    covariance_.GetCovarianceBlock(a, b, out.data());
    return out;
  }
  [[nodiscard]] Eigen::Matrix3d Point(std::size_t point) const {
    return Get(PointAt(point), 3, PointAt(point), 3);
  }

  void FillPoints(CeresCovariances* out) const {
    out->points.resize(problem_.block.points.size());
    for (std::size_t point = 0; point < out->points.size(); ++point) {
      if (problem_.Solves(point)) {
        out->points[point] = ToEnu(problem_.block.frame, state_.Position(point), Point(point));
      } else {
        out->points[point].fill(std::numeric_limits<double>::quiet_NaN());
      }
    }
  }

  void FillParameters(const std::set<std::pair<int, int>>& pairs, CeresCovariances* out) const {
    for (const auto& [i, j] : pairs) {
      const ParameterBlock& a = BlockOf(i);
      const ParameterBlock& b = BlockOf(j);
      const RowMajor block = Get(ParametersAt(i), a.size, ParametersAt(j), b.size);
      for (int r = 0; r < a.size; ++r) {
        for (int c = i == j ? r : 0; c < b.size; ++c) {
          out->parameters.push_back({static_cast<std::uint32_t>(a.offset + r),
                                     static_cast<std::uint32_t>(b.offset + c),
                                     block(r, c)});
        }
      }
    }
  }

  const AdjustmentProblem& problem_;
  const BlockState& state_;
  // Points, then corrections, in one array: Ceres orders the unknowns by their addresses.
  std::vector<double> unknowns_;
  std::unique_ptr<ceres::Problem> ceres_problem_;
  ceres::Covariance covariance_;
};

}  // namespace

CeresCovariances CovariancesByCeres(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    int threads) {
  return CeresRoute(problem, state, threads).Run(pairs);
}

namespace {

PointPairs WantedPairs(const AdjustmentProblem& problem,
                       const BlockState& state,
                       const AdjustOptions& options,
                       const PointPairs& listed) {
  switch (options.pairs) {
    case PairChoice::kNone:
      return {};
    case PairChoice::kNeighbours:
      return NeighbourPairs(problem, state);
    case PairChoice::kAll:
      return AllPairs(problem);
    case PairChoice::kDistances:
      return DistancePairs(problem, state);
    case PairChoice::kList:
      break;
  }
  return listed;
}

/// An inner datum takes out motions that points and paths share: nothing is left to hold.
bool HasFixedPaths(const AdjustmentProblem& problem, const AdjustOptions& options) {
  return problem.layout.size() > 0 && options.datum == Datum::kGiven;
}

void FillCovarianceByCeres(const AdjustmentProblem& problem,
                           const BlockState& state,
                           const AdjustOptions& options,
                           const PointPairs& pairs,
                           AdjustResult* result) {
  CeresCovariances found = CovariancesByCeres(
      problem, state, WantedPairs(problem, state, options, pairs), options.threads);
  result->points.covariance_m2 = std::move(found.points);
  result->pairs = std::move(found.pairs);
  result->parameter_covariance = std::move(found.parameters);
  if (HasFixedPaths(problem, options)) {
    result->points.fixed_path_covariance_m2 =
        SweepPoints(problem, state, nullptr, false, nullptr).covariance_m2;
  }
  for (const ParameterCovariance& c : result->parameter_covariance) {
    if (c.a == c.b) result->parameters[c.a].sigma = std::sqrt(c.covariance);
  }
}

}  // namespace

void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options) {
  if (Resolve(options.covariance_method) != CovarianceMethod::kCeres) return;
  const std::size_t unknowns = CountProblem(problem).parameters;
  if (unknowns <= kMaxCeresUnknowns) return;
  throw InputError("adjust.covariance_method",
                   "'ceres' is for blocks of at most " + std::to_string(kMaxCeresUnknowns) +
                       " unknowns, this one has " + std::to_string(unknowns) +
                       "; allowed: auto, reduced");
}

void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::optional<DatumTransform>& datum,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
                    AdjustResult* result) {
  if (options.covariance == CovarianceLevel::kNone) return;
  if (Resolve(options.covariance_method) == CovarianceMethod::kCeres) {
    FillCovarianceByCeres(problem, state, options, pairs, result);
    return;
  }
  const bool block_level = (options.covariance == CovarianceLevel::kBlock ||
                            options.covariance == CovarianceLevel::kMonteCarlo) &&
                           problem.layout.size() > 0;
  std::optional<CorrectionCovariance> inverse;
  if (block_level) {
    inverse = system.SelectedInverse();
    result->parameter_covariance = ParameterCovariances(system, *inverse);
    if (datum) datum->Transform(&result->parameter_covariance);
    for (const ParameterCovariance& c : result->parameter_covariance) {
      if (c.a == c.b) result->parameters[c.a].sigma = std::sqrt(c.covariance);
    }
  }
  const bool rigorous = options.covariance != CovarianceLevel::kLeberl;
  if (rigorous) {
    PointSweep sweep =
        SweepPoints(problem, state, inverse ? &*inverse : nullptr, true, progress, system.kept());
    if (datum && block_level) {
      datum->Transform(problem, state, &sweep.covariance_m2);
      for (std::vector<float>& shift_m : sweep.quality.shift_m) {
        std::fill(shift_m.begin(), shift_m.end(), std::numeric_limits<float>::quiet_NaN());
      }
    }
    result->control_quality = ControlQualities(problem, state, sweep.covariance_m2);
    result->points.covariance_m2 = std::move(sweep.covariance_m2);
    result->points.redundancy = std::move(sweep.redundancy);
    if (block_level && HasFixedPaths(problem, options)) {
      result->points.fixed_path_covariance_m2 = std::move(sweep.fixed_path_covariance_m2);
    }
    result->quality = std::move(sweep.quality);
  }
  if (options.pairs == PairChoice::kNone) return;
  const PointPairs wanted = WantedPairs(problem, state, options, pairs);
  result->pairs =
      rigorous ? PairCovariances(problem, state, block_level ? &system : nullptr, wanted, progress)
               : PairDifferences(problem, state, wanted);
  if (datum && block_level) datum->Transform(problem, state, &result->pairs);
}

}  // namespace sarblock
