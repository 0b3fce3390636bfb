// SPDX-License-Identifier: Apache-2.0
#include "sarblock/cost/look_cost.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/text.h"
#include "look_cost.h"

namespace sarblock {

// ---- a flight with its corrections

namespace {

using Parts = CorrectedFlight::Parts;

std::string NameOf(const Parameter& parameter) {
  return parameter.name + " [" + parameter.unit + "]";
}

/// Adds the columns of a spline: one block for each coefficient.
Parts::Term AddSpline(const PositionCorrection& position, const TimeSpan& knots_s, Parts* parts) {
  PassCorrections& all = parts->corrections;
  Parts::Term term;
  term.spline = static_cast<int>(all.splines.size());
  all.splines.push_back(MakeSplineTerm(position, knots_s.first_s, knots_s.last_s));
  term.size = all.splines.back().component_count;
  term.blocks = all.splines.back().spline.count();
  for (std::size_t k = 0; k < term.blocks; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!position.components[axis]) continue;
      const Parameter parameter = PositionParameter(position, axis, k);
      term.names.push_back(NameOf(parameter));
      if (k == 0) term.prior_sigmas.push_back(parameter.prior_sigma);
    }
  }
  return term;
}

/// Adds the columns of a correction that is no spline: one block.
Parts::Term AddStatic(const CorrectionGroup& group, Parts* parts) {
  PassCorrections& all = parts->corrections;
  Parts::Term term;
  for (const Parameter& parameter : ParametersOf(group)) {
    term.names.push_back(NameOf(parameter));
    term.prior_sigmas.push_back(parameter.prior_sigma);
  }
  term.size = static_cast<int>(term.names.size());
  BindCorrection(group.model, all.static_columns, &all);
  all.static_columns += term.size;
  parts->static_sizes.push_back(term.size);
  return term;
}

void AddCorrections(std::vector<FlightCorrection> corrections,
                    const TimeSpan& strip_s,
                    Parts* parts) {
  if (!(strip_s.first_s < strip_s.last_s)) {
    throw InputError("strip_s",
                     "must end after it starts, got " + NumberText(strip_s.first_s) + " to " +
                         NumberText(strip_s.last_s));
  }
  parts->corrections.middle_s = 0.5 * (strip_s.first_s + strip_s.last_s);
  parts->corrections.half_length_s = 0.5 * (strip_s.last_s - strip_s.first_s);
  for (FlightCorrection& correction : corrections) {
    const CorrectionGroup group{
        kCorrectionKinds[correction.model.index()], std::move(correction.model), {}, false};
    CheckCorrection(group);
    const auto* position = std::get_if<PositionCorrection>(&group.model);
    if (HasProcess(group)) {
      throw InputError("correction." + group.name + ".process",
                       "is a prior between blocks, which PriorCost() does not give; kWhite with "
                       "residuals of one's own between coefficients is allowed");
    }
    const bool spline =
        position != nullptr && position->basis == PositionCorrection::Basis::kSpline;
    parts->terms.push_back(spline
                               ? AddSpline(*position, correction.knots_s.value_or(strip_s), parts)
                               : AddStatic(group, parts));
  }
  CheckLimits("of the flight", parts->corrections);
}

std::unique_ptr<const Parts> MakeParts(const Frame& frame,
                                       const FlightPath& path,
                                       const PathUse& use,
                                       const FlightOptions& options,
                                       std::vector<FlightCorrection> corrections) {
  if (path.piece_count() == 0) throw InputError("path", "has no states, two or more are needed");
  if (!std::isfinite(options.time_bias_s)) {
    throw InputError("time_bias_s", "must be finite, got " + NumberText(options.time_bias_s));
  }
  auto parts = std::make_unique<Parts>();
  parts->frame = frame;
  parts->nominal = path;
  AddCorrections(std::move(corrections), options.strip_s, parts.get());
  parts->own.emplace(parts->frame, parts->nominal, parts->corrections, use, Simplified{});
  parts->own->AnchorAt(options.time_bias_s);
  parts->path = &*parts->own;
  return parts;
}

