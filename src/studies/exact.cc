// SPDX-License-Identifier: Apache-2.0
#include "exact.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sarblock {
namespace {

using exact::Digits;
using exact::Vec;
using exact::operator-;
using exact::operator*;

constexpr int kMaxExactIterations = 80;
const char* const kSettled = "1e-14";
constexpr int kMaxConeSteps = 12;
const char* const kOnCone = "1e-28";

/// Lower triangle of a square matrix, row by row.
class Triangle {
 public:
  explicit Triangle(std::size_t size) : size_(size), values_(size * (size + 1) / 2, Digits(0)) {}
  Digits& operator()(std::size_t i, std::size_t j) { return values_[i * (i + 1) / 2 + j]; }
  const Digits& operator()(std::size_t i, std::size_t j) const {
    return values_[i * (i + 1) / 2 + j];
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::size_t size_;
  std::vector<Digits> values_;
};

/// L of a = L L' in place; false where a pivot is not positive. Zeros are skipped: in the order
/// points, corrections the points' part is block diagonal.
bool Factor(Triangle* a) {
  Triangle& l = *a;
  for (std::size_t i = 0; i < l.size(); ++i) {
    std::vector<std::size_t> filled;
    for (std::size_t j = 0; j <= i; ++j) {
      Digits sum = l(i, j);
      for (const std::size_t k : filled) {
        if (!l(j, k).is_zero()) sum -= l(i, k) * l(j, k);
      }
      if (i == j) {
        if (!(sum > 0)) return false;
        l(i, i) = sqrt(sum);
      } else if (!sum.is_zero()) {
        l(i, j) = sum / l(j, j);
        filled.push_back(j);
      }
    }
  }
  return true;
}

Triangle Inverse(const Triangle& l) {
  Triangle x(l.size());
  for (std::size_t i = 0; i < l.size(); ++i) {
    std::vector<std::size_t> filled;
    for (std::size_t k = 0; k < i; ++k) {
      if (!l(i, k).is_zero()) filled.push_back(k);
    }
    const Digits inverse = 1 / l(i, i);
    x(i, i) = inverse;
    for (std::size_t j = 0; j < i; ++j) {
      Digits sum = 0;
      for (const std::size_t k : filled) {
        if (k >= j && !x(k, j).is_zero()) sum -= l(i, k) * x(k, j);
      }
      if (!sum.is_zero()) x(i, j) = sum * inverse;
    }
  }
  return x;
}

/// Largest singular value of a triangle by power iteration; elements as doubles are enough.
double LargestSingularValue(const Triangle& of) {
  const std::size_t n = of.size();
  std::vector<double> m(n * (n + 1) / 2), x(n, 1.0), y(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) m[i * (i + 1) / 2 + j] = static_cast<double>(of(i, j));
  }
  double value = 0.0;
  for (int step = 0; step < 60; ++step) {
    double square = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      y[i] = 0.0;
      for (std::size_t j = 0; j <= i; ++j) y[i] += m[i * (i + 1) / 2 + j] * x[j];
    }
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) x[j] += m[i * (i + 1) / 2 + j] * y[i];
    }
    for (const double xi : x) square += xi * xi;
    value = std::sqrt(square);
    for (double& xi : x) xi /= value;
  }
  return std::sqrt(value);
}

using ExactRow = std::vector<std::pair<std::size_t, Digits>>;

