// SPDX-License-Identifier: Apache-2.0
#include "support/extended_covariance.h"

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "model/look_model_twin.h"
#include <boost/multiprecision/cpp_bin_float.hpp>

namespace sarblock::test {
namespace {

using Digits = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                             boost::multiprecision::et_off>;
using Twin = LookModelTwin<Digits>;

/// A symmetric matrix by rows.
class Square {
 public:
  explicit Square(std::size_t size) : size_(size), values_(size * size, Digits(0)) {}
  Digits& operator()(std::size_t i, std::size_t j) { return values_[i * size_ + j]; }
  const Digits& operator()(std::size_t i, std::size_t j) const { return values_[i * size_ + j]; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::size_t size_;
  std::vector<Digits> values_;
};

/// L of a = L L', in the lower triangle.
Square Cholesky(Square a) {
  for (std::size_t j = 0; j < a.size(); ++j) {
    for (std::size_t i = j; i < a.size(); ++i) {
      Digits sum = a(i, j);
      for (std::size_t k = 0; k < j; ++k) sum -= a(i, k) * a(j, k);
      a(i, j) = i == j ? sqrt(sum) : Digits(sum / a(j, j));
    }
  }
  return a;
}

/// L^-1, lower triangle.
Square InverseOfLower(const Square& l) {
  Square inverse(l.size());
  for (std::size_t j = 0; j < l.size(); ++j) {
    for (std::size_t i = j; i < l.size(); ++i) {
      Digits sum = i == j ? 1 : 0;
      for (std::size_t k = j; k < i; ++k) sum -= l(i, k) * inverse(k, j);
      inverse(i, j) = sum / l(i, i);
    }
  }
  return inverse;
}

/// Largest eigenvalue of m m' or m' m by power iteration: three digits are enough for a condition.
Digits LargestEigenvalue(const Square& m) {
  std::vector<Digits> x(m.size(), Digits(1)), y(m.size());
  Digits value = 0;
  for (int step = 0; step < 60; ++step) {
    for (std::size_t i = 0; i < m.size(); ++i) {
      y[i] = 0;
      for (std::size_t j = 0; j <= i; ++j) y[i] += m(i, j) * x[j];
    }
    std::fill(x.begin(), x.end(), Digits(0));
    Digits square = 0;
    for (std::size_t i = 0; i < m.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) x[j] += m(i, j) * y[i];
    }
    for (const Digits& xi : x) square += xi * xi;
    value = sqrt(square);
    for (Digits& xi : x) xi /= value;
  }
  return value;
}

using Row = std::vector<std::pair<std::size_t, Digits>>;

/// All normal equations: three columns a point, then the corrections.
class Normals {
 public:
  Normals(const AdjustmentProblem& problem,
          const std::vector<CorrectionGroup>& groups,
          const BlockState& state)
      : problem_(problem),
        twin_(problem.block, groups),
        first_(3 * problem.block.points.size()),
        matrix(first_ + static_cast<std::size_t>(problem.layout.size())) {
    for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
      const Parameter& parameter = problem.layout.parameters[i];
      values_[{parameter.owner, parameter.name}] =
          Digits(state.corrections[static_cast<Eigen::Index>(i)]);
    }
    for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
      const Vec<Digits> p =
          Cast<Digits>(state.start_m[point]) + Cast<Digits>(state.displacement_m[point]);
      const auto& offsets = problem.block.looks.offsets;
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) AddLook(point, i, p);
      if (problem.control_of[point] >= 0) AddControl(point);
    }
    for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
      const Parameter& parameter = problem.layout.parameters[i];
      if (parameter.has_prior()) Add({{first_ + i, Digits(1) / Digits(parameter.prior_sigma)}});
    }
  }

 private:
  void Add(const Row& row) {
    for (const auto& [i, a] : row) {
      for (const auto& [j, b] : row) {
        if (j <= i) matrix(i, j) += a * b;
      }
    }
  }

  void AddLook(std::size_t point, std::size_t look, const Vec<Digits>& p) {
    const Digits step("1e-15");
    const LookWeights& w = problem_.weights[look];
    Row range, time;
    const auto add =
        [&](std::size_t column, const TwinErrors<Digits>& after, const TwinErrors<Digits>& before) {
          const Digits r = (after.range - before.range) / (2 * step);
          const Digits t = (after.azimuth - before.azimuth) / (2 * step);
          range.emplace_back(column, Digits(w.range_per_m) * r);
          time.emplace_back(column, Digits(w.azimuth_per_unit) * t);
        };
    const Looks& looks = problem_.block.looks;
    const Digits read = problem_.model.paths()[looks.pass[look]].ReadingTime_s(looks.time_s[look],
                                                                               looks.time_s[look]);
    std::pair<std::string, std::string> moved;
    Digits by = 0;
    const Twin::Value value = [&](const std::string& owner, const std::string& name) {
      const Digits& x = values_.at({owner, name});
      return std::pair(owner, name) == moved ? Digits(x + by) : x;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec<Digits> after = p, before = p;
      after[axis] += step;
      before[axis] -= step;
      add(3 * point + axis,
          twin_.Errors(look, after, value, read),
          twin_.Errors(look, before, value, read));
    }
    LookColumns columns;
    problem_.model.ColumnsOf(look, &columns);
    for (int b = 0; b < columns.block_count; ++b) {
      const ParameterBlock& block =
          problem_.layout
              .blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
      for (int c = 0; c < block.size; ++c) {
        const auto index = static_cast<std::size_t>(block.offset + c);
        moved = {problem_.layout.parameters[index].owner, problem_.layout.parameters[index].name};
        by = step;
        const TwinErrors<Digits> after = twin_.Errors(look, p, value, read);
        by = -step;
        add(first_ + index, after, twin_.Errors(look, p, value, read));
      }
    }
    Add(range);
    Add(time);
  }

  void AddControl(std::size_t point) {
    const ControlEquations& control =
        problem_.control[static_cast<std::size_t>(problem_.control_of[point])];
    for (int r = 0; r < control.rows; ++r) {
      Row row;
      for (int axis = 0; axis < 3; ++axis) {
        row.emplace_back(3 * point + static_cast<std::size_t>(axis),
                         Digits(control.weight(r, axis)));
      }
      Add(row);
    }
  }

  const AdjustmentProblem& problem_;
  Twin twin_;
  std::size_t first_;
  std::map<std::pair<std::string, std::string>, Digits> values_;

 public:
  Square matrix;
};

}  // namespace

ExtendedCovariance CovarianceInFiftyDigits(const AdjustmentProblem& problem,
                                           const std::vector<CorrectionGroup>& groups,
                                           const BlockState& state) {
  Square n = Normals(problem, groups, state).matrix;
  std::vector<Digits> scale(n.size());
  for (std::size_t i = 0; i < n.size(); ++i) scale[i] = 1 / sqrt(n(i, i));
  for (std::size_t i = 0; i < n.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) n(i, j) *= scale[i] * scale[j];
  }
  const Square l = Cholesky(n);
  const Square inverse = InverseOfLower(l);
  ExtendedCovariance out;
  out.condition = static_cast<double>(sqrt(LargestEigenvalue(l) * LargestEigenvalue(inverse)));
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    Eigen::Matrix3d covariance;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const std::size_t i = 3 * point + a, j = 3 * point + b;
        Digits sum = 0;
        for (std::size_t k = std::max(i, j); k < n.size(); ++k)
          sum += inverse(k, i) * inverse(k, j);
        covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) =
            static_cast<double>(Digits(sum * scale[i] * scale[j]));
      }
    }
    out.points.push_back(covariance);
  }
  return out;
}

}  // namespace sarblock::test
