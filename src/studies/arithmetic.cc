// SPDX-License-Identifier: Apache-2.0
#include "arithmetic.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "normals/point.h"
#include "quality/point_sweep.h"

namespace sarblock {

const char* NameOf(Arithmetic arithmetic) {
  switch (arithmetic) {
    case Arithmetic::kSingle:
      return "single";
    case Arithmetic::kDouble:
      return "double";
    case Arithmetic::kExtended:
      return "extended";
  }
  return "";
}

const char* NameOf(Elimination elimination) {
  return elimination == Elimination::kQr ? "qr" : "normals";
}

namespace {

constexpr int kMaxIterations = 12;
constexpr double kSettledDecrement = 1e-6;
constexpr std::size_t kPointsPerReport = 4096;

// Plain loops over rows: what the compiler makes of them is the same for all three arithmetics, and
// three instances of a matrix library would cost more to compile than the rest of the module.

/// Lower triangle of a symmetric matrix by rows, its factor and its inverse in place.
template <typename T>
class Square {
 public:
  void SetZero(std::size_t size) {
    size_ = size;
    values_.assign(size * size, T(0));
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  T* Row(std::size_t i) { return values_.data() + i * size_; }
  const T* Row(std::size_t i) const { return values_.data() + i * size_; }

  /// L of a = L L'; false where a pivot is not positive.
  [[nodiscard]] bool Factor() {
    std::vector<T> column(size_);
    for (std::size_t k = 0; k < size_; ++k) {
      const T pivot = Row(k)[k];
      if (!(pivot > T(0)) || !std::isfinite(pivot)) return false;
      const T root = std::sqrt(pivot);
      Row(k)[k] = root;
      for (std::size_t i = k + 1; i < size_; ++i) {
        T* row = Row(i);
        const T value = row[k] / root;
        row[k] = column[i] = value;
        for (std::size_t j = k + 1; j <= i; ++j) row[j] -= value * column[j];
      }
    }
    return true;
  }

  /// a^-1 x of the factored matrix.
  void Solve(std::vector<T>* x) const {
    for (std::size_t i = 0; i < size_; ++i) {
      T sum = (*x)[i];
      for (std::size_t k = 0; k < i; ++k) sum -= Row(i)[k] * (*x)[k];
      (*x)[i] = sum / Row(i)[i];
    }
    for (std::size_t i = size_; i-- > 0;) {
      const T value = (*x)[i] /= Row(i)[i];
      for (std::size_t k = 0; k < i; ++k) (*x)[k] -= Row(i)[k] * value;
    }
  }

  /// The inverse of the factored matrix, lower triangle: L^-1 first, then its square.
  [[nodiscard]] Square Inverse() const {
    Square lower, out;
    lower.SetZero(size_);
    out.SetZero(size_);
    for (std::size_t i = 0; i < size_; ++i) {
      T* row = lower.Row(i);
      for (std::size_t k = 0; k < i; ++k) {
        const T value = Row(i)[k];
        const T* above = lower.Row(k);
        for (std::size_t j = 0; j <= k; ++j) row[j] -= value * above[j];
      }
      row[i] = T(1);
      for (std::size_t j = 0; j <= i; ++j) row[j] /= Row(i)[i];
    }
    for (std::size_t k = 0; k < size_; ++k) {
      const T* row = lower.Row(k);
      for (std::size_t i = 0; i <= k; ++i) {
        T* to = out.Row(i);
        for (std::size_t j = 0; j <= i; ++j) to[j] += row[i] * row[j];
      }
    }
    return out;
  }

 private:
  std::size_t size_ = 0;
  std::vector<T> values_;
};

/// The equations of one point rounded to T, rows of [J_p | J_c | e]: width + 4 numbers each.
template <typename T>
struct PointRows {
  std::size_t count = 0;
  std::vector<std::size_t> parameter;  ///< of each column of J_c, ascending
  std::vector<T> values;
  [[nodiscard]] std::size_t width() const { return parameter.size(); }
  [[nodiscard]] std::size_t stride() const { return width() + 4; }
  T* Row(std::size_t i) { return values.data() + i * stride(); }
  const T* Row(std::size_t i) const { return values.data() + i * stride(); }
};

/// Reads the equations of points one after the other.
template <typename T>
class RowReader {
 public:
  explicit RowReader(const AdjustmentProblem& problem)
      : problem_(problem), column_of_block_(problem.layout.blocks.size(), 0) {}

