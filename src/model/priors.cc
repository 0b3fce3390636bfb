// SPDX-License-Identifier: Apache-2.0
#include "priors.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>
#include <variant>

#include "geometry/track_axes.h"
#include "linear/dense.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

double PriorOf(const PositionCorrection& position, std::size_t axis, std::size_t degree) {
  const std::vector<double>& sigma_m = position.prior_sigma_m[axis];
  if (sigma_m.empty()) return kNotGiven;
  return sigma_m.size() == 1 ? sigma_m[0] : sigma_m[degree];
}

Parameter MakeParameter(ParameterKind kind,
                        const char* name,
                        const char* unit,
                        double prior_sigma) {
  Parameter out;
  out.kind = kind;
  out.name = name;
  out.unit = unit;
  out.prior_sigma = prior_sigma;
  return out;
}

}  // namespace

const std::array<const char*, 3>& AxisNamesOf(PositionCorrection::Axes axes) {
  return axes == PositionCorrection::Axes::kTrack ? kTrackAxisNames : kFrameAxisNames;
}

Parameter PositionParameter(const PositionCorrection& position,
                            std::size_t axis,
                            std::size_t degree) {
  Parameter out;
  out.name =
      std::string("position.") + AxisNamesOf(position.axes)[axis] + "." + std::to_string(degree);
  out.unit = "m";
  out.prior_sigma = PriorOf(position, axis, degree);
  out.axes = position.axes;
  out.axis = static_cast<int>(axis);
  out.degree = static_cast<int>(degree);
  out.spline = position.basis == PositionCorrection::Basis::kSpline;
  return out;
}

bool HasProcess(const CorrectionGroup& group) {
  const auto* position = std::get_if<PositionCorrection>(&group.model);
  return position != nullptr && position->process != PositionCorrection::Process::kWhite;
}

void SetProcess(const PositionCorrection& position,
                double spacing_s,
                std::size_t count,
                int before,
                Parameter* coefficient) {
  using Process = PositionCorrection::Process;
  if (position.process == Process::kWhite || !coefficient->has_prior()) return;
  const double sigma_m = coefficient->prior_sigma;
  if (position.process == Process::kGaussMarkov) {
    const double steps = spacing_s / position.correlation_time_s;
    coefficient->carried = std::exp(-steps);
    coefficient->step_sigma = sigma_m * std::sqrt(-std::expm1(-2.0 * steps));
  } else {
    const double start_m = position.start_sigma_m[static_cast<std::size_t>(coefficient->axis)];
    coefficient->carried = 1.0;
    coefficient->step_sigma = sigma_m / std::sqrt(static_cast<double>(count - 1));
    coefficient->prior_sigma =
        std::hypot(start_m, std::sqrt(coefficient->degree) * coefficient->step_sigma);
  }
  if (coefficient->degree > 0) coefficient->before = before;
}

std::vector<Parameter> ParametersOf(const CorrectionGroup& group) {
  std::vector<Parameter> out;
  const auto add = [&out](ParameterKind kind, const char* name, const char* unit, double sigma) {
    out.push_back(MakeParameter(kind, name, unit, sigma));
  };
  if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
    if (position->basis == PositionCorrection::Basis::kSpline) return out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!position->components[axis]) continue;
      for (std::size_t k = 0; k <= static_cast<std::size_t>(position->degree); ++k) {
        out.push_back(PositionParameter(*position, axis, k));
      }
    }
  } else if (const auto* velocity = std::get_if<VelocityCorrection>(&group.model)) {
    const auto& sigma = velocity->prior_sigma;
    if (velocity->components[0]) {
      add(ParameterKind::kVelocityAcross, "velocity.across", "1", sigma[0]);
    }
    if (velocity->components[1]) add(ParameterKind::kVelocityUp, "velocity.up", "1", sigma[1]);
  } else if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
    if (range->bias) {
      add(ParameterKind::kRangeBias, "range.bias", "m", range->bias_prior_sigma_m);
    }
    if (range->scale) {
      add(ParameterKind::kRangeScale, "range.scale", "1", range->scale_prior_sigma);
    }
  } else if (const auto* time = std::get_if<TimeCorrection>(&group.model)) {
    add(ParameterKind::kTimeBias, "time.bias", "s", time->bias_prior_sigma_s);
  } else if (const auto* squint = std::get_if<SquintCorrection>(&group.model)) {
    add(ParameterKind::kSquintBias, "squint.bias", "rad", squint->bias_prior_sigma_rad);
  } else if (const auto* air = std::get_if<TroposphereCorrection>(&group.model)) {
    add(ParameterKind::kZenithDelay, "troposphere.zenith", "m", air->zenith_prior_sigma_m);
  }
  if (out.empty()) {
    throw InputError("correction." + group.name, "has no parameter, switch one on");
  }
  return out;
}

