// SPDX-License-Identifier: Apache-2.0
#include "sarblock/cost/look_cost.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "corrected_flight.h"
#include "look_cost.h"

namespace sarblock {
namespace {

/// Where the block of a point counts from: a place of its own, or one of somebody else that may
/// move.
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
    if (!EvaluateMeasuredLook(*parts_.path,
                              look_,
                              origin_.place_m(),
                              Eigen::Vector3d(blocks[0]),
                              x,
                              columns_,
                              weights_,
                              &at)) {
      return false;
    }
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
