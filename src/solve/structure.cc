// SPDX-License-Identifier: Apache-2.0
#include "structure.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <set>

#include "core/text.h"
#include "geometry/track_axes.h"
#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

std::uint32_t RootOf(std::vector<std::uint32_t>* parent, std::uint32_t node) {
  while ((*parent)[node] != node) {
    (*parent)[node] = (*parent)[(*parent)[node]];
    node = (*parent)[node];
  }
  return node;
}

}  // namespace

bool PassConnection::IsKeptBy(const PassConnection& after) const {
  return after.components <= components && after.pass_has_looks == pass_has_looks;
}

PassConnection ConnectPasses(const AdjustmentProblem& problem) {
  const Looks& looks = problem.block.looks;
  const std::size_t passes = problem.block.passes.size();
  PassConnection out;
  out.pass_has_looks.assign(passes, 0);
  std::vector<std::uint32_t> parent(passes);
  std::iota(parent.begin(), parent.end(), 0U);
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    bool first = true;
    std::uint32_t joined = 0;
    for (std::uint64_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      const std::uint32_t pass = looks.pass[i];
      out.pass_has_looks[pass] = 1;
      if (first) joined = RootOf(&parent, pass);
      first = false;
      parent[RootOf(&parent, pass)] = joined;
    }
  }
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    if (out.pass_has_looks[pass] != 0 && parent[pass] == pass) ++out.components;
  }
  return out;
}