namespace {

constexpr std::array<const char*, 3> kRicAxisNames = {"radial", "in-track", "cross-track"};
constexpr double kSymmetric = 1e-9;
/// Least variance; its inverse is the largest. Both keep their digits in products with others.
constexpr double kMinVariance = 1e-120;

std::string ShortText(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

const std::array<const char*, 3>& NamesOf(JointPrior::Axes axes) {
  switch (axes) {
    case JointPrior::Axes::kTrack:
      return kTrackAxisNames;
    case JointPrior::Axes::kFrame:
      return kFrameAxisNames;
    default:
      return kRicAxisNames;
  }
}

JointPrior::Axes AxesOf(PositionCorrection::Axes axes) {
  return axes == PositionCorrection::Axes::kTrack ? JointPrior::Axes::kTrack
                                                  : JointPrior::Axes::kFrame;
}

/// What a pass has to give a prior to.
struct PassParameters {
  std::vector<Parameter> own;
  std::set<std::string> shared;
  bool spline = false;
  std::optional<PositionCorrection::Axes> axes;  // of its own polynomials

  [[nodiscard]] int IndexOf(const std::string& name) const {
    const auto found =
        std::find_if(own.begin(), own.end(), [&](const Parameter& p) { return p.name == name; });
    return found == own.end() ? -1 : static_cast<int>(found - own.begin());
  }
};

PassParameters ParametersOfPass(const std::string& id, const std::vector<CorrectionGroup>& groups) {
  PassParameters out;
  for (const CorrectionGroup& group : groups) {
    if (!group.passes.empty() &&
        std::find(group.passes.begin(), group.passes.end(), id) == group.passes.end()) {
      continue;
    }
    const auto* position = std::get_if<PositionCorrection>(&group.model);
    if (position != nullptr && position->basis == PositionCorrection::Basis::kSpline) {
      out.spline = true;
      continue;
    }
    for (Parameter& parameter : ParametersOf(group)) {
      if (group.shared) {
        out.shared.insert(parameter.name);
      } else {
        if (position != nullptr) out.axes = position->axes;
        out.own.push_back(std::move(parameter));
      }
    }
  }
  return out;
}

/// Binds one prior to the parameters of one pass.
class Binder {
 public:
  Binder(const JointPrior& prior, const std::string& pass, const PassParameters& of)
      : prior_(prior), pass_(pass), of_(of) {}

  /// How many of its parameters the pass has.
  [[nodiscard]] std::size_t CountFound() const {
    std::size_t found = 0;
    for (const std::string& name : prior_.parameters) {
      found += of_.IndexOf(NameInPass(name)) >= 0 ? 1U : 0U;
    }
    return found;
  }

  [[nodiscard]] std::optional<JointPriorProblem> Bind(std::vector<int>* parameters) const {
    if (auto problem = NameInOtherAxes()) return problem;
    for (std::size_t i = 0; i < prior_.parameters.size(); ++i) {
      const std::string name = NameInPass(prior_.parameters[i]);
      const int index = of_.IndexOf(name);
      if (index < 0) return Problem("parameters", i, Missing(prior_.parameters[i], name));
      if (of_.own[static_cast<std::size_t>(index)].has_prior()) {
        return Problem("parameters",
                       i,
                       "'" + prior_.parameters[i] + "' of pass '" + pass_ +
                           "' has a standard deviation of its own in its correction, one of both "
                           "is allowed");
      }
      parameters->push_back(index);
    }
    return IncompleteTurn();
  }

 private:
  [[nodiscard]] bool Turned() const {
    return prior_.axes != JointPrior::Axes::kCorrection && of_.axes &&
           prior_.axes != AxesOf(*of_.axes);
  }

  /// The parameter of the pass in place of one that is named in other axes.
  [[nodiscard]] std::string NameInPass(const std::string& name) const {
    if (!Turned()) return name;
    const auto position = ParsePositionName(name, prior_.axes);
    if (!position) return name;
    const auto axis = static_cast<std::size_t>(position->axis);
    return std::string("position.") + AxisNamesOf(*of_.axes)[axis] + "." +
           std::to_string(position->degree);
  }

  [[nodiscard]] std::string Missing(const std::string& name, const std::string& in_pass) const {
    if (of_.shared.contains(in_pass)) {
      return "'" + name + "' of pass '" + pass_ +
             "' is shared with other passes; allowed are parameters of the pass alone";
    }
    std::string spline;
    if (of_.spline && name.starts_with("position.")) {
      spline = " (coefficients of a spline have no joint prior)";
    }
    std::vector<std::string> names;
    for (const Parameter& parameter : of_.own) names.push_back(parameter.name);
    std::string allowed;
    for (const std::string& own : names) allowed += (allowed.empty() ? "" : ", ") + own;
    const std::string nearest = Turned() ? std::string() : NearestName(name, names);
    return "pass '" + pass_ + "' has no parameter '" + name + "'" + spline +
           (allowed.empty() ? ", it has none of its own" : ", allowed are " + allowed) +
           DidYouMean(nearest);
  }

  /// A position parameter that is not named in the axes given.
  [[nodiscard]] std::optional<JointPriorProblem> NameInOtherAxes() const {
    if (prior_.axes == JointPrior::Axes::kCorrection) return std::nullopt;
    const auto& names = NamesOf(prior_.axes);
    for (std::size_t i = 0; i < prior_.parameters.size(); ++i) {
      const std::string& name = prior_.parameters[i];
      if (!name.starts_with("position.") || ParsePositionName(name, prior_.axes)) continue;
      return Problem("parameters",
                     i,
                     "'" + name + "' is no degree along the axes given, whose names are " +
                         names[0] + ", " + names[1] + " and " + names[2]);
    }
    return std::nullopt;
  }

  /// Other axes than those of the correction need all three of a degree.
  [[nodiscard]] std::optional<JointPriorProblem> IncompleteTurn() const {
    if (!Turned()) return std::nullopt;
    std::vector<int> count(PositionCorrection::kMaxDegree + 1, 0);
    for (const std::string& name : prior_.parameters) {
      const auto position = ParsePositionName(name, prior_.axes);
      if (position) ++count[static_cast<std::size_t>(position->degree)];
    }
    for (std::size_t degree = 0; degree < count.size(); ++degree) {
      if (count[degree] == 0 || count[degree] == 3) continue;
      return JointPriorProblem{
          0,
          "parameters",
          -1,
          "degree " + std::to_string(degree) + " of the position has " +
              std::to_string(count[degree]) +
              " axes; all three are needed to turn them into the axes of the correction"};
    }
    return std::nullopt;
  }

  [[nodiscard]] static JointPriorProblem Problem(const char* field,
                                                 std::size_t entry,
                                                 std::string problem) {
    return {0, field, static_cast<int>(entry), std::move(problem)};
  }

  const JointPrior& prior_;
  const std::string& pass_;
  const PassParameters& of_;
};

std::optional<JointPriorProblem> FindMatrixProblem(const JointPrior& prior) {
  const bool covariance = !prior.covariance.empty();
  if (!covariance && prior.sigma.empty()) {
    return JointPriorProblem{
        0, "covariance", -1, "is not given, a matrix, or sigma with correlation, is needed"};
  }
  if (covariance && (!prior.sigma.empty() || !prior.correlation.empty())) {
    return JointPriorProblem{
        0, "covariance", -1, "excludes sigma and correlation; give one of both"};
  }
  if (covariance) {
    const auto problem = FindCovarianceProblem(prior.parameters, prior.covariance.matrix());
    if (problem) return JointPriorProblem{0, "covariance", -1, *problem};
    return std::nullopt;
  }
  if (prior.sigma.size() != prior.parameters.size()) {
    return JointPriorProblem{0,
                             "sigma",
                             -1,
                             "has " + std::to_string(prior.sigma.size()) + " entries, one a " +
                                 "parameter is needed: " + std::to_string(prior.parameters.size())};
  }
  for (std::size_t i = 0; i < prior.sigma.size(); ++i) {
    const double square = prior.sigma[i] * prior.sigma[i];
    if (prior.sigma[i] > 0.0 && square >= kMinVariance && square <= 1.0 / kMinVariance) {
      continue;
    }
    return JointPriorProblem{0,
                             "sigma",
                             static_cast<int>(i),
                             "must be a number above 0, got " + ShortText(prior.sigma[i])};
  }
  if (prior.correlation.empty()) return std::nullopt;
  const auto problem = FindCovarianceProblem(prior.parameters, prior.correlation.matrix());
  if (problem) return JointPriorProblem{0, "correlation", -1, *problem};
  for (std::size_t i = 0; i < prior.correlation.rows; ++i) {
    if (prior.correlation(i, i) == 1.0) continue;
    return JointPriorProblem{
        0,
        "correlation",
        static_cast<int>(i),
        "has " + ShortText(prior.correlation(i, i)) + " on its diagonal, 1 is needed there"};
  }
  return std::nullopt;
}

}  // namespace

DenseMatrix JointPrior::Covariance() const {
  if (!covariance.empty()) return covariance;
  const Eigen::Map<const Eigen::VectorXd> s(sigma.data(), static_cast<Eigen::Index>(sigma.size()));
  if (correlation.empty()) return s.cwiseAbs2().asDiagonal();
  return s.asDiagonal() * correlation.matrix() * s.asDiagonal();
}

void JointPriorTerm::Set(const Eigen::MatrixXd& q) {
  // Scaled to unit diagonal: parameters are in metres and seconds.
  const Eigen::VectorXd sigma = q.diagonal().cwiseSqrt();
  const Eigen::VectorXd weight = sigma.cwiseInverse();
  const Eigen::MatrixXd scaled = weight.asDiagonal() * q * weight.asDiagonal();
  const dense::Cholesky root(scaled);
  if (!root.positive_definite()) {
    throw InputError("prior." + name + ".covariance", "is not positive definite");
  }
  const Eigen::Index size = q.rows();
  const Eigen::MatrixXd inverse = root.SolveLower(Eigen::MatrixXd::Identity(size, size).eval());
  covariance = q;
  factor = sigma.asDiagonal() * root.L();
  whitening = inverse * weight.asDiagonal();
  information = whitening.transpose() * whitening;
}

std::optional<JointPriorProblem> FindOwnProblem(const JointPrior& prior) {
  if (prior.parameters.empty()) {
    return JointPriorProblem{0, "parameters", -1, "is empty, at least one parameter is needed"};
  }
  for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
    const auto end = prior.parameters.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(prior.parameters.begin(), end, prior.parameters[i]) == end) continue;
    return JointPriorProblem{
        0, "parameters", static_cast<int>(i), "'" + prior.parameters[i] + "' is given twice"};
  }
  return FindMatrixProblem(prior);
}