/// The adjustment at one state: three unknowns a solved point, then the corrections.
class ExactAdjustment {
 public:
  ExactAdjustment(const AdjustmentProblem& problem, const AdjustResult& result)
      : problem_(problem), model_(problem) {
    first_of_.assign(problem.block.points.size(), 0);
    for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
      if (!problem.Solves(point)) continue;
      first_of_[point] = corrections_;
      corrections_ += 3;
      solved_.push_back(point);
    }
    position_.resize(problem.block.points.size());
    for (const std::size_t point : solved_) {
      position_[point] = exact::Cast<Digits>(result.points.position_m[point]);
    }
    for (const ParameterResult& parameter : result.parameters) x_.emplace_back(parameter.value);
    shift_.assign(problem.block.looks.size(), Digits(0));
  }

  /// Gauss-Newton until nothing moves; empty, or why it failed.
  std::string Solve(int* iterations) {
    const Digits settled(kSettled);
    Digits before = -1;
    int grown = 0;
    for (*iterations = 1; *iterations <= kMaxExactIterations; ++*iterations) {
      Form();
      if (!Factorise()) return "the normal matrix is singular in 50 digits";
      const Digits step = Step();
      if (!(step < Digits("1e30"))) return "Gauss-Newton in 50 digits runs away";
      if (step < settled) return "";
      grown = before >= 0 && step > before ? grown + 1 : 0;
      if (grown > 8) return "Gauss-Newton in 50 digits does not converge";
      before = step;
    }
    return before < Digits("1e-9") ? "" : "Gauss-Newton in 50 digits converges too slowly";
  }

  void Compare(const AdjustResult& result, ExactComparison* out) const {
    const Triangle x = Inverse(matrix_);
    out->condition = LargestSingularValue(matrix_) * LargestSingularValue(x);
    out->covariance_m2.assign(problem_.block.points.size(), SymmetricEnu{});
    for (SymmetricEnu& c : out->covariance_m2) c.fill(kNaN);
    for (const std::size_t point : solved_) ComparePoint(x, result, point, out);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const Digits sigma = sqrt(Covariance(x, corrections_ + i, corrections_ + i));
      const ParameterResult& given = result.parameters[i];
      Worst(abs(Digits(given.value) - x_[i]) / sigma, &out->error_sigma);
      Worst(abs(Digits(given.sigma) - sigma) / sigma, &out->sigma_error);
    }
  }

 private:
  void Form() {
    const std::size_t n = corrections_ + x_.size();
    matrix_ = Triangle(n);
    gradient_.assign(n, Digits(0));
    LookColumns columns;
    for (const std::size_t point : solved_) {
      const auto& offsets = problem_.block.looks.offsets;
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
        if (problem_.look_used[i] == 0) continue;
        AddLook(point, i, &columns);
      }
      if (problem_.control_of[point] >= 0) AddControl(point);
    }
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const Parameter& parameter = problem_.layout.parameters[i];
      if (parameter.before >= 0) {
        const auto from = static_cast<std::size_t>(parameter.before);
        const Digits weight = 1 / Digits(parameter.step_sigma);
        const Digits carried = weight * Digits(parameter.carried);
        const Digits value(problem_.layout.parameters[from].prior_value);
        Add({{corrections_ + i, weight}, {corrections_ + from, -carried}},
            weight * (x_[i] - Digits(parameter.prior_value)) - carried * (x_[from] - value));
      }
      if (!parameter.has_own_prior()) continue;
      const Digits weight = 1 / Digits(parameter.prior_sigma);
      Add({{corrections_ + i, weight}}, weight * (x_[i] - Digits(parameter.prior_value)));
    }
    for (const JointPriorTerm& prior : problem_.layout.joint_priors) AddJoint(prior);
  }

  /// Rows L^-1 (c - c0), L of the covariance in 50 digits.
  void AddJoint(const JointPriorTerm& prior) {
    const std::size_t size = prior.parameters.size();
    Triangle l(size);
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        l(i, j) =
            Digits(prior.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
      }
    }
    if (!Factor(&l)) throw InputError(prior.name, "is not positive definite in 50 digits");
    const Triangle whitening = Inverse(l);
    for (std::size_t r = 0; r < size; ++r) {
      ExactRow row;
      Digits error = 0;
      for (std::size_t c = 0; c <= r; ++c) {
        const auto i = static_cast<std::size_t>(prior.parameters[c]);
        const Parameter& parameter = problem_.layout.parameters[i];
        row.emplace_back(corrections_ + i, whitening(r, c));
        error += whitening(r, c) * (x_[i] - Digits(parameter.prior_value));
      }
      Add(row, error);
    }
  }

  void Add(const ExactRow& row, const Digits& error) {
    for (const auto& [i, a] : row) {
      for (const auto& [j, b] : row) {
        if (j <= i) matrix_(i, j) += a * b;
      }
      gradient_[i] += a * error;
    }
  }

  void AddLook(std::size_t point, std::size_t look, LookColumns* columns) {
    // The time or Doppler at which the cone holds the point, by Newton's method from the last
    // found.
    Digits& shift = shift_[look];
    exact::LookAt<Digits> at = model_.Evaluate(look, position_[point], x_, shift);
    for (int step = 0; step < kMaxConeSteps; ++step) {
      const Digits off = at.error[1] / at.cone_rate;
      if (abs(off) < Digits(kOnCone)) break;
      shift -= off;
      at = model_.Evaluate(look, position_[point], x_, shift);
    }
    // Range and time as the cone and its partials give them: dt = -de_d / q, dR = de_r + r dt; for
    // a measured Doppler the same with r = 0.
    const std::array<Digits, 2> sigma = model_.SigmasOf(look, at);
    ExactRow range_row, time_row;
    const auto add = [&](std::size_t column, const Digits& range, const Digits& cone) {
      const Digits time = -cone / at.cone_rate;
      range_row.emplace_back(column, (range + at.range_rate * time) / sigma[0]);
      time_row.emplace_back(column, time / sigma[1]);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add(first_of_[point] + axis, at.d_point[0][axis], at.d_point[1][axis]);
    }
    problem_.model.ColumnsOf(look, columns);
    std::size_t local = 0;
    for (int b = 0; b < columns->block_count; ++b) {
      const ParameterBlock& block =
          problem_.layout
              .blocks[static_cast<std::size_t>(columns->block[static_cast<std::size_t>(b)])];
      for (int c = 0; c < block.size; ++c, ++local) {
        add(corrections_ + static_cast<std::size_t>(block.offset + c),
            at.by_column[0][local],
            at.by_column[1][local]);
      }
    }
    Add(range_row, at.error[0] / sigma[0]);
    Add(time_row, shift / sigma[1]);
  }

  /// L^-1 (E (p - p_c)) with L the factor of the covariance of the fixed components.
  void AddControl(std::size_t point) {
    const KnownPosition& known =
        *problem_.block.points.FindKnown(static_cast<std::uint32_t>(point));
    const Vec<Digits> given = exact::Cast<Digits>(problem_.block.points.given_m[point]);
    const Frame& frame = problem_.block.frame;
    std::array<Vec<Digits>, 3> axes = exact::EnuAxes(frame, given);
    Vec<Digits> off;
    for (std::size_t i = 0; i < 3; ++i) {
      off[i] = exact::Dot(axes[i], position_[point] - given);
    }
    const ControlEquations& equations =
        problem_.control[static_cast<std::size_t>(problem_.control_of[point])];
    if (equations.height_only) {
      const auto here = exact::Vertical<Digits>(frame, position_[point], position_[point]);
      axes[2] = here.up;
      off[2] = here.height - exact::Vertical<Digits>(frame, given, given).height;
    }
    std::vector<std::size_t> fixed;
    for (std::size_t i = 0; i < 3; ++i) {
      if (known.fixed[i]) fixed.push_back(i);
    }
    std::array<std::array<Digits, 3>, 3> l;
    for (std::size_t a = 0; a < fixed.size(); ++a) {
      Vec<Digits> row = axes[fixed[a]];
      Digits error = off[fixed[a]];
      for (std::size_t b = 0; b <= a; ++b) {
        Digits sum = known.covariance_enu_m2(static_cast<Eigen::Index>(fixed[a]),
                                             static_cast<Eigen::Index>(fixed[b]));
        for (std::size_t k = 0; k < b; ++k) sum -= l[a][k] * l[b][k];
        l[a][b] = a == b ? Digits(sqrt(sum)) : Digits(sum / l[b][b]);
      }
      for (std::size_t b = 0; b < a; ++b) {
        row = row - l[a][b] * control_rows_[b];
        error -= l[a][b] * control_errors_[b];
      }
      control_rows_[a] = (1 / l[a][a]) * row;
      control_errors_[a] = error / l[a][a];
      ExactRow equation;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        equation.emplace_back(first_of_[point] + axis, control_rows_[a][axis]);
      }
      Add(equation, control_errors_[a]);
    }
  }

  bool Factorise() {
    scale_.resize(matrix_.size());
    for (std::size_t i = 0; i < matrix_.size(); ++i) {
      if (!(matrix_(i, i) > 0)) return false;
      scale_[i] = 1 / sqrt(matrix_(i, i));
    }
    for (std::size_t i = 0; i < matrix_.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        if (!matrix_(i, j).is_zero()) matrix_(i, j) *= scale_[i] * scale_[j];
      }
    }
    return Factor(&matrix_);
  }

  /// Takes the Gauss-Newton step; its length in sigmas over all unknowns.
  Digits Step() {
    const std::size_t n = matrix_.size();
    std::vector<Digits> y(n);
    Digits square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Digits sum = -gradient_[i] * scale_[i];
      for (std::size_t k = 0; k < i; ++k) {
        if (!matrix_(i, k).is_zero()) sum -= matrix_(i, k) * y[k];
      }
      y[i] = sum / matrix_(i, i);
      square += y[i] * y[i];
    }
    for (std::size_t i = n; i-- > 0;) {
      y[i] /= matrix_(i, i);
      for (std::size_t k = 0; k < i; ++k) {
        if (!matrix_(i, k).is_zero()) y[k] -= matrix_(i, k) * y[i];
      }
    }
    for (const std::size_t point : solved_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t i = first_of_[point] + axis;
        position_[point][axis] += scale_[i] * y[i];
      }
    }
    for (std::size_t i = 0; i < x_.size(); ++i) {
      x_[i] += scale_[corrections_ + i] * y[corrections_ + i];
    }
    return sqrt(square);
  }

  Digits Covariance(const Triangle& x, std::size_t i, std::size_t j) const {
    Digits sum = 0;
    for (std::size_t k = std::max(i, j); k < x.size(); ++k) {
      if (!x(k, i).is_zero()) sum += x(k, i) * x(k, j);
    }
    return sum * scale_[i] * scale_[j];
  }

  static void Worst(const Digits& value, double* worst) {
    const double v = static_cast<double>(value);
    *worst = std::isnan(v) ? std::numeric_limits<double>::infinity() : std::max(*worst, v);
  }

  void ComparePoint(const Triangle& x,
                    const AdjustResult& result,
                    std::size_t point,
                    ExactComparison* out) const {
    const Block& block = problem_.block;
    const std::size_t first = first_of_[point];
    std::array<Vec<Digits>, 3> q, enu;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) q[a][b] = Covariance(x, first + a, first + b);
    }
    const std::array<Vec<Digits>, 3> axes = exact::EnuAxes(block.frame, position_[point]);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        enu[a][b] = 0;
        for (std::size_t i = 0; i < 3; ++i) enu[a][b] += axes[a][i] * exact::Dot(q[i], axes[b]);
      }
    }
    // e' Q^-1 e by the Cholesky factor of Q.
    const Vec<Digits> e = exact::Cast<Digits>(result.points.position_m[point]) - position_[point];
    std::array<Vec<Digits>, 3> l;
    Vec<Digits> y;
    for (std::size_t a = 0; a < 3; ++a) {
      y[a] = e[a];
      for (std::size_t b = 0; b <= a; ++b) {
        Digits sum = q[a][b];
        for (std::size_t k = 0; k < b; ++k) sum -= l[a][k] * l[b][k];
        l[a][b] = a == b ? Digits(sqrt(sum)) : Digits(sum / l[b][b]);
        if (b < a) y[a] -= l[a][b] * y[b];
      }
      y[a] /= l[a][a];
    }
    Worst(exact::Norm(y), &out->error_sigma);
    double shortest_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem_.look_used[i] != 0) shortest_m = std::min(shortest_m, block.looks.range_m[i]);
    }
    Worst(exact::Norm(e) / Digits(shortest_m), &out->position_error);
    SymmetricEnu& c = out->covariance_m2[point];
    constexpr std::array<std::array<std::size_t, 2>, 6> kOrder = {
        {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    const SymmetricEnu& given = result.points.covariance_m2[point];
    Digits square = 0, off = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const Digits& value = enu[kOrder[k][0]][kOrder[k][1]];
      c[k] = static_cast<double>(value);
      const Digits difference = Digits(given[k]) - value;
      const Digits count = k < 3 ? 1 : 2;
      square += count * value * value;
      off += count * difference * difference;
      if (k >= 3) continue;
      const Digits sigma = sqrt(value);
      const Digits computed = given[k] >= 0.0 ? Digits(sqrt(Digits(given[k]))) : Digits(0);
      Worst(abs(computed - sigma) / sigma, &out->sigma_error);
    }
    Worst(sqrt(off / square), &out->covariance_error);
  }

  const AdjustmentProblem& problem_;
  exact::LookModelOf<Digits> model_;
  std::vector<std::size_t> solved_, first_of_;
  std::size_t corrections_ = 0;  // first unknown of the corrections
  std::vector<Vec<Digits>> position_;
  std::vector<Digits> x_;
  std::vector<Digits> shift_;  // of the times or measured Dopplers, by look
  Triangle matrix_{0};         // after Factorise() its factor
  std::vector<Digits> gradient_, scale_;
  std::array<Vec<Digits>, 3> control_rows_;
  std::array<Digits, 3> control_errors_;
};

}  // namespace

ExactComparison CompareWithExact(const AdjustmentProblem& problem, const AdjustResult& result) {
  ExactComparison out;
  ExactAdjustment adjustment(problem, result);
  out.failure = adjustment.Solve(&out.iterations);
  if (out.failure.empty()) adjustment.Compare(result, &out);
  return out;
}

}  // namespace sarblock