  void Read(const BlockState& state, std::size_t point, PointRows<T>* out) {
    const auto& offsets = problem_.block.looks.offsets;
    std::size_t count = 0;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem_.look_used[i] == 0) continue;
      if (looks_.size() <= count) looks_.emplace_back();
      if (EvaluateWhitened(problem_, state, {}, point, i, &looks_[count])) ++count;
    }
    Place(count, out);
    const std::int32_t index = problem_.control_of[point];
    const ControlEquations* control =
        index < 0 ? nullptr : &problem_.control[static_cast<std::size_t>(index)];
    const std::size_t controls = control == nullptr ? 0 : static_cast<std::size_t>(control->rows);
    out->count = 2 * count + controls;
    out->values.assign(out->count * out->stride(), T(0));
    for (std::size_t k = 0; k < count; ++k) {
      Fill(looks_[k], 0, out->Row(2 * k), out->width());
      Fill(looks_[k], 1, out->Row(2 * k + 1), out->width());
    }
    if (control == nullptr) return;
    const ControlEvaluation at = EvaluateControl(
        problem_.block.frame, *control, state.start_m[point], state.displacement_m[point]);
    for (std::size_t k = 0; k < controls; ++k) {
      const auto from = static_cast<Eigen::Index>(k);
      T* row = out->Row(2 * count + k);
      for (Eigen::Index c = 0; c < 3; ++c) row[c] = static_cast<T>(at.d_point(from, c));
      row[out->width() + 3] = static_cast<T>(at.residual[from]);
    }
  }

 private:
  /// Columns of the distinct parameter blocks of the first `count` looks.
  void Place(std::size_t count, PointRows<T>* out) {
    blocks_.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const LookColumns& look = looks_[k].columns;
      blocks_.insert(blocks_.end(), look.block.begin(), look.block.begin() + look.block_count);
    }
    std::sort(blocks_.begin(), blocks_.end());
    blocks_.erase(std::unique(blocks_.begin(), blocks_.end()), blocks_.end());
    out->parameter.clear();
    for (const int b : blocks_) {
      const ParameterBlock& block = problem_.layout.blocks[static_cast<std::size_t>(b)];
      column_of_block_[static_cast<std::size_t>(b)] = out->parameter.size();
      for (int c = 0; c < block.size; ++c) {
        out->parameter.push_back(static_cast<std::size_t>(block.offset + c));
      }
    }
  }

  void Fill(const WhitenedLook& look, std::size_t component, T* row, std::size_t width) const {
    const auto from = static_cast<Eigen::Index>(component);
    for (Eigen::Index c = 0; c < 3; ++c) row[c] = static_cast<T>(look.d_point(from, c));
    row[width + 3] = static_cast<T>(look.whitened_error[from]);
    std::size_t local = 0;
    for (int b = 0; b < look.columns.block_count; ++b) {
      const auto id = static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)]);
      T* to = row + 3 + column_of_block_[id];
      for (int c = 0; c < problem_.layout.blocks[id].size; ++c, ++local) {
        to[c] = static_cast<T>(look.row[component][local]);
      }
    }
  }

  const AdjustmentProblem& problem_;
  std::vector<WhitenedLook> looks_;
  std::vector<int> blocks_;
  std::vector<std::size_t> column_of_block_;
};

/// One point eliminated. `root` is R (QR) or the transposed Cholesky factor of V: both R'R = V.
/// `projected` holds three rows of R^-T J_p' [J_c | e], which QR has as Q' [J_c | e]. `square` is
/// what the point adds to S and, in its last row, to the right side.
template <typename T>
struct Eliminated {
  T root[3][3];
  std::vector<T> projected;
  std::vector<T> square;
};

/// square += sign sum of rows x' x, lower triangle by rows, x of `size` numbers.
template <typename T>
void AddSquares(const T* rows,
                std::size_t count,
                std::size_t stride,
                std::size_t size,
                T sign,
                std::vector<T>* square) {
  for (std::size_t k = 0; k < count; ++k) {
    const T* x = rows + k * stride;
    for (std::size_t i = 0; i < size; ++i) {
      const T value = sign * x[i];
      T* to = square->data() + i * size;
      for (std::size_t j = 0; j <= i; ++j) to[j] += value * x[j];
    }
  }
}