const Pass& PassOf(const Block& block, std::size_t pass) {
  if (pass < block.passes.size()) return block.passes[pass];
  throw InputError(
      "pass",
      "must be below " + std::to_string(block.passes.size()) + ", got " + std::to_string(pass));
}

/// Local corrections gathered from the blocks of a look, the point's first.
void Gather(const Parts& parts, const std::vector<double*>& blocks, double* local) {
  std::size_t b = 1;
  for (const int size : parts.static_sizes) local = std::copy_n(blocks[b++], size, local);
  for (const SplineTerm& term : parts.corrections.splines) {
    for (int k = 0; k < 4; ++k) local = std::copy_n(blocks[b++], term.component_count, local);
  }
}

}  // namespace

int Parts::ColumnCount() const {
  int columns = path->corrections().static_columns;
  for (const SplineTerm& term : path->corrections().splines) columns += 4 * term.component_count;
  return columns;
}

MeasuredLook Parts::Measured(const LookMeasurement& look) const {
  const FlightPath& flown = path->path();
  if (!(look.time_s >= flown.start_s() && look.time_s <= flown.end_s())) {
    throw InputError("look.time_s",
                     "must be within the flight path, " + NumberText(flown.start_s()) + " to " +
                         NumberText(flown.end_s()) + ", got " + NumberText(look.time_s));
  }
  if (look.cone.kind == Cone::Kind::kSquint
          ? !(std::abs(look.cone.squint_rad) < 0.5 * std::numbers::pi)
          : !std::isfinite(look.cone.closing_mps)) {
    throw InputError("look.cone", "must be a squint below pi/2 [rad] or a finite closing speed");
  }
  MeasuredLook out{look.time_s, look.range_m, look.cone};
  if (std::isnan(look.doppler_sigma_hz)) return out;
  if (look.cone.kind != Cone::Kind::kDoppler) {
    throw InputError("look.doppler_sigma_hz", "needs a cone of the kind kDoppler");
  }
  if (!(look.wavelength_m > 0.0 && std::isfinite(look.wavelength_m))) {
    throw InputError(
        "look.wavelength_m",
        "must be finite and above 0 with doppler_sigma_hz, got " + NumberText(look.wavelength_m));
  }
  if (!std::isnan(look.time_sigma_s)) {
    throw InputError("look.time_sigma_s", "and doppler_sigma_hz exclude each other; give one");
  }
  out.azimuth = MeasuredLook::Azimuth::kDoppler;
  out.wavelength_m = look.wavelength_m;
  return out;
}

CorrectedFlight::CorrectedFlight(const Frame& frame,
                                 const FlightPath& path,
                                 const FlightOptions& options,
                                 std::vector<FlightCorrection> corrections)
    : parts_(MakeParts(frame, path, PathUse{}, options, std::move(corrections))) {}

CorrectedFlight::CorrectedFlight(const Block& block,
                                 std::size_t pass,
                                 std::vector<FlightCorrection> corrections,
                                 double time_bias_s) {
  const Pass& flown = PassOf(block, pass);
  const FlightOptions options{{flown.start_s, flown.end_s}, time_bias_s};
  parts_ =
      MakeParts(block.frame, flown.path, PathUsesOf(block)[pass], options, std::move(corrections));
}

CorrectedFlight::CorrectedFlight(std::unique_ptr<const Parts> parts) : parts_(std::move(parts)) {}
CorrectedFlight::~CorrectedFlight() = default;

std::size_t CorrectedFlight::correction_count() const { return parts_->terms.size(); }
int CorrectedFlight::BlockSize(std::size_t correction) const {
  return parts_->terms.at(correction).size;
}
std::size_t CorrectedFlight::BlockCount(std::size_t correction) const {
  return parts_->terms.at(correction).blocks;
}
std::vector<std::string> CorrectedFlight::ParameterNames(std::size_t correction) const {
  return parts_->terms.at(correction).names;
}

