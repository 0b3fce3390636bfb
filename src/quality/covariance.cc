// SPDX-License-Identifier: Apache-2.0
#include "covariance.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/text.h"
#include "core/threads.h"
#include "normals/back.h"
#include "point_sweep.h"
#include <Eigen/Cholesky>

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
    weight[at] = q.llt().solve(Eigen::Matrix3d(fixed_part.asDiagonal()));
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

/// Corrections that are screened, and the points that they are screened with; those that are formed
/// of more points, above a part that is far below one to tell of, and these points.
constexpr std::size_t kMaxScreened = 200, kPointsToScreen = 25;
constexpr std::size_t kMaxBends = 8, kPointsOfBends = 1000;
constexpr double kScreened = 0.02, kBendToTell = 0.1;

/// The part of one correction, of about so many points spread over the block.
double BendOf(const AdjustmentProblem& problem,
              const BlockState& state,
              const ReducedSystem& system,
              std::uint32_t parameter,
              std::size_t about_points) {
  const std::size_t points = problem.block.points.size();
  const std::size_t every = std::max<std::size_t>(1, points / about_points);
  const std::size_t taken = (points + every - 1) / every;
  const auto k = static_cast<Eigen::Index>(parameter);
  Eigen::VectorXd dx = system.SolveFor(Eigen::VectorXd::Unit(system.rows(), k));
  dx /= std::sqrt(dx[k]);
  return dx.dot(BendOfStep(problem, state, {}, 0.0, dx, every)) *
         (static_cast<double>(points) / static_cast<double>(taken));
}

void SortBends(std::vector<CorrectionBend>* bends) {
  std::stable_sort(
      bends->begin(), bends->end(), [](const CorrectionBend& a, const CorrectionBend& b) {
        return std::abs(a.part) > std::abs(b.part);
      });
}

}  // namespace

std::vector<CorrectionBend> BendsOfCorrections(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               const ReducedSystem& system,
                                               const std::vector<ParameterResult>& parameters) {
  // How much of what is known of it with all others known they leave.
  const auto dilution = [&](std::uint32_t k) {
    return parameters[k].sigma * std::sqrt(system.full_diagonal()[static_cast<Eigen::Index>(k)]);
  };
  std::vector<std::uint32_t> screened;
  for (std::uint32_t k = 0; k < parameters.size(); ++k) {
    if (std::isfinite(dilution(k))) screened.push_back(k);
  }
  std::stable_sort(screened.begin(), screened.end(), [&](std::uint32_t a, std::uint32_t b) {
    return dilution(a) > dilution(b);
  });
  screened.resize(std::min(screened.size(), kMaxScreened));
  std::vector<CorrectionBend> out;
  for (const std::uint32_t k : screened) {
    const double part = BendOf(problem, state, system, k, kPointsToScreen);
    if (std::isfinite(part)) out.push_back({k, part});
  }
  SortBends(&out);
  out.resize(std::min(out.size(), kMaxBends));
  for (CorrectionBend& bend : out) {
    if (std::abs(bend.part) < kScreened) continue;
    bend.part = BendOf(problem, state, system, bend.parameter, kPointsOfBends);
  }
  SortBends(&out);
  return out;
}

void WarnOfBends(AdjustResult* result) {
  if (result->bends.empty() || std::abs(result->bends.front().part) < kBendToTell) return;
  const CorrectionBend& worst = result->bends.front();
  const ParameterResult& parameter = result->parameters[worst.parameter];
  const auto rise = [&](double t) {
    const double root = t + worst.part * t * t;
    return Digits(root * root, 2);
  };
  Warn(result,
       "standard deviations of corrections are those of linear equations, and these are not linear "
       "so far: two of " +
           parameter.owner + " " + parameter.name + " (" + Digits(parameter.sigma, 2) + " " +
           parameter.unit + " each) raise v'Pv by " + rise(2.0) + " where it grows and by " +
           rise(-2.0) +
           " where it falls, in place of 4; fewer corrections, narrower priors or more control "
           "determine it better. Points may be good all the same");
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

std::array<Geodetic, kEllipseCorners> EllipseRing(const Frame& frame,
                                                  const Eigen::Vector3d& p_m,
                                                  const ErrorEllipse& ellipse) {
  const Eigen::Matrix3d frame_from_enu = frame.EnuFromFrame(p_m).transpose();
  const double centre_rad = frame.GeodeticFromFrame(p_m).lon_rad;
  const auto corners = EllipseCorners(ellipse);
  std::array<Geodetic, kEllipseCorners> ring;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    ring[i] = frame.GeodeticFromFrame(p_m + frame_from_enu.leftCols<2>() * corners[i]);
    ring[i].lon_rad =
        centre_rad + std::remainder(ring[i].lon_rad - centre_rad, 2.0 * std::numbers::pi);
  }
  return ring;
}

}  // namespace sarblock