std::optional<std::string> FindCovarianceProblem(const std::vector<std::string>& parameters,
                                                 const Eigen::MatrixXd& covariance) {
  const auto size = static_cast<Eigen::Index>(parameters.size());
  if (covariance.rows() != size || covariance.cols() != size) {
    return "is " + std::to_string(covariance.rows()) + " by " + std::to_string(covariance.cols()) +
           ", one row and one column per parameter are needed: " + std::to_string(size) + " by " +
           std::to_string(size);
  }
  const auto name = [&](Eigen::Index i) {
    return "'" + parameters[static_cast<std::size_t>(i)] + "'";
  };
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!(covariance(i, i) >= kMinVariance && covariance(i, i) <= 1.0 / kMinVariance)) {
      return "the variance of " + name(i) + " is " + ShortText(covariance(i, i)) +
             ", a number from " + ShortText(kMinVariance) + " to " + ShortText(1.0 / kMinVariance) +
             " is needed";
    }
    if (!covariance.row(i).allFinite()) return "the row of " + name(i) + " is not finite";
  }
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  Eigen::MatrixXd l = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (!(std::abs(covariance(i, j) - covariance(j, i)) <= kSymmetric * sigma[i] * sigma[j])) {
        return "is not symmetric: " + ShortText(covariance(j, i)) + " and " +
               ShortText(covariance(i, j)) + " stand for " + name(j) + " and " + name(i);
      }
      const double r = covariance(i, j) / (sigma[i] * sigma[j]);
      l(i, j) = (r - l.row(i).head(j).dot(l.row(j).head(j))) / l(j, j);
    }
    const double pivot = 1.0 - l.row(i).head(i).squaredNorm();
    if (!(pivot > kMinPriorPivot)) {
      return "is not positive definite: beside the parameters before it " + ShortText(pivot) +
             " of the variance of " + name(i) + " is left (a pivot of Cholesky's factor), above " +
             ShortText(kMinPriorPivot) + " is allowed";
    }
    l(i, i) = std::sqrt(pivot);
  }
  return std::nullopt;
}