std::vector<double*> CorrectedFlight::Blocks(double* point,
                                             std::span<double* const> arrays,
                                             double time_s) const {
  const std::vector<Parts::Term>& terms = parts_->terms;
  if (arrays.size() != terms.size()) {
    throw InputError("arrays",
                     "must be one for each correction, " + std::to_string(terms.size()) + ", got " +
                         std::to_string(arrays.size()));
  }
  std::vector<double*> out{point};
  for (std::size_t q = 0; q < terms.size(); ++q) {
    if (terms[q].spline < 0) out.push_back(arrays[q]);
  }
  for (std::size_t q = 0; q < terms.size(); ++q) {
    if (terms[q].spline < 0) continue;
    const SplineTerm& term = parts_->corrections.splines[static_cast<std::size_t>(terms[q].spline)];
    const std::size_t first = term.spline.PieceOf(time_s);
    for (std::size_t k = first; k < first + 4; ++k) {
      out.push_back(arrays[q] + k * static_cast<std::size_t>(terms[q].size));
    }
  }
  return out;
}

std::optional<Motion> CorrectedFlight::At(double time_s, std::span<double* const> arrays) const {
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  Gather(*parts_, Blocks(nullptr, arrays, time_s), local.data());
  const CorrectedPath& path = *parts_->path;
  const double path_s = time_s + SumOf(path.corrections().time_bias, local.data());
  if (BeyondPath(path.path(), path_s) != Beyond::kInside) return std::nullopt;
  const double read_s = path.ReadingTime_s(time_s, path_s);
  PathReading reading;
  if (!path.Read(time_s, read_s, local.data(), &reading)) return std::nullopt;
  return path_s == read_s ? reading.motion : reading.motion.After(path_s - read_s);
}

double CorrectedFlight::AzimuthUnit_m(const LookMeasurement& look,
                                      const Eigen::Vector3d& p_m,
                                      std::span<double* const> arrays) const {
  std::array<double, ParameterLayout::kMaxLocalColumns> local{};
  if (!arrays.empty()) Gather(*parts_, Blocks(nullptr, arrays, look.time_s), local.data());
  MeasuredLook measured = parts_->Measured(look);
  measured.range_m = 0.0;
  LookEvaluation at;
  const LookValue value = EvaluateMeasuredLook(*parts_->path,
                                               measured,
                                               p_m,
                                               Eigen::Vector3d::Zero(),
                                               local.data(),
                                               parts_->ColumnCount(),
                                               {},
                                               &at);
  return value == LookValue::kGiven ? at.azimuth_unit_m : kNotGiven;
}

LookMeasurement MeasurementOf(const Block& block,
                              std::size_t look,
                              const CorrectedFlight& flight,
                              const Eigen::Vector3d& near_m,
                              std::span<double* const> arrays) {
  if (look >= block.looks.size()) {
    throw InputError(
        "look",
        "must be below " + std::to_string(block.looks.size()) + ", got " + std::to_string(look));
  }
  LookMeasurement out;
  out.time_s = block.looks.time_s[look];
  out.range_m = block.looks.range_m[look];
  out.cone = block.ConeOf(look);
  const LookSigma sigma = block.SigmaOf(look);
  out.range_sigma_m = sigma.range_m;
  if (block.MeasuresDoppler(look)) {
    out.doppler_sigma_hz = sigma.azimuth;
    out.wavelength_m = block.passes[block.looks.pass[look]].wavelength_m;
    return out;
  }
  out.time_sigma_s = sigma.azimuth;
  if (sigma.azimuth_unit == AzimuthUnit::kMetres) {
    const double unit_m = flight.AzimuthUnit_m(out, near_m, arrays);
    if (std::isnan(unit_m)) {
      throw InputError("look " + std::to_string(look),
                       "has no predicted time for a point at near_m; give a point near its own");
    }
    out.time_sigma_s /= unit_m;
  }
  return out;
}

