// SPDX-License-Identifier: Apache-2.0
#include "weak_words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/text.h"
#include "geometry/track_axes.h"

namespace sarblock {
namespace {

/// Families of parameters that do alike things to a look.
enum class Family { kAlong, kAcross, kUp, kFrame, kVelocity, kRange, kScale, kTime, kSquint, kAir };

struct Kind {
  Family family = Family::kFrame;
  std::string words;
};

std::string Number(double value) { return Digits(value, 3); }

Kind OfPosition(const Parameter& parameter) {
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
  return OfPosition(parameter);
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
    return {"hardly any look tells of it", "points that see it, a prior or leaving it out"};
  }
  if (has.count(Family::kTime) > 0 && forward) {
    return {"a time bias and a shift along track are the same to a straight flight",
            "leaving out one of the two or a prior for one; control does not help"};
  }
  if (has.count(Family::kRange) > 0 && sideways) {
    return {"not separable at one look angle: a narrow swath sees only the part along the sight",
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
    meaning.remedy = "a control point held in that direction";
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
  text += alone ? " stands open" : " move together";
  const Meaning meaning = direction.motion.empty() ? MeaningOf(families, owners.size(), alone)
                                                   : MeaningOfMotion(direction.motion);
  text += ": " + meaning.words;
  if (!direction.undetermined || std::isfinite(direction.parameters.front().sigma)) {
    const WeakParameter& first = direction.parameters.front();
    const Parameter& parameter = layout.parameters[static_cast<std::size_t>(first.index)];
    text += " (" + layout.Describe(first.index) + " has a standard deviation of " +
            Number(first.sigma) + " " + parameter.unit +
            (parameter.has_prior() ? ", its prior " + Number(parameter.prior_sigma)
                                   : std::string(" without a prior"));
    if (direction.correlation_1 != 0.0) {
      text += ", correlation with " + layout.Describe(direction.parameters[1].index) + " " +
              Number(direction.correlation_1);
    }
    text += ", eigenvalue " + Number(direction.eigenvalue_1) + ")";
  }
  if (direction.moved_point) {
    text += ", most at " + std::string(problem.block.points.ids[*direction.moved_point]);
    if (!direction.undetermined) text += " by " + Number(direction.moved_m) + " m";
  }
  return text + "; removed by " + meaning.remedy;
}

}  // namespace sarblock