std::optional<PositionName> ParsePositionName(const std::string& name, JointPrior::Axes axes) {
  const std::string stem = "position.";
  if (!name.starts_with(stem)) return std::nullopt;
  const std::array<const char*, 3>& names = NamesOf(axes);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string start = stem + names[static_cast<std::size_t>(axis)] + ".";
    if (!name.starts_with(start)) continue;
    const char* const begin = name.data() + start.size();
    const char* const end = name.data() + name.size();
    PositionName out{axis, 0};
    const auto [stop, error] = std::from_chars(begin, end, out.degree);
    const bool whole = error == std::errc() && stop == end && begin != end;
    if (whole && out.degree >= 0 && out.degree <= PositionCorrection::kMaxDegree) return out;
  }
  return std::nullopt;
}

JointPriorBindings BindJointPriors(const std::vector<std::string>& pass_ids,
                                   const std::vector<CorrectionGroup>& groups,
                                   const std::vector<JointPrior>& priors) {
  JointPriorBindings out;
  if (priors.empty()) return out;
  const auto fail = [&](std::size_t prior, JointPriorProblem problem) {
    problem.prior = prior;
    out.bound.clear();
    out.problem = std::move(problem);
    return out;
  };
  std::vector<PassParameters> passes;
  for (const std::string& id : pass_ids) passes.push_back(ParametersOfPass(id, groups));
  std::vector<std::set<int>> taken(pass_ids.size());
  for (std::size_t p = 0; p < priors.size(); ++p) {
    const JointPrior& prior = priors[p];
    if (auto problem = FindOwnProblem(prior)) return fail(p, std::move(*problem));
    for (std::size_t i = 0; i < prior.passes.size(); ++i) {
      if (std::find(pass_ids.begin(), pass_ids.end(), prior.passes[i]) != pass_ids.end()) continue;
      return fail(p,
                  {0,
                   "passes",
                   static_cast<int>(i),
                   "no pass '" + prior.passes[i] + "' in the block" +
                       DidYouMean(NearestName(prior.passes[i], pass_ids))});
    }
    std::size_t bound = 0;
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < pass_ids.size(); ++i) {
      const Binder binder(prior, pass_ids[i], passes[i]);
      if (!prior.passes.empty()) {
        if (std::find(prior.passes.begin(), prior.passes.end(), pass_ids[i]) == prior.passes.end())
          continue;
      } else if (binder.CountFound() == 0) {
        nearest = nearest.value_or(i);
        continue;
      }
      JointPriorBinding binding{p, i, {}, passes[i].axes.value_or(PositionCorrection::Axes{})};
      if (auto problem = binder.Bind(&binding.parameters)) return fail(p, std::move(*problem));
      for (std::size_t k = 0; k < binding.parameters.size(); ++k) {
        if (taken[i].insert(binding.parameters[k]).second) continue;
        return fail(p,
                    {0,
                     "parameters",
                     static_cast<int>(k),
                     "'" + prior.parameters[k] + "' of pass '" + pass_ids[i] +
                         "' is in another joint prior too; give it in one"});
      }
      out.bound.push_back(std::move(binding));
      ++bound;
    }
    if (bound > 0) continue;
    std::vector<int> none;
    if (nearest) {
      auto problem = Binder(prior, pass_ids[*nearest], passes[*nearest]).Bind(&none);
      if (problem) return fail(p, std::move(*problem));
    }
    return fail(p, {0, "passes", -1, "names no pass of the block"});
  }
  return out;
}