// ---- the cost functions

namespace {

/// Origin of the block of a point: an own position, or that of another owner, which may move.
class Origin {
 public:
  explicit Origin(const Eigen::Vector3d& own_m) : own_m_(own_m) {}
  explicit Origin(const Eigen::Vector3d* other_m)
      : own_m_(Eigen::Vector3d::Zero()), other_m_(other_m) {}
  [[nodiscard]] const Eigen::Vector3d& place_m() const {
    return other_m_ == nullptr ? own_m_ : *other_m_;
  }

 private:
  Eigen::Vector3d own_m_;
  const Eigen::Vector3d* other_m_ = nullptr;
};

/// Rows of LookEvaluation that are residuals.
struct Rows {
  int first = 0, count = 2;
};

class LookCost final : public ceres::CostFunction {
 public:
  LookCost(FlightPointer flight,
           const MeasuredLook& look,
           const LookWeights& weights,
           Rows rows,
           const Origin& origin)
      : flight_(std::move(flight)),
        parts_(flight_->parts()),
        look_(look),
        weights_(weights),
        origin_(origin),
        rows_(rows),
        columns_(parts_.ColumnCount()) {
    set_num_residuals(rows.count);
    std::vector<int>& sizes = *mutable_parameter_block_sizes();
    sizes.push_back(3);
    sizes.insert(sizes.end(), parts_.static_sizes.begin(), parts_.static_sizes.end());
    for (const SplineTerm& term : parts_.path->corrections().splines) {
      sizes.insert(sizes.end(), 4, term.component_count);
    }
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::vector<int>& sizes = parameter_block_sizes();
    std::array<double, ParameterLayout::kMaxLocalColumns> local;
    const double* x = local.data();
    if (sizes.size() == 2) {
      x = blocks[1];
    } else {
      double* next = local.data();
      for (std::size_t b = 1; b < sizes.size(); ++b) next = std::copy_n(blocks[b], sizes[b], next);
    }
    LookEvaluation at;
    const LookValue value = EvaluateMeasuredLook(*parts_.path,
                                                 look_,
                                                 origin_.place_m(),
                                                 Eigen::Vector3d(blocks[0]),
                                                 x,
                                                 columns_,
                                                 weights_,
                                                 &at);
    if (value != LookValue::kGiven) return false;
    for (int r = 0; r < rows_.count; ++r) residuals[r] = at.whitened_error[rows_.first + r];
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      for (int r = 0; r < rows_.count; ++r) {
        Eigen::Map<Eigen::RowVector3d>(jacobians[0] + 3 * r) = at.d_point.row(rows_.first + r);
      }
    }
    std::ptrdiff_t column = 0;
    for (std::size_t b = 1; b < sizes.size(); ++b) {
      for (int r = 0; r < rows_.count && jacobians[b] != nullptr; ++r) {
        const auto row = static_cast<std::size_t>(rows_.first + r);
        std::copy_n(at.row[row].data() + column, sizes[b], jacobians[b] + r * sizes[b]);
      }
      column += sizes[b];
    }
    return true;
  }

 private:
  FlightPointer flight_;
  const CorrectedFlight::Parts& parts_;
  MeasuredLook look_;
  LookWeights weights_;
  Origin origin_;
  Rows rows_;
  int columns_;
};

class ControlCost final : public ceres::CostFunction {
 public:
  ControlCost(const Frame& frame, const ControlEquations& control, const Origin& origin)
      : frame_(frame), control_(control), origin_(origin) {
    set_num_residuals(control.rows);
    mutable_parameter_block_sizes()->push_back(3);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const ControlEvaluation at =
        EvaluateControl(frame_, control_, origin_.place_m(), Eigen::Vector3d(blocks[0]));
    for (int i = 0; i < control_.rows; ++i) {
      residuals[i] = at.residual[i];
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      Eigen::Map<Eigen::RowVector3d>(jacobians[0] + 3 * i) = at.d_point.row(i);
    }
    return at.residual.allFinite();
  }

