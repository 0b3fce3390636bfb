// SPDX-License-Identifier: Apache-2.0
#include "weak_directions.h"

#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/text.h"
#include "core/threads.h"
#include "geometry/track_axes.h"
#include "linear/dense.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Motions = Eigen::Matrix<double, 3, kMotions>;

/// Movement of an antenna at s by each motion, frame axes.
Motions MovementAt(const Eigen::Vector3d& arm_m, const Eigen::Matrix3d& enu) {
  Motions out;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d direction = enu.row(axis).transpose();
    out.col(axis) = direction;
    out.col(3 + axis) = direction.cross(arm_m);
  }
  out.col(6) = arm_m;
  return out;
}

/// The movement at a time of a pass in the axes of a correction.
Motions MovementInAxes(const AdjustmentProblem& problem,
                       std::uint32_t pass,
                       double time_s,
                       PositionCorrection::Axes axes,
                       const Eigen::Vector3d& middle_m,
                       const Eigen::Matrix3d& enu) {
  const FlightPath& path = problem.block.passes[pass].path;
  Motion motion;
  if (!path.Evaluate(std::clamp(time_s, path.start_s(), path.end_s()), &motion)) {
    return Motions::Zero();
  }
  const Motions moved = MovementAt(motion.position_m - middle_m, enu);
  if (axes == PositionCorrection::Axes::kFrame) return moved;
  return TrackAxesOf(problem.block.frame, motion).axes.transpose() * moved;
}

/// First parameter of a pass's own (not shared) static block and whether it has one.
int OwnOffset(const ParameterLayout& layout, std::uint32_t pass) {
  const PassCorrections& corrections = layout.passes[pass];
  for (const int block : corrections.blocks) {
    const ParameterBlock& b = layout.blocks[static_cast<std::size_t>(block)];
    if (!b.shared) return b.offset;
  }
  return -1;
}

int ColumnsBeforeOwn(const ParameterLayout& layout, std::uint32_t pass) {
  int columns = 0;
  for (const int block : layout.passes[pass].blocks) {
    const ParameterBlock& b = layout.blocks[static_cast<std::size_t>(block)];
    if (!b.shared) break;
    columns += b.size;
  }
  return columns;
}

}  // namespace

std::vector<int> PassOfParameters(const ParameterLayout& layout) {
  std::vector<int> pass_of(layout.parameters.size(), -1);
  const auto mark = [&](int block, std::size_t pass) {
    const ParameterBlock& b = layout.blocks[static_cast<std::size_t>(block)];
    if (b.shared) return;
    for (int i = 0; i < b.size; ++i) {
      pass_of[static_cast<std::size_t>(b.offset + i)] = static_cast<int>(pass);
    }
  };
  for (std::size_t pass = 0; pass < layout.passes.size(); ++pass) {
    for (const int block : layout.passes[pass].blocks) mark(block, pass);
    for (const SplineTerm& term : layout.passes[pass].splines) {
      for (std::size_t q = 0; q < term.spline.count(); ++q) {
        mark(term.first_block + static_cast<int>(q), pass);
      }
    }
  }
  return pass_of;
}