namespace {

/// Width over length below which points count as lying on one line.
constexpr double kLine = 0.02;
/// Control within this part of an area's length, at one end of it, lies on one side.
constexpr double kSide = 0.3;
/// Below this span of look angles 1, sin and cos are one function: 1 is distinguished from the best
/// a sin + b cos by span^2 / 27 only (docs/theory/rank.md, section 1).
constexpr double kNarrow_rad = 5.0 * kRadPerDeg;

/// Which parameters of a pass have no prior, by what they do.
struct FreeParameters {
  int count = 0;  ///< own ones, shared by no other pass
  /// Axes whose constant part is free: along, across, up of the track; x, y, z of the frame.
  std::array<bool, 3> track{}, frame{};
  bool time = false, range = false;
  [[nodiscard]] bool Axis(std::size_t of_track) const {
    return track[of_track] || (frame[0] && frame[1] && frame[2]);
  }
  [[nodiscard]] std::size_t Axes() const {
    return static_cast<std::size_t>(std::count(track.begin(), track.end(), true) +
                                    std::count(frame.begin(), frame.end(), true));
  }
};

FreeParameters FreeOf(const ParameterLayout& layout, std::size_t pass) {
  FreeParameters out;
  const auto add = [&](int block, bool constant_part) {
    const ParameterBlock& b = layout.blocks[static_cast<std::size_t>(block)];
    for (int i = 0; i < b.size; ++i) {
      const Parameter& parameter = layout.parameters[static_cast<std::size_t>(b.offset + i)];
      if (parameter.has_prior()) continue;
      out.count += b.shared ? 0 : 1;
      if (parameter.kind == ParameterKind::kTimeBias) out.time = true;
      if (parameter.kind == ParameterKind::kRangeBias) out.range = true;
      if (parameter.kind != ParameterKind::kPosition) continue;
      if (!constant_part && parameter.degree != 0) continue;
      const bool of_track = parameter.axes == PositionCorrection::Axes::kTrack;
      (of_track ? out.track : out.frame)[static_cast<std::size_t>(parameter.axis)] = true;
    }
  };
  for (const int block : layout.passes[pass].blocks) add(block, false);
  for (const SplineTerm& term : layout.passes[pass].splines) {
    for (std::size_t q = 0; q < term.spline.count(); ++q) {
      add(term.first_block + static_cast<int>(q), true);
    }
  }
  return out;
}

/// Length, width and height of a cloud of points (square roots of the scatter's eigenvalues,
/// descending), its middle and axes.
struct Extent {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  [[nodiscard]] bool IsOnLine() const { return size_m[1] <= kLine * size_m[0]; }
};

Extent ExtentOf(const BlockState& state, const std::vector<std::size_t>& points) {
  Extent out;
  for (const std::size_t point : points) {
    out.middle_m += state.Position(point) / static_cast<double>(points.size());
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t point : points) {
    const Eigen::Vector3d d = state.Position(point) - out.middle_m;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  out.size_m = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
  out.axes = eigen.eigenvectors().rowwise().reverse();
  return out;
}

/// A connected component and its datum.
struct ConnectedPasses {
  std::vector<std::uint32_t> passes;
  std::vector<std::size_t> points, control;
  std::array<int, 3> fixed{};  ///< control components east, north, up
  std::size_t free_axes = 3;   ///< least number of free axes over its passes
  std::string name;
};

std::vector<std::string> NamesOf(const Block& block, const std::vector<std::uint32_t>& passes) {
  std::vector<std::string> names;
  for (const std::uint32_t pass : passes) names.push_back(block.passes[pass].id);
  return names;
}

std::vector<ConnectedPasses> DescribeComponents(const AdjustmentProblem& problem,
                                                const std::vector<FreeParameters>& free) {
  const Block& block = problem.block;
  std::vector<ConnectedPasses> out;
  std::vector<std::size_t> component_of_pass(block.passes.size(), 0);
  for (std::vector<std::uint32_t>& passes : ConnectedComponents(problem)) {
    ConnectedPasses connected;
    for (const std::uint32_t pass : passes) {
      component_of_pass[pass] = out.size();
      connected.free_axes = std::min(connected.free_axes, free[pass].Axes());
    }
    connected.name = "the component of " + ListNames(NamesOf(block, passes));
    connected.passes = std::move(passes);
    out.push_back(std::move(connected));
  }
  if (out.size() == 1) out[0].name = "the block";
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    for (auto i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      ConnectedPasses& connected = out[component_of_pass[block.looks.pass[i]]];
      connected.points.push_back(point);
      if (problem.control_of[point] >= 0) {
        connected.control.push_back(point);
        const KnownPosition* known = block.points.FindKnown(static_cast<std::uint32_t>(point));
        for (std::size_t axis = 0; known != nullptr && axis < 3; ++axis) {
          connected.fixed[axis] += known->fixed[axis] ? 1 : 0;
        }
      }
      break;
    }
  }
  return out;
}

std::vector<std::string> PointNames(const Block& block, const std::vector<std::size_t>& points) {
  std::vector<std::string> names;
  for (const std::size_t point : points) names.emplace_back(block.points.ids[point]);
  return names;
}

/// Control at one end of the area of a component.
bool ControlIsOnOneSide(const BlockState& state, const ConnectedPasses& connected) {
  const Extent area = ExtentOf(state, connected.points);
  for (int axis = 0; axis < 2; ++axis) {
    const auto span = [&](const std::vector<std::size_t>& points) {
      std::array<double, 2> range_m = {std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity()};
      for (const std::size_t point : points) {
        const double at_m = area.axes.col(axis).dot(state.Position(point) - area.middle_m);
        range_m = {std::min(range_m[0], at_m), std::max(range_m[1], at_m)};
      }
      return range_m;
    };
    const auto all_m = span(connected.points), control_m = span(connected.control);
    const double length_m = all_m[1] - all_m[0];
    if (control_m[1] < all_m[0] + kSide * length_m || control_m[0] > all_m[1] - kSide * length_m) {
      return true;
    }
  }
  return false;
}

/// Datum findings of a component whose passes are all free.
void ExamineDatum(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const ConnectedPasses& connected,
                  std::vector<Finding>* out) {
  const Block& block = problem.block;
  const auto add = [&](const std::string& text, std::vector<std::string> names) {
    out->push_back({text, std::move(names)});
  };
  if (connected.free_axes == 0) return;  // a fixed pass fixes the rest
  const std::vector<std::string> passes = NamesOf(block, connected.passes);
  if (connected.control.empty()) {
    add("nothing fixes the position of " + connected.name +
            ": it has no control point, and no pass of it (" + ListNames(passes) +
            ") has priors for its position or goes without corrections; it needs control or priors",
        passes);
    return;
  }
  if (connected.free_axes < 2) return;
  const std::vector<std::string> control = PointNames(block, connected.control);
  const std::string fixed = " holds " + connected.name + " without priors for its passes";
  if (connected.control.size() == 1) {
    add("a single control point (" + control[0] + ")" + fixed +
            ": rotations about it are open; it needs three that are not on one line",
        control);
  } else if (ExtentOf(state, connected.control).IsOnLine()) {
    add("control on one line (" + ListNames(control) + ")" + fixed +
            ": the tilt about this line is open; it needs a control point beside the line",
        control);
  } else if (ControlIsOnOneSide(state, connected)) {
    add("control on one side (" + ListNames(control) + ")" + fixed +
            ": errors grow towards the other side; it needs control there",
        control);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (connected.fixed[axis] > 0) continue;
    static constexpr std::array<const char*, 3> kNames = {"east", "north", "up"};
    add("no control point of " + connected.name + " (" + ListNames(control) + ") is fixed in " +
            kNames[axis] + ": its translation there is open",
        control);
  }
}

/// One point, or all of them on one line.
void ExaminePoints(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const ConnectedPasses& connected,
                   std::vector<Finding>* out) {
  const auto add = [&](const std::string& before, const std::string& after) {
    std::vector<std::string> names = PointNames(problem.block, connected.points);
    out->push_back({before + ListNames(names) + after, std::move(names)});
  };
  if (connected.points.size() == 1) {
    add("a single point (",
        ") connects " + ListNames(NamesOf(problem.block, connected.passes)) +
            ": it cannot determine corrections without a prior; it needs more points");
  } else if (connected.points.size() > 1 && connected.free_axes >= 2 &&
             ExtentOf(state, connected.points).IsOnLine()) {
    add("all points of " + connected.name + " lie on one line (",
        "): the tilt about it is open; it needs points beside the line");
  }
}

/// Equations that the looks of each pass can give about it, at most.
std::vector<int> EquationsOf(const AdjustmentProblem& problem) {
  const Looks& looks = problem.block.looks;
  std::vector<int> out(problem.block.passes.size(), 0);
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    const int control = problem.control_of[point];
    const int rows = control < 0 ? 0 : problem.control[static_cast<std::size_t>(control)].rows;
    const int spare = 2 * problem.CountLooks(point) + rows - 3;
    for (auto i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] != 0) out[looks.pass[i]] += std::clamp(spare, 0, 2);
    }
  }
  return out;
}

