// SPDX-License-Identifier: Apache-2.0
#include "rigid_motions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/track_axes.h"
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
  return TrackAxesOf(problem.block.frame, motion).axes_1.transpose() * moved;
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
      // Coefficient q of a uniform cubic spline stands for the time of its own knot, q - 1 spacings
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
                       const std::string& whose) {
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
    return std::string(tilt ? "tilt" : "rotation") + " of " + whose + " about " + listed(3);
  }
  if (part.head<3>().norm() > 0.0) return "translation of " + whose + " in " + listed(0);
  return "scale of " + whose;
}

}  // namespace sarblock