Eigen::MatrixXd RigidMotions(const AdjustmentProblem& problem,
                             const std::vector<int>& pass_of_parameter,
                             const std::vector<std::uint32_t>& passes) {
  const ParameterLayout& layout = problem.layout;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(layout.size(), kMotions);
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const std::uint32_t pass : passes) {
    const FlightPath& path = problem.block.passes[pass].path;
    middle_m += path.At(0.5 * (path.start_s() + path.end_s()))->position_m /
                static_cast<double>(passes.size());
  }
  const Eigen::Matrix3d enu = problem.block.frame.EnuFromFrame(middle_m);
  constexpr std::size_t kOrders = PositionCorrection::kMaxDegree + 1;
  std::array<double, kOrders> legendre{}, first_unused{}, second_unused{};
  for (const std::uint32_t pass : passes) {
    const PassCorrections& corrections = layout.passes[pass];
    const int own = OwnOffset(layout, pass), before = ColumnsBeforeOwn(layout, pass);
    bool carried = false;  // one term carries the movement
    for (const PolynomialTerm& term : corrections.polynomials) {
      if (carried || own < 0 || term.column < before) continue;
      carried = true;
      // Projection on Legendre polynomials by the midpoint rule; straight paths need degree 1.
      constexpr int kNodes = 64;
      const auto order = static_cast<std::size_t>(term.degree) + 1;
      for (int node = 0; node < kNodes; ++node) {
        const double x = (2.0 * node + 1.0) / kNodes - 1.0;
        LegendreValues(x,
                       {std::span<double>(legendre).first(order),
                        std::span<double>(first_unused).first(order),
                        std::span<double>(second_unused).first(order)});
        const Motions moved = MovementInAxes(problem,
                                             pass,
                                             corrections.middle_s + x * corrections.half_length_s,
                                             term.axes,
                                             middle_m,
                                             enu);
        int row = own + term.column - before;
        for (int axis = 0; axis < 3; ++axis) {
          if (!term.components[static_cast<std::size_t>(axis)]) continue;
          for (std::size_t k = 0; k < order; ++k) {
            out.row(row++) +=
                (2.0 * static_cast<double>(k) + 1.0) / kNodes * legendre[k] * moved.row(axis);
          }
        }
      }
    }
    for (const SplineTerm& term : corrections.splines) {
      const ParameterBlock& first = layout.blocks[static_cast<std::size_t>(term.first_block)];
      if (carried || first.shared) continue;
      carried = true;
      // Coefficient q of a uniform cubic spline belongs to the time of its own knot, q - 1 spacings
      // from the start: exact for linear functions.
      const double start_s = corrections.middle_s - corrections.half_length_s;
      for (std::size_t q = 0; q < term.spline.count(); ++q) {
        const double time_s = start_s + (static_cast<double>(q) - 1.0) * term.spline.spacing_s();
        const Motions moved = MovementInAxes(problem, pass, time_s, term.axes, middle_m, enu);
        int row = layout.blocks[static_cast<std::size_t>(term.first_block) + q].offset;
        for (int axis = 0; axis < 3; ++axis) {
          if (term.components[static_cast<std::size_t>(axis)]) out.row(row++) = moved.row(axis);
        }
      }
    }
  }
  // Ranges grow with the size; R = (1 + kappa) rho keeps them, and without a scale nothing does.
  bool scaled = false;
  for (std::size_t i = 0; i < layout.parameters.size(); ++i) {
    if (layout.parameters[i].kind != ParameterKind::kRangeScale) continue;
    const int pass = pass_of_parameter[i];
    const bool concerned =
        pass < 0 ||
        std::find(passes.begin(), passes.end(), static_cast<std::uint32_t>(pass)) != passes.end();
    if (concerned) out(static_cast<Eigen::Index>(i), 6) = -1.0;
    scaled = scaled || concerned;
  }
  if (!scaled) out.col(6).setZero();
  return out;
}

std::string NameMotion(const Eigen::Matrix<double, kMotions, 1>& part,
                       FrameKind frame,
                       const std::string& subject) {
  static constexpr std::array<std::array<const char*, 3>, 2> kAxes = {
      {{"x", "y", "z"}, {"east", "north", "up"}}};
  const auto& axes = kAxes[frame == FrameKind::kLocal ? 0 : 1];
  const auto listed = [&](int first) {
    const double most = part.segment<3>(first).cwiseAbs().maxCoeff();
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(part[first + axis]) < 0.2 * most) continue;
      text += (text.empty() ? "" : " and ") + std::string(axes[static_cast<std::size_t>(axis)]);
    }
    return text;
  };
  // A rotation about another line than that through the middle has a translation besides.
  if (part.segment<3>(3).norm() > 0.0) {
    const Eigen::Vector3d turn = part.segment<3>(3).normalized();
    const bool tilt = std::abs(turn[2]) < 0.5;
    return std::string(tilt ? "tilt" : "rotation") + " of " + subject + " about " + listed(3);
  }
  if (part.head<3>().norm() > 0.0) return "translation of " + subject + " in " + listed(0);
  return "scale of " + subject;
}