/// Look angles off nadir, from and to, of every pass.
std::vector<std::array<double, 2>> LookAngles(const AdjustmentProblem& problem,
                                              const BlockState& state) {
  const Block& block = problem.block;
  std::vector<std::array<double, 2>> out(block.passes.size(), {kNotGiven, kNotGiven});
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    for (auto i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      Motion motion;
      const Pass& pass = block.passes[block.looks.pass[i]];
      if (problem.look_used[i] == 0 || !pass.path.Evaluate(block.looks.time_s[i], &motion)) {
        continue;
      }
      const Eigen::Vector3d d = TrackAxesOf(block.frame, motion).axes.transpose() *
                                (state.Position(point) - motion.position_m);
      const double angle_rad = std::atan2(std::abs(d[1]), -d[2]);
      std::array<double, 2>& span = out[block.looks.pass[i]];
      span = {std::fmin(span[0], angle_rad), std::fmax(span[1], angle_rad)};
    }
  }
  return out;
}

/// Corrections that each pass by itself cannot separate.
void ExaminePasses(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const std::vector<FreeParameters>& free,
                   std::vector<Finding>* out) {
  const Block& block = problem.block;
  const std::vector<int> equations = EquationsOf(problem);
  std::vector<std::string> both, narrow;
  std::vector<std::size_t> candidates;
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const std::string& id = block.passes[pass].id;
    if (free[pass].count > equations[pass]) {
      out->push_back({"too few points see pass " + id + ": they give at most " +
                          std::to_string(equations[pass]) + " equations for its " +
                          std::to_string(free[pass].count) +
                          " corrections without a prior; it needs points, priors or fewer "
                          "corrections",
                      {id}});
    }
    if (free[pass].time && free[pass].Axis(0)) both.push_back(id);
    if (free[pass].range && free[pass].Axis(1) && free[pass].Axis(2)) {
      candidates.push_back(pass);
    }
  }
  if (!both.empty()) {
    out->push_back({"time bias and along-track position of " +
                        ListNames(both, block.passes.size()) +
                        " are both free: the same to a straight flight; leave out one or give it a "
                        "prior",
                    both});
  }
  if (candidates.empty()) return;
  const std::vector<std::array<double, 2>> angles_rad = LookAngles(problem, state);
  for (const std::size_t pass : candidates) {
    if (angles_rad[pass][1] - angles_rad[pass][0] >= kNarrow_rad) continue;
    narrow.push_back(block.passes[pass].id);
  }
  if (!narrow.empty()) {
    out->push_back({"range bias, across and up position of " +
                        ListNames(narrow, block.passes.size()) +
                        " are all free on a swath of less than 5 degrees of look angle: not "
                        "separable; give the range bias a prior or use a wider swath",
                    narrow});
  }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> ConnectedComponents(const AdjustmentProblem& problem) {
  const Block& block = problem.block;
  const std::size_t passes = block.passes.size();
  std::vector<std::uint32_t> root(passes);
  std::iota(root.begin(), root.end(), 0U);
  std::vector<bool> seen(passes, false);
  const auto find = [&](std::uint32_t pass) {
    while (root[pass] != pass) pass = root[pass] = root[root[pass]];
    return pass;
  };
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    std::uint32_t first = 0;
    bool any = false;
    for (auto i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      const std::uint32_t pass = find(block.looks.pass[i]);
      seen[block.looks.pass[i]] = true;
      first = any ? std::min(first, pass) : pass;
      any = true;
      root[pass] = first;
    }
    // The smallest root may have come last.
    for (auto i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] != 0) root[find(block.looks.pass[i])] = first;
    }
  }
  std::vector<std::vector<std::uint32_t>> out;
  std::vector<std::size_t> index(passes, passes);
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    if (!seen[pass]) continue;
    std::size_t& connected = index[find(pass)];
    if (connected == passes) {
      connected = out.size();
      out.emplace_back();
    }
    out[connected].push_back(pass);
  }
  return out;
}