template <typename T>
void EliminateByQr(PointRows<T>* rows, Eliminated<T>* out) {
  const std::size_t m = rows->count, size = rows->width() + 1;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) out->root[k][j] = T(0);
  }
  for (int k = 0; k < 3; ++k) {
    for (int pass = 0; pass < 2; ++pass) {  // Gram-Schmidt, each column twice
      for (int j = 0; j < k; ++j) {
        T dot = T(0);
        for (std::size_t i = 0; i < m; ++i) dot += rows->Row(i)[j] * rows->Row(i)[k];
        for (std::size_t i = 0; i < m; ++i) rows->Row(i)[k] -= dot * rows->Row(i)[j];
        out->root[j][k] += dot;
      }
    }
    T square = T(0);
    for (std::size_t i = 0; i < m; ++i) square += rows->Row(i)[k] * rows->Row(i)[k];
    out->root[k][k] = std::sqrt(square);
    for (std::size_t i = 0; i < m; ++i) rows->Row(i)[k] /= out->root[k][k];
  }
  out->projected.assign(3 * size, T(0));
  for (std::size_t i = 0; i < m; ++i) {
    const T* row = rows->Row(i);
    for (std::size_t k = 0; k < 3; ++k) {
      T* to = out->projected.data() + k * size;
      for (std::size_t c = 0; c < size; ++c) to[c] += row[k] * row[3 + c];
    }
  }
  for (std::size_t i = 0; i < m; ++i) {
    T* row = rows->Row(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const T* from = out->projected.data() + k * size;
      for (std::size_t c = 0; c < size; ++c) row[3 + c] -= row[k] * from[c];
    }
  }
  out->square.assign(size * size, T(0));
  AddSquares(rows->Row(0) + 3, m, rows->stride(), size, T(1), &out->square);
}

template <typename T>
void EliminateByNormals(PointRows<T>* rows, Eliminated<T>* out) {
  const std::size_t m = rows->count, size = rows->width() + 1;
  T v[3][3] = {};
  out->projected.assign(3 * size, T(0));
  for (std::size_t i = 0; i < m; ++i) {
    const T* row = rows->Row(i);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j <= k; ++j) v[k][j] += row[k] * row[j];
      T* to = out->projected.data() + k * size;
      for (std::size_t c = 0; c < size; ++c) to[c] += row[k] * row[3 + c];
    }
  }
  // V = L L'; root = L', projected = L^-1 J_p' [J_c | e]. A V that is not positive gives NaN.
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      T sum = v[k][j];
      for (std::size_t i = 0; i < j; ++i) sum -= v[k][i] * v[j][i];
      v[k][j] = sum / v[j][j];
    }
    T pivot = v[k][k];
    for (std::size_t i = 0; i < k; ++i) pivot -= v[k][i] * v[k][i];
    v[k][k] = std::sqrt(pivot);
    T* to = out->projected.data() + k * size;
    for (std::size_t i = 0; i < k; ++i) {
      const T* from = out->projected.data() + i * size;
      for (std::size_t c = 0; c < size; ++c) to[c] -= v[k][i] * from[c];
    }
    for (std::size_t c = 0; c < size; ++c) to[c] /= v[k][k];
    for (std::size_t j = 0; j < 3; ++j) out->root[j][k] = j <= k ? v[k][j] : T(0);
  }
  out->square.assign(size * size, T(0));
  AddSquares(rows->Row(0) + 3, m, rows->stride(), size, T(1), &out->square);
  AddSquares(out->projected.data(), 3, size, size, T(-1), &out->square);
}

/// x = R^-1 x, R upper triangular.
template <typename T>
void SolveRoot(const T (&root)[3][3], T (&x)[3]) {
  for (int k = 2; k >= 0; --k) {
    for (int j = k + 1; j < 3; ++j) x[k] -= root[k][j] * x[j];
    x[k] /= root[k][k];
  }
}