TargetEffects TargetEffectsOf(const AdjustmentProblem& problem, const std::vector<int>& pass_of) {
  const Block& block = problem.block;
  double sum_m = 0.0, speed_mps = 0.0, count = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (problem.look_used[i] == 0 || !std::isfinite(block.looks.range_m[i])) continue;
    sum_m += block.looks.range_m[i];
    count += 1.0;
  }
  for (const Pass& pass : block.passes) {
    speed_mps +=
        pass.path.states().front().velocity_mps.norm() / static_cast<double>(block.passes.size());
  }
  TargetEffects out;
  out.range_m = count > 0.0 ? sum_m / count : 0.0;
  out.metres = Eigen::VectorXd::Ones(problem.layout.size());
  for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
    const int pass = pass_of[i];
    double& metres = out.metres[static_cast<Eigen::Index>(i)];
    switch (problem.layout.parameters[i].kind) {
      case ParameterKind::kPosition:
      case ParameterKind::kRangeBias:
      case ParameterKind::kZenithDelay:
        break;
      case ParameterKind::kTimeBias:
        metres = pass < 0 ? speed_mps
                          : block.passes[static_cast<std::size_t>(pass)]
                                .path.states()
                                .front()
                                .velocity_mps.norm();
        break;
      case ParameterKind::kVelocityAcross:
      case ParameterKind::kVelocityUp:
      case ParameterKind::kRangeScale:
      case ParameterKind::kSquintBias:
        metres = out.range_m;
    }
  }
  return out;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A motion counts as weak where this much of its length lies in the weak subspace.
constexpr double kInside = 0.95;
/// More components than this are reported by the structure alone.
constexpr std::size_t kMaxComponents = 8;

MatrixXd Orthonormal(const MatrixXd& a) {
  if (a.cols() == 0) return a;
  return dense::PivotedOrthogonal(a).Basis();
}

/// Rows that distinguish the columns of q, which are orthonormal: each the longest after those
/// before it are projected out. They belong to the subspace and not to its basis; among rows that
/// are equal but for rounding the first is taken.
std::vector<Index> IndependentRows(const MatrixXd& q) {
  std::vector<Index> rows;
  MatrixXd left = q;
  for (Index k = 0; k < q.cols(); ++k) {
    const VectorXd lengths = left.rowwise().norm();
    Index longest = 0;
    for (Index i = 1; i < lengths.size(); ++i) {
      if (lengths[i] > lengths[longest] * (1.0 + 1e-6)) longest = i;
    }
    rows.push_back(longest);
    const VectorXd direction = left.row(longest).transpose() / lengths[longest];
    left -= (left * direction) * direction.transpose();
  }
  return rows;
}

/// Replaces the columns by the basis of their span in which each has a row where all others are
/// zero. The basis and its order depend only on the span.
void MakeEchelon(MatrixXd* a) {
  if (a->cols() == 0) return;
  const MatrixXd q = Orthonormal(*a);
  const std::vector<Index> rows = IndependentRows(q);
  MatrixXd head(q.cols(), q.cols());
  for (Index k = 0; k < q.cols(); ++k) head.row(k) = q.row(rows[static_cast<std::size_t>(k)]);
  *a = dense::PivotedOrthogonal(head.transpose()).Solve(q.transpose()).transpose();
}

/// The rigid motions of every connected component, in scaled parameters, columns of unit length or
/// zero.
struct Candidates {
  MatrixXd columns;
  VectorXd lengths;  // of the columns before
  std::vector<std::string> subject;
};

Candidates CandidatesOf(const AdjustmentProblem& problem,
                        const std::vector<int>& pass_of_parameter,
                        const VectorXd& scale) {
  std::vector<std::vector<std::uint32_t>> components = ConnectedComponents(problem);
  if (components.size() > kMaxComponents) components.resize(kMaxComponents);
  Candidates out;
  out.columns = MatrixXd::Zero(scale.size(), kMotions * static_cast<Index>(components.size()));
  out.lengths = VectorXd::Ones(out.columns.cols());
  for (std::size_t k = 0; k < components.size(); ++k) {
    std::vector<std::string> names;
    for (const std::uint32_t pass : components[k]) names.push_back(problem.block.passes[pass].id);
    out.subject.push_back(components.size() == 1 ? "the whole block"
                                                 : "the component of " + ListNames(names));
    out.columns.middleCols(kMotions * static_cast<Index>(k), kMotions) =
        scale.cwiseInverse().asDiagonal() * RigidMotions(problem, pass_of_parameter, components[k]);
  }
  for (Index c = 0; c < out.columns.cols(); ++c) {
    const double length = out.columns.col(c).norm();
    if (!(length > 0.0)) continue;
    out.columns.col(c) /= length;
    out.lengths[c] = length;
  }
  return out;
}