 private:
  Frame frame_;
  ControlEquations control_;
  Origin origin_;
};

/// Rows that are sums of weight (c - c0).
class LinearCost final : public ceres::CostFunction {
 public:
  struct Term {
    std::size_t block = 0;  ///< of those of the cost
    int index = 0;          ///< in the block
    double weight = 0.0;    ///< 1 / unit of the parameter
    double value = 0.0;     ///< c0
  };
  using Row = std::vector<Term>;

  LinearCost(std::vector<Row> rows, std::vector<int> sizes) : rows_(std::move(rows)) {
    set_num_residuals(static_cast<int>(rows_.size()));
    *mutable_parameter_block_sizes() = std::move(sizes);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const auto jacobian = [&](std::size_t block) {
      return jacobians == nullptr ? nullptr : jacobians[block];
    };
    for (std::size_t block = 0; block < parameter_block_sizes().size(); ++block) {
      if (jacobian(block) == nullptr) continue;
      std::fill_n(jacobian(block), SizeOf(block) * rows_.size(), 0.0);
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      residuals[r] = 0.0;
      for (const auto [block, index, weight, value] : rows_[r]) {
        residuals[r] += weight * (blocks[block][index] - value);
        if (jacobian(block) == nullptr) continue;
        jacobian(block)[r * SizeOf(block) + static_cast<std::size_t>(index)] = weight;
      }
    }
    return true;
  }

 private:
  [[nodiscard]] std::size_t SizeOf(std::size_t block) const {
    return static_cast<std::size_t>(parameter_block_sizes()[block]);
  }

  std::vector<Row> rows_;
};

/// One over a standard deviation of a look.
double WeightOf(const char* field, double sigma) {
  if (sigma > 0.0 && std::isfinite(sigma)) return 1.0 / sigma;
  throw InputError(std::string("look.") + field,
                   "must be finite and above 0, got " + NumberText(sigma));
}

double RangeWeightOf(const LookMeasurement& look) {
  if (!(look.range_m > 0.0 && std::isfinite(look.range_m))) {
    throw InputError("look.range_m", "must be finite and above 0, got " + NumberText(look.range_m));
  }
  return WeightOf("range_sigma_m", look.range_sigma_m);
}

double AzimuthWeightOf(const LookMeasurement& look) {
  return std::isnan(look.doppler_sigma_hz) ? WeightOf("time_sigma_s", look.time_sigma_s)
                                           : WeightOf("doppler_sigma_hz", look.doppler_sigma_hz);
}

const CorrectedFlight& Required(const FlightPointer& flight) {
  if (flight == nullptr) throw InputError("flight", "is null; a cost of a look needs one");
  return *flight;
}

}  // namespace

CostPointer RangeDopplerCost(FlightPointer flight,
                             const LookMeasurement& look,
                             const Eigen::Vector3d& origin_m) {
  const MeasuredLook measured = Required(flight).parts().Measured(look);
  const LookWeights weights{RangeWeightOf(look), AzimuthWeightOf(look)};
  return std::make_unique<LookCost>(
      std::move(flight), measured, weights, Rows{0, 2}, Origin(origin_m));
}

CostPointer RangeSphereCost(FlightPointer flight,
                            const LookMeasurement& look,
                            const Eigen::Vector3d& origin_m) {
  MeasuredLook measured = Required(flight).parts().Measured(look);
  measured.azimuth = MeasuredLook::Azimuth::kNone;
  const LookWeights weights{RangeWeightOf(look), 1.0};
  return std::make_unique<LookCost>(
      std::move(flight), measured, weights, Rows{0, 1}, Origin(origin_m));
}