template <typename T>
class Solver {
 public:
  Solver(Elimination elimination, AdjustmentProblem* problem, ProgressSink* progress)
      : elimination_(elimination), problem_(*problem), progress_(progress), reader_(*problem) {}

  ArithmeticSolution Run(BlockState start) {
    ArithmeticSolution out;
    out.state = std::move(start);
    double step_before = kNotGiven;
    for (;; ++out.iterations) {
      Form(out.state);
      if (!Factor()) {
        out.problem = "the reduced matrix is not positive definite in this arithmetic";
        return out;
      }
      std::vector<T> dx = Step();
      double square = point_square_;
      for (std::size_t i = 0; i < dx.size(); ++i) {
        square -= static_cast<double>(gradient_[i]) * static_cast<double>(dx[i]);
      }
      out.remaining_step = std::sqrt(square < 0.0 ? 0.0 : square);
      if (!std::isfinite(out.remaining_step)) {
        out.problem = "a point cannot be eliminated in this arithmetic";
        return out;
      }
      const bool floor = out.iterations >= 2 && !(out.remaining_step < 0.5 * step_before);
      if (out.remaining_step <= kSettledDecrement || floor || out.iterations == kMaxIterations)
        break;
      step_before = out.remaining_step;
      Move(dx, &out.state);
      UpdateWeights(out.state, &problem_);
    }
    FillCovariance(&out);
    out.solved = true;
    return out;
  }

 private:
  template <typename Work>
  void ForPoints(const char* stage, const BlockState& state, const Work& work) {
    const std::size_t points = problem_.block.points.size();
    for (std::size_t point = 0; point < points; ++point) {
      if (point % kPointsPerReport == 0) sarblock::Step(progress_, stage, point, points);
      if (!problem_.Solves(point)) continue;
      reader_.Read(state, point, &rows_);
      if (elimination_ == Elimination::kQr) {
        EliminateByQr(&rows_, &one_);
      } else {
        EliminateByNormals(&rows_, &one_);
      }
      work(point);
    }
  }

  void Form(const BlockState& state) {
    const auto n = static_cast<std::size_t>(problem_.layout.size());
    s_.SetZero(n);
    gradient_.assign(n, T(0));
    point_square_ = 0.0;
    ForPoints("linearise", state, [&](std::size_t) {
      const std::vector<std::size_t>& at = rows_.parameter;
      const std::size_t size = at.size() + 1;
      for (std::size_t i = 0; i < at.size(); ++i) {
        T* row = s_.Row(at[i]);
        const T* from = one_.square.data() + i * size;
        for (std::size_t j = 0; j <= i; ++j) row[at[j]] += from[j];
        gradient_[at[i]] += one_.square[(size - 1) * size + i];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const auto e = static_cast<double>(one_.projected[k * size + size - 1]);
        point_square_ += e * e;
      }
    });
    for (std::size_t i = 0; i < n; ++i) {
      const Parameter& parameter = problem_.layout.parameters[i];
      if (!parameter.has_own_prior()) continue;
      const double weight = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
      const double x = state.corrections[static_cast<Eigen::Index>(i)] - parameter.prior_value;
      s_.Row(i)[i] += static_cast<T>(weight);
      gradient_[i] += static_cast<T>(weight * x);
    }
    for (const JointPriorTerm& prior : problem_.layout.joint_priors) {
      const Eigen::VectorXd x = problem_.layout.FromPrior(prior, state.corrections);
      const Eigen::VectorXd gradient = prior.information * x;
      for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
        const auto row = static_cast<std::size_t>(prior.parameters[i]);
        for (std::size_t j = 0; j < prior.parameters.size(); ++j) {
          const auto column = static_cast<std::size_t>(prior.parameters[j]);
          if (column > row) continue;  // lower triangle
          s_.Row(row)[column] += static_cast<T>(
              prior.information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
        }
        gradient_[row] += static_cast<T>(gradient[static_cast<Eigen::Index>(i)]);
      }
    }
  }