/// Mixtures of the candidates that lie in the subspace, by columns of coefficients.
MatrixXd MotionsInside(const Candidates& candidates, const MatrixXd& weak) {
  const dense::PivotedOrthogonal qr(candidates.columns, 1e-6);
  if (qr.rank() == 0) return MatrixXd(candidates.columns.cols(), 0);
  const MatrixXd q = qr.Basis();
  const dense::SingularValues svd = dense::DecomposeSingular(weak.transpose() * q);
  const Index inside = (svd.values.array() >= kInside).count();
  if (inside == 0) return MatrixXd(candidates.columns.cols(), 0);
  MatrixXd part = qr.Solve(q * svd.v.leftCols(inside));
  MakeEchelon(&part);
  return part;
}

}  // namespace

std::vector<NamedDirection> NameableBasis(const AdjustmentProblem& problem,
                                          const std::vector<int>& pass_of_parameter,
                                          const VectorXd& scale,
                                          const MatrixXd& weak) {
  std::vector<NamedDirection> out;
  if (weak.cols() == 0) return out;
  const MatrixXd space = Orthonormal(weak);
  const Candidates candidates = CandidatesOf(problem, pass_of_parameter, scale);
  const MatrixXd part = MotionsInside(candidates, space);
  MatrixXd taken(space.cols(), part.cols());
  for (Index k = 0; k < part.cols(); ++k) {
    taken.col(k) = space.transpose() * (candidates.columns * part.col(k));
    // The component with the largest part, and those of its motions that count.
    Index most = 0;
    part.col(k).cwiseAbs().maxCoeff(&most);
    const Index first = most / kMotions * kMotions;
    Eigen::Matrix<double, kMotions, 1> motion;
    for (Index i = 0; i < kMotions; ++i) {
      const double coefficient = part(first + i, k);
      const bool counts = std::abs(coefficient) >= 0.1 * std::abs(part(most, k));
      motion[i] = counts ? coefficient / candidates.lengths[first + i] : 0.0;
    }
    out.push_back({(space * taken.col(k)).normalized(),
                   NameMotion(motion,
                              problem.block.frame.kind(),
                              candidates.subject[static_cast<std::size_t>(most / kMotions)])});
  }
  MatrixXd rest = space;
  if (part.cols() > 0) {
    const MatrixXd q = Orthonormal(taken);
    rest = space * dense::Orthogonal(q).Q(q.rows()).rightCols(q.rows() - q.cols());
  }
  MakeEchelon(&rest);
  for (Index k = 0; k < rest.cols(); ++k) out.push_back({rest.col(k).normalized(), {}});
  return out;
}

namespace {

/// Families of parameters that do alike things to a look.
enum class Family { kAlong, kAcross, kUp, kFrame, kVelocity, kRange, kScale, kTime, kSquint, kAir };

struct Kind {
  Family family = Family::kFrame;
  std::string words;
};

std::string Number(double value) { return Digits(value, 3); }

Kind PositionKind(const Parameter& parameter) {
  constexpr std::array kOfTrack = {Family::kAlong, Family::kAcross, Family::kUp};
  const auto axis = static_cast<std::size_t>(parameter.axis);
  const bool track = parameter.axes == PositionCorrection::Axes::kTrack;
  Kind kind;
  kind.family = track ? kOfTrack[axis] : Family::kFrame;
  kind.words = std::string(track ? kTrackAxisNames[axis] : kFrameAxisNames[axis]) + " position (";
  if (parameter.spline) {
    kind.words += "spline)";
  } else {
    kind.words += parameter.degree == 0   ? "constant)"
                  : parameter.degree == 1 ? "drift)"
                                          : "degree " + std::to_string(parameter.degree) + ")";
  }
  return kind;
}

Kind KindOf(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::kPosition:
      break;
    case ParameterKind::kVelocityAcross:
      return {Family::kVelocity, "across direction of flight"};
    case ParameterKind::kVelocityUp:
      return {Family::kVelocity, "up direction of flight"};
    case ParameterKind::kRangeBias:
      return {Family::kRange, "range bias"};
    case ParameterKind::kRangeScale:
      return {Family::kScale, "range scale"};
    case ParameterKind::kTimeBias:
      return {Family::kTime, "time bias"};
    case ParameterKind::kSquintBias:
      return {Family::kSquint, "squint bias"};
    case ParameterKind::kZenithDelay:
      return {Family::kAir, "zenith delay"};
  }
  return PositionKind(parameter);
}