std::vector<Finding> ExamineStructure(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<Finding> out;
  const ParameterLayout& layout = problem.layout;
  if (layout.size() == 0) return out;  // every point is independent
  std::vector<FreeParameters> free;
  bool any = false;
  for (std::size_t pass = 0; pass < layout.passes.size(); ++pass) {
    free.push_back(FreeOf(layout, pass));
    any = any || free.back().count > 0;
  }
  const std::vector<ConnectedPasses> components = DescribeComponents(problem, free);
  if (components.size() > 1) {
    Finding finding;
    finding.text = "the block falls into " + std::to_string(components.size()) +
                   " components that no point connects:";
    for (const ConnectedPasses& connected : components) {
      const std::vector<std::string> names = NamesOf(problem.block, connected.passes);
      finding.text += (finding.names.empty() ? " " : " | ") + ListNames(names);
      finding.names.insert(finding.names.end(), names.begin(), names.end());
    }
    finding.text += "; points seen from both would connect them";
    out.push_back(std::move(finding));
  }
  for (const ConnectedPasses& connected : components) {
    ExamineDatum(problem, state, connected, &out);
    if (any) ExaminePoints(problem, state, connected, &out);
  }
  ExaminePasses(problem, state, free, &out);
  return out;
}

}  // namespace sarblock