  /// Factors S scaled to unit diagonal.
  [[nodiscard]] bool Factor() {
    const std::size_t n = s_.size();
    scale_.resize(n);
    for (std::size_t i = 0; i < n; ++i) scale_[i] = T(1) / std::sqrt(s_.Row(i)[i]);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) s_.Row(i)[j] *= scale_[i] * scale_[j];
    }
    return s_.Factor();
  }

  /// -S^-1 g.
  [[nodiscard]] std::vector<T> Step() const {
    std::vector<T> x(gradient_);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] *= scale_[i];
    s_.Solve(&x);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] *= -scale_[i];
    return x;
  }

  void Move(const std::vector<T>& dx, BlockState* state) {
    ForPoints("substitute", *state, [&](std::size_t point) {
      const std::vector<std::size_t>& at = rows_.parameter;
      T step[3];
      for (std::size_t k = 0; k < 3; ++k) {
        const T* from = one_.projected.data() + k * (at.size() + 1);
        step[k] = from[at.size()];
        for (std::size_t i = 0; i < at.size(); ++i) step[k] += from[i] * dx[at[i]];
      }
      SolveRoot(one_.root, step);
      state->displacement_m[point] -= Eigen::Vector3d(
          static_cast<double>(step[0]), static_cast<double>(step[1]), static_cast<double>(step[2]));
    });
    for (std::size_t i = 0; i < dx.size(); ++i) {
      state->corrections[static_cast<Eigen::Index>(i)] += static_cast<double>(dx[i]);
    }
  }

  /// cov(p) = R^-1 (I + T C T') R^-T.
  void FillCovariance(ArithmeticSolution* out) {
    const Square<T> c = s_.Inverse();
    SymmetricEnu none{};
    none.fill(kNotGiven);
    out->covariance_m2.assign(problem_.block.points.size(), none);
    std::vector<T> by_c;
    ForPoints("covariance", out->state, [&](std::size_t point) {
      const std::vector<std::size_t>& at = rows_.parameter;
      const std::size_t width = at.size();
      T middle[3][3];
      by_c.resize(width);
      for (std::size_t k = 0; k < 3; ++k) {
        const T* t = one_.projected.data() + k * (width + 1);
        for (std::size_t i = 0; i < width; ++i) {
          T sum = T(0);
          for (std::size_t j = 0; j < width; ++j) {
            const T value = at[j] <= at[i] ? c.Row(at[i])[at[j]] : c.Row(at[j])[at[i]];
            sum += value * scale_[at[j]] * t[j];
          }
          by_c[i] = sum * scale_[at[i]];
        }
        for (std::size_t l = 0; l < 3; ++l) {
          const T* other = one_.projected.data() + l * (width + 1);
          T sum = k == l ? T(1) : T(0);
          for (std::size_t i = 0; i < width; ++i) sum += by_c[i] * other[i];
          middle[k][l] = sum;
        }
      }
      Eigen::Matrix3d covariance;
      for (std::size_t k = 0; k < 3; ++k) SolveRoot(one_.root, middle[k]);  // rows of M R^-T
      for (Eigen::Index l = 0; l < 3; ++l) {
        T column[3] = {middle[0][l], middle[1][l], middle[2][l]};
        SolveRoot(one_.root, column);
        for (Eigen::Index k = 0; k < 3; ++k) covariance(k, l) = static_cast<double>(column[k]);
      }
      out->covariance_m2[point] = ToEnu(problem_.block.frame,
                                        out->state.Position(point),
                                        0.5 * (covariance + covariance.transpose()));
    });
  }

  Elimination elimination_;
  AdjustmentProblem& problem_;
  ProgressSink* progress_;
  RowReader<T> reader_;
  PointRows<T> rows_;
  Eliminated<T> one_;
  Square<T> s_;
  std::vector<T> gradient_, scale_;
  double point_square_ = 0.0;
};

}  // namespace

ArithmeticSolution SolveInArithmetic(Arithmetic arithmetic,
                                     Elimination elimination,
                                     BlockState start,
                                     AdjustmentProblem* problem,
                                     ProgressSink* progress) {
  switch (arithmetic) {
    case Arithmetic::kSingle:
      return Solver<float>(elimination, problem, progress).Run(std::move(start));
    case Arithmetic::kExtended:
      return Solver<long double>(elimination, problem, progress).Run(std::move(start));
    default:
      return Solver<double>(elimination, problem, progress).Run(std::move(start));
  }
}

}  // namespace sarblock