struct Meaning {
  std::string words, remedy;
};

/// What a mixture of parameters that is no rigid motion says.
Meaning MeaningOf(const std::set<Family>& has, std::size_t owners, bool alone) {
  const auto any = [&](std::initializer_list<Family> of) {
    return std::any_of(of.begin(), of.end(), [&](Family f) { return has.count(f) > 0; });
  };
  const bool sideways = any({Family::kAcross, Family::kUp, Family::kFrame});
  const bool forward = any({Family::kAlong, Family::kFrame});
  if (alone) {
    return {"hardly any look depends on it", "points that see it, a prior or leaving it out"};
  }
  if (has.count(Family::kTime) > 0 && forward) {
    return {"a time bias and a shift along track are the same to a straight flight",
            "leaving out one of the two or a prior for one; control does not help"};
  }
  if (has.count(Family::kRange) > 0 && sideways) {
    return {
        "not separable at one look angle: a narrow swath sees only the part along the line of "
        "sight",
        "a prior for the range bias, control from near to far range of a wide swath, or a pass "
        "from the other side"};
  }
  if (has.count(Family::kAir) > 0 && any({Family::kRange, Family::kScale, Family::kUp})) {
    return {"a delay hardly differs from a bias over the angles of incidence seen",
            "a prior for the zenith delay or leaving one of the two out"};
  }
  if (any({Family::kSquint, Family::kVelocity}) &&
      any({Family::kAlong, Family::kTime, Family::kFrame, Family::kSquint})) {
    return {"a turned cone is a shift along track at one range",
            "a prior for the squint or direction, control from near to far range, or leaving one "
            "of the two out"};
  }
  if (has.count(Family::kScale) > 0) {
    return {"a scale of the ranges acts as a height or size of the block",
            "a prior for the range scale, or control at different heights and ranges"};
  }
  if (owners == 1) {
    return {"too few points see this pass, or on too short a part of its strip",
            "points and control along all of the strip, a prior, or a lower degree"};
  }
  return {"the passes move with the points between them and no look contradicts",
          "control points where the points move most, a prior, or leaving a correction group out"};
}

Meaning MeaningOfMotion(const std::string& motion) {
  Meaning meaning{motion, {}};
  if (motion.rfind("translation", 0) == 0) {
    meaning.remedy = "a control point fixed in that direction";
  } else if (motion.rfind("scale", 0) == 0) {
    meaning.remedy = "two control points far apart";
  } else {
    meaning.remedy = "control points far apart and not on one line";
  }
  meaning.remedy += ", or a prior for the flight paths";
  return meaning;
}

}  // namespace