Eigen::Matrix3d RicAxes(const Eigen::Vector3d& radial_m,
                        const Eigen::Vector3d& velocity_mps,
                        double rotation_rad_per_s) {
  const Eigen::Vector3d turning = rotation_rad_per_s * Eigen::Vector3d::UnitZ().cross(radial_m);
  const Eigen::Vector3d radial = radial_m.normalized();
  const Eigen::Vector3d across = radial.cross(velocity_mps + turning);
  const Eigen::Vector3d cross_track = across / across.norm();
  Eigen::Matrix3d out;
  out << radial, cross_track.cross(radial), cross_track;
  return out;
}

Eigen::Matrix3d FrameFromAxes(const Frame& frame,
                              const Pass& pass,
                              JointPrior::Axes axes,
                              const std::string& field) {
  if (axes == JointPrior::Axes::kFrame) return Eigen::Matrix3d::Identity();
  const std::optional<Motion> motion = pass.path.At(0.5 * (pass.start_s + pass.end_s));
  if (!motion) {
    throw InputError(field, "the middle of the strip of pass " + pass.id + " is not on its path");
  }
  if (axes == JointPrior::Axes::kTrack) return TrackAxesOf(frame, *motion).axes;
  const bool local = frame.kind() == FrameKind::kLocal;
  double rotation_rad_per_s = 0.0;
  if (axes == JointPrior::Axes::kRicInertial) {
    const Body* const body = local ? nullptr : FindBody(frame.ellipsoid().name);
    if (body == nullptr) {
      throw InputError(field,
                       "'ric-inertial' needs the rotation of a body that is known by its name; "
                       "'ric' takes the velocity in the frame of the block");
    }
    rotation_rad_per_s = body->rotation;
  }
  const Eigen::Matrix3d out =
      RicAxes(local ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : motion->position_m,
              motion->velocity_mps,
              rotation_rad_per_s);
  if (!out.allFinite()) {
    throw InputError(field, "pass " + pass.id + " flies along the vertical, it has no such axes");
  }
  return out;
}