CostPointer DopplerConeCost(FlightPointer flight,
                            const LookMeasurement& look,
                            const Eigen::Vector3d& origin_m) {
  MeasuredLook measured = Required(flight).parts().Measured(look);
  measured.range_m = 0.0;
  const LookWeights weights{1.0, AzimuthWeightOf(look)};
  return std::make_unique<LookCost>(
      std::move(flight), measured, weights, Rows{1, 1}, Origin(origin_m));
}

CostPointer PriorCost(const CorrectedFlight& flight, std::size_t correction) {
  const CorrectedFlight::Parts::Term& term = flight.parts().terms.at(correction);
  std::vector<LinearCost::Row> rows;
  for (int i = 0; i < term.size; ++i) {
    const double sigma = term.prior_sigmas[static_cast<std::size_t>(i)];
    if (!std::isnan(sigma)) rows.push_back({{0, i, 1.0 / sigma, 0.0}});
  }
  if (rows.empty()) return nullptr;
  return std::make_unique<LinearCost>(std::move(rows), std::vector<int>{term.size});
}

CostPointer KnownPositionCost(const Frame& frame,
                              const KnownPosition& known,
                              const Eigen::Vector3d& known_m,
                              const Eigen::Vector3d& origin_m) {
  if (!known_m.allFinite()) throw InputError("known_m", "must be finite");
  if (!known.fixed[0] && !known.fixed[1] && !known.fixed[2]) {
    throw InputError("known.fixed", "has no component; east, north or up must be fixed");
  }
  return std::make_unique<ControlCost>(
      frame, MakeControl(frame, known, known_m, std::to_string(known.point)), Origin(origin_m));
}

std::vector<FlightPointer> FlightsOf(const AdjustmentProblem& problem) {
  std::vector<FlightPointer> out;
  for (std::size_t pass = 0; pass < problem.block.passes.size(); ++pass) {
    auto parts = std::make_unique<CorrectedFlight::Parts>();
    parts->path = &problem.model.paths()[pass];
    for (const int block : problem.layout.passes[pass].blocks) {
      parts->static_sizes.push_back(problem.layout.blocks[static_cast<std::size_t>(block)].size);
    }
    out.push_back(std::make_shared<const CorrectedFlight>(std::move(parts)));
  }
  return out;
}

CostPointer LookCostOf(const AdjustmentProblem& problem,
                       FlightPointer flight,
                       const Eigen::Vector3d* start_m,
                       std::size_t look) {
  return std::make_unique<LookCost>(std::move(flight),
                                    problem.model.MeasuredAt(look),
                                    problem.weights[look],
                                    Rows{0, 2},
                                    Origin(start_m));
}

CostPointer ControlCostOf(const Frame& frame,
                          const ControlEquations& control,
                          const Eigen::Vector3d* start_m) {
  return std::make_unique<ControlCost>(frame, control, Origin(start_m));
}

PriorOfBlock PriorCostOf(const ParameterLayout& layout, int block) {
  const ParameterBlock& of = layout.blocks[static_cast<std::size_t>(block)];
  PriorOfBlock out{nullptr, {block}};
  std::vector<int> sizes = {of.size};
  std::vector<LinearCost::Row> rows;
  for (const PriorRow& prior : PriorRowsOf(layout, block)) {
    LinearCost::Row& row = rows.emplace_back();
    for (const PriorRow::Term& term : prior.terms) {
      const Parameter& parameter = layout.parameters[static_cast<std::size_t>(term.parameter)];
      const bool before = term.parameter < of.offset;
      if (before && out.blocks.size() == 1) {
        out.blocks.push_back(block - 1);
        sizes.push_back(layout.blocks[static_cast<std::size_t>(block - 1)].size);
      }
      const int offset = layout.blocks[static_cast<std::size_t>(out.blocks[before ? 1 : 0])].offset;
      row.push_back(
          {before ? 1U : 0U, term.parameter - offset, term.weight, parameter.prior_value});
    }
  }
  if (!rows.empty()) out.cost = std::make_unique<LinearCost>(std::move(rows), std::move(sizes));
  return out;
}

}  // namespace sarblock