std::string DescribeDirection(const AdjustmentProblem& problem,
                              const std::vector<int>& pass_of_parameter,
                              const WeakDirection& direction) {
  const ParameterLayout& layout = problem.layout;
  std::vector<std::string> kinds;                             // the largest share first
  std::map<std::string, std::vector<std::string>> owners_of;  // by kind, in block order
  std::map<std::string, std::size_t> passes_of;
  std::set<std::string> owners;
  std::set<Family> families;
  std::vector<WeakParameter> in_order = direction.parameters;
  std::sort(in_order.begin(), in_order.end(), [](const auto& a, const auto& b) {
    return a.index < b.index;
  });
  const auto kind_of = [&](const WeakParameter& p) {
    return KindOf(layout.parameters[static_cast<std::size_t>(p.index)]);
  };
  for (const WeakParameter& parameter : direction.parameters) {
    const Kind kind = kind_of(parameter);
    families.insert(kind.family);
    if (std::find(kinds.begin(), kinds.end(), kind.words) == kinds.end()) {
      kinds.push_back(kind.words);
    }
  }
  for (const WeakParameter& parameter : in_order) {
    const std::string words = kind_of(parameter).words;
    const auto i = static_cast<std::size_t>(parameter.index);
    std::vector<std::string>& list = owners_of[words];
    owners.insert(layout.parameters[i].owner);
    if (!list.empty() && list.back() == layout.parameters[i].owner) continue;
    list.push_back(layout.parameters[i].owner);
    passes_of[words] += pass_of_parameter[i] >= 0 ? 1u : 0u;
  }
  constexpr std::size_t kKindsShown = 6;
  std::string text;
  for (std::size_t k = 0; k < std::min(kinds.size(), kKindsShown); ++k) {
    const bool own = passes_of[kinds[k]] == owners_of[kinds[k]].size();
    text += (k == 0 ? "" : " and ") + kinds[k] + " of " +
            ListNames(owners_of[kinds[k]], own ? layout.passes.size() : 0);
  }
  if (kinds.size() > kKindsShown) {
    text += " and " + std::to_string(kinds.size() - kKindsShown) + " more kinds";
  }
  const bool alone = direction.parameters.size() == 1;
  text += alone ? " is open" : " move together";
  const Meaning meaning = direction.motion.empty() ? MeaningOf(families, owners.size(), alone)
                                                   : MeaningOfMotion(direction.motion);
  text += ": " + meaning.words;
  if (!direction.undetermined) {
    const WeakParameter& first = direction.parameters.front();
    const Parameter& parameter = layout.parameters[static_cast<std::size_t>(first.index)];
    text += " (" + layout.Describe(first.index) + " has a standard deviation of " +
            Number(first.sigma) + " " + parameter.unit +
            (parameter.has_prior() ? ", its prior " + Number(parameter.prior_sigma)
                                   : std::string(" without a prior"));
    if (direction.correlation != 0.0) {
      text += ", correlation with " + layout.Describe(direction.parameters[1].index) + " " +
              Number(direction.correlation);
    }
    text += ", eigenvalue " + Number(direction.eigenvalue) + ")";
  }
  if (direction.moved_point) {
    text += ", most at " + std::string(problem.block.points.ids[*direction.moved_point]);
    if (!direction.undetermined) text += " by " + Number(direction.moved_m) + " m";
  }
  return text + "; removed by " + meaning.remedy;
}

namespace {

constexpr std::size_t kDefectsPerChunk = 1024;

/// Circles that cut at a sharper angle than this many sqrt(sigma / R) cannot touch within their
/// noise: the mirror solution is 3 standard deviations away at 1.7 (docs/theory/rank.md, section
/// 3).
constexpr double kThinAngle = 5.0;

bool CutsThin(const Eigen::Vector3d& p_m, const std::vector<FixedPathLook>& observations) {
  double largest = 0.0;
  for (const FixedPathLook& observation : observations) {
    largest = std::max(largest, observation.range_sigma_m / observation.range_m);
  }
  return LargestIntersectionAngle(p_m, observations) < kThinAngle * std::sqrt(largest);
}

/// The mirror image of p about the plane through two antennas along their flight lies where all
/// looks look, too.
bool MirrorFits(const Frame& frame,
                const Eigen::Vector3d& p_m,
                const std::vector<FixedPathLook>& observations) {
  const FixedPathLook* other = &observations.back();
  double most_m2 = 0.0;
  const FixedPathLook& first = observations.front();
  const Eigen::Vector3d u = first.velocity_mps.normalized();
  for (const FixedPathLook& observation : observations) {
    const double base_m2 = u.cross(observation.antenna_m - first.antenna_m).squaredNorm();
    if (base_m2 > most_m2) {
      most_m2 = base_m2;
      other = &observation;
    }
  }
  if (!(most_m2 > 0.0)) return false;
  const Eigen::Vector3d n = u.cross(other->antenna_m - first.antenna_m).normalized();
  const Eigen::Vector3d mirror_m = p_m - 2.0 * n.dot(p_m - first.antenna_m) * n;
  return std::all_of(
      observations.begin(), observations.end(), [&](const FixedPathLook& observation) {
        return LiesWhereItLooks(frame, observation, mirror_m);
      });
}

}  // namespace