Eigen::MatrixXd CovarianceOf(const JointPrior& prior,
                             const Frame& frame,
                             const Pass& pass,
                             PositionCorrection::Axes axes) {
  const JointPrior::Axes own = AxesOf(axes);
  if (prior.axes == JointPrior::Axes::kCorrection || prior.axes == own) {
    return prior.Covariance().matrix();
  }
  const std::string field = KeyOf(prior) + ".axes";
  const Eigen::Matrix3d own_from_prior = FrameFromAxes(frame, pass, own, field).transpose() *
                                         FrameFromAxes(frame, pass, prior.axes, field);
  const auto size = static_cast<Eigen::Index>(prior.parameters.size());
  Eigen::MatrixXd t = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto to = ParsePositionName(prior.parameters[static_cast<std::size_t>(i)], prior.axes);
    if (!to) continue;
    for (Eigen::Index j = 0; j < size; ++j) {
      const auto from =
          ParsePositionName(prior.parameters[static_cast<std::size_t>(j)], prior.axes);
      if (from && from->degree == to->degree) t(i, j) = own_from_prior(to->axis, from->axis);
    }
  }
  const Eigen::MatrixXd turned = t * prior.Covariance().matrix() * t.transpose();
  return 0.5 * (turned + turned.transpose());
}

std::string KeyOf(const JointPrior& prior) { return "prior." + prior.name; }

}  // namespace sarblock