PointDefects FindPointDefects(const AdjustmentProblem& problem, const BlockState& state) {
  const Block& block = problem.block;
  const std::size_t points = block.points.size();
  std::vector<IntersectionOutcome> outcome(points, IntersectionOutcome::kDetermined);
  const auto examine = [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<FixedPathLook> observations;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point) || problem.control_of[point] >= 0) continue;
      observations.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        if (const auto observation = problem.model.FixPath(i, state.corrections)) {
          observations.push_back(*observation);
        }
      }
      if (observations.size() < 2) continue;
      const Eigen::Vector3d p_m = state.Position(point);
      if (!CutsThin(p_m, observations) && !MirrorFits(block.frame, p_m, observations)) continue;
      outcome[point] = Intersect(observations, block.frame).outcome;
    }
  };
  ForChunksOfRanks(points, kDefectsPerChunk, {SharedArray::ByItem(&outcome)}, examine);
  PointDefects out;
  for (std::size_t point = 0; point < points; ++point) {
    switch (outcome[point]) {
      case IntersectionOutcome::kCirclesTouch:
        out.touching.push_back(point);
        break;
      case IntersectionOutcome::kCirclesCoincide:
        out.coinciding.push_back(point);
        break;
      case IntersectionOutcome::kAmbiguous:
        out.ambiguous.push_back(point);
        break;
      default:
        break;
    }
  }
  return out;
}

namespace {

/// A tie point's given coordinates choose between its two places; a check point's are withheld.
bool CoordinatesChoose(const Block& block, std::size_t point) {
  return block.points.given_m[point].allFinite() && block.points.role[point] != PointRole::kCheck;
}

}  // namespace

bool LeaveOutOpenPoints(const PointDefects& defects, AdjustmentProblem* problem) {
  bool any = !defects.touching.empty() || !defects.coinciding.empty();
  for (const std::size_t point : defects.touching) {
    problem->LeaveOut(
        point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kCirclesTouch));
  }
  for (const std::size_t point : defects.coinciding) {
    problem->LeaveOut(
        point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kCirclesCoincide));
  }
  for (const std::size_t point : defects.ambiguous) {
    if (CoordinatesChoose(problem->block, point)) continue;
    problem->LeaveOut(point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kAmbiguous));
    any = true;
  }
  return any;
}

std::vector<Finding> DescribePoints(const AdjustmentProblem& problem, const PointDefects& defects) {
  const IdTable& ids = problem.block.points.ids;
  std::vector<Finding> out;
  Finding left_out;
  std::map<std::string, std::vector<std::string>> by_reason;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) continue;
    left_out.names.emplace_back(ids[point]);
    by_reason[problem.point_reason[point]].emplace_back(ids[point]);
  }
  if (!left_out.names.empty()) {
    left_out.text = std::to_string(left_out.names.size()) + " of " +
                    std::to_string(problem.block.points.size()) +
                    " points are not determined and left out";
    for (const auto& [reason, names] : by_reason) {
      left_out.text += "; " + ListNames(names) + ": " + reason;
    }
    out.push_back(std::move(left_out));
  }
  if (!defects.ambiguous.empty()) {
    Finding mirrored;
    bool all_given = true;
    for (const std::size_t point : defects.ambiguous) {
      mirrored.names.emplace_back(ids[point]);
      all_given = all_given && CoordinatesChoose(problem.block, point);
    }
    mirrored.text = ListNames(mirrored.names) +
                    ": a mirror point satisfies the looks and their sides as well, " +
                    (all_given ? "only the given start coordinates chose between the two"
                               : "and nothing in the block chooses between the two") +
                    "; a third look or control has to decide";
    out.push_back(std::move(mirrored));
  }
  return out;
}

}  // namespace sarblock
