// SPDX-License-Identifier: Apache-2.0
#include "sarblock/cost/problem_covariance.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "linear/block_cholesky.h"
#include "linear/block_matrix.h"
#include "linear/dense.h"
#include <Eigen/Core>
#include <ceres/crs_matrix.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

namespace sarblock {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// 1 / condition of a point's rows and the least eigenvalue of the other equations, both scaled,
/// that are taken for determined.
constexpr double kDetermined = 1e-12;
/// Pivots of the scaled equations that are above this need no eigenvalue.
constexpr double kSurePivot = 1e-9;
/// Sums over points: so many at a time, as long as they take at most so many bytes.
constexpr std::size_t kPieces = 16, kMaxBytesOfPieces = std::size_t{1} << 28U;
/// Pairs of blocks that are kept before those that are there twice leave.
constexpr std::size_t kMaxPairs = std::size_t{1} << 22U;

/// A parameter block that is not constant, at its place among those that are estimated.
struct Estimated {
  double* values = nullptr;
  bool is_point = false;
  std::size_t number = 0;  ///< as messages count it: among the points given, or the others
  int ambient = 0, tangent = 0;
  MatrixXd plus = {};  ///< ambient x tangent; empty without a manifold
};

/// Where the rows of a point and what is made of them stand in the flat arrays.
struct Point {
  std::size_t first_row = 0, last_row = 0;      ///< in rows_
  std::size_t first_block = 0, last_block = 0;  ///< in blocks_
  int width = 0;                                ///< columns of these blocks
  std::size_t gain = 0;                         ///< in gains_: -R^-1 T, size x width
  std::size_t own = 0;                          ///< in owns_: R^-1 R^-T, size x size
};

/// A few pairs of blocks, each once.
class Pairs {
 public:
  void Add(std::span<const int> ascending) {
    for (std::size_t i = 0; i < ascending.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) keys_.push_back({ascending[i], ascending[j]});
    }
    if (keys_.size() >= limit_) Shrink();
  }
  [[nodiscard]] std::vector<std::pair<int, int>> Take() && {
    Shrink();
    return std::move(keys_);
  }

 private:
  void Shrink() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    limit_ = std::max(kMaxPairs, 2 * keys_.size());
  }
  std::vector<std::pair<int, int>> keys_;
  std::size_t limit_ = kMaxPairs;
};

/// Householder's QR of the first `size` columns of a column-major matrix, applied to all of them:
/// R in the upper triangle, zeros below, Q' of the rest in the other columns (Golub and Van Loan,
/// Matrix Computations, 5.2.1).
void Triangularise(int size, MatrixXd* a) {
  for (Index k = 0; k < std::min<Index>(size, a->rows()); ++k) {
    const Index left = a->rows() - k;
    const double length = a->col(k).tail(left).norm();
    if (!(length > 0.0)) continue;
    VectorXd v = a->col(k).tail(left);
    v[0] += std::copysign(length, v[0]);
    const double square = v.squaredNorm();
    for (Index c = k; c < a->cols(); ++c) {
      auto column = a->col(c).tail(left);
      column -= (2.0 * v.dot(column) / square) * v;
    }
    a->col(k).tail(left - 1).setZero();
  }
}

}  // namespace

struct ProblemCovariance::Impl {
  Impl(ceres::Problem& problem,
       std::span<double* const> asked_points,
       const ProblemCovarianceOptions& asked)
      : name(asked.name), point_count(0) {
    const dense::BlasThreadsKept kept;
    List(problem, asked_points);
    RunInLibrary(asked.threads, nullptr, [&] {
      ceres::CRSMatrix jacobian = Evaluate(problem, asked);
      row_count = static_cast<std::size_t>(jacobian.num_rows);
      SortRows(jacobian);
      Connect(jacobian);
      Eliminate(jacobian);
      jacobian = {};
      Invert();
    });
    name = nullptr;
  }

  /// All blocks in the order in which the residuals name them; those that none names last. That of
  /// the problem is the order of their addresses, which differs from run to run.
  static std::vector<double*> InOrderOfUse(const ceres::Problem& problem) {
    std::vector<ceres::ResidualBlockId> residuals;
    problem.GetResidualBlocks(&residuals);
    std::vector<double*> out, blocks;
    std::unordered_set<const double*> listed;
    for (const ceres::ResidualBlockId residual : residuals) {
      problem.GetParameterBlocksForResidualBlock(residual, &blocks);
      for (double* block : blocks) {
        if (listed.insert(block).second) out.push_back(block);
      }
    }
    problem.GetParameterBlocks(&blocks);
    for (double* block : blocks) {
      if (listed.insert(block).second) out.push_back(block);
    }
    return out;
  }

  /// The blocks in the order of the Jacobian: points, then the others as the residuals name
  /// them.
  void List(ceres::Problem& problem, std::span<double* const> asked_points) {
    const std::vector<double*> all = InOrderOfUse(problem);
    for (double* block : all) place_of.emplace(block, kConstant);
    std::unordered_map<const double*, std::size_t> given;
    for (std::size_t i = 0; i < asked_points.size(); ++i) {
      if (!place_of.contains(asked_points[i])) {
        throw InputError("points", "number " + std::to_string(i) + " is no block of the problem");
      }
      if (!given.emplace(asked_points[i], i).second) {
        throw InputError("points",
                         "number " + std::to_string(i) + " is number " +
                             std::to_string(given.at(asked_points[i])) + " as well");
      }
      if (problem.IsParameterBlockConstant(asked_points[i])) continue;
      Add(problem, {.values = asked_points[i], .is_point = true, .number = i});
    }
    point_count = blocks.size();
    std::size_t number = 0;
    for (double* block : all) {
      if (given.contains(block)) continue;
      if (!problem.IsParameterBlockConstant(block)) {
        Add(problem, {.values = block, .number = number});
      }
      ++number;
    }
    for (const auto& [block, place] : place_of) {
      if (place == kConstant) constant_size.emplace(block, Sizes(problem, block));
    }
  }

  static std::array<int, 2> Sizes(const ceres::Problem& problem, const double* block) {
    return {problem.ParameterBlockSize(block), problem.ParameterBlockTangentSize(block)};
  }

  void Add(const ceres::Problem& problem, Estimated block) {
    const auto [ambient, tangent] = Sizes(problem, block.values);
    block.ambient = ambient;
    block.tangent = tangent;
    if (problem.HasManifold(block.values)) {
      RowMajor plus(ambient, tangent);
      if (!problem.GetManifold(block.values)->PlusJacobian(block.values, plus.data())) {
        throw InputError(NameOf(block), "its manifold has no derivative here");
      }
      block.plus = plus;
    }
    for (int i = 0; i < ambient; ++i) {
      const double value = block.values[i];
      const bool held = value <= problem.GetParameterLowerBound(block.values, i) ||
                        value >= problem.GetParameterUpperBound(block.values, i);
      if (!held) continue;
      throw InputError(NameOf(block),
                       "value " + std::to_string(i) +
                           " is held by a bound: such an unknown has no normal distribution");
    }
    place_of[block.values] = static_cast<int>(blocks.size());
    columns += tangent;
    blocks.push_back(std::move(block));
  }

  [[nodiscard]] std::string NameOf(const Estimated& block) const {
    if (name) {
      std::string given = name(block.values);
      if (!given.empty()) return given;
    }
    return (block.is_point ? "point " : "block ") + std::to_string(block.number);
  }
  [[nodiscard]] std::string NameOf(std::size_t place) const { return NameOf(blocks[place]); }

  [[nodiscard]] ceres::CRSMatrix Evaluate(ceres::Problem& problem,
                                          const ProblemCovarianceOptions& asked) const {
    ceres::CRSMatrix jacobian;
    if (blocks.empty()) return jacobian;
    ceres::Problem::EvaluateOptions options;
    for (const Estimated& block : blocks) options.parameter_blocks.push_back(block.values);
    options.apply_loss_function = asked.apply_loss_function;
    options.num_threads = ThreadsAllowed();
    if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) {
      throw InputError("problem", "a residual has no value at the present parameters");
    }
    for (const double value : jacobian.values) {
      if (!std::isfinite(value)) throw InputError("problem", "its Jacobian is not finite");
    }
    return jacobian;
  }

  /// Calls visit(place, first entry) for each block of a row; its entries follow one another.
  template <typename Visit>
  void ForBlocks(const ceres::CRSMatrix& jacobian, int row, const Visit& visit) const {
    const int end = jacobian.rows[static_cast<std::size_t>(row) + 1];
    for (int k = jacobian.rows[static_cast<std::size_t>(row)]; k < end;) {
      const int place = block_of_column[Column(jacobian, k)];
      visit(place, k);
      k += blocks[static_cast<std::size_t>(place)].tangent;
    }
  }
  static std::size_t Column(const ceres::CRSMatrix& jacobian, int entry) {
    return static_cast<std::size_t>(jacobian.cols[static_cast<std::size_t>(entry)]);
  }

  /// Rows by point, those without one last.
  void SortRows(const ceres::CRSMatrix& jacobian) {
    block_of_column.reserve(static_cast<std::size_t>(columns));
    for (std::size_t place = 0; place < blocks.size(); ++place) {
      const auto size = static_cast<std::size_t>(blocks[place].tangent);
      block_of_column.insert(block_of_column.end(), size, static_cast<int>(place));
    }
    std::vector<std::uint32_t> point_of(row_count, static_cast<std::uint32_t>(point_count));
    std::vector<std::size_t> begin(point_count + 2, 0);
    for (std::size_t row = 0; row < row_count; ++row) {
      ForBlocks(jacobian, static_cast<int>(row), [&](int place, int) {
        if (static_cast<std::size_t>(place) >= point_count) return;
        if (point_of[row] < point_count) {
          throw InputError("points",
                           NameOf(point_of[row]) + " and " +
                               NameOf(static_cast<std::size_t>(place)) +
                               " have a residual in common: only one of them may be a point");
        }
        point_of[row] = static_cast<std::uint32_t>(place);
      });
      ++begin[point_of[row] + 1];
    }
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    points.resize(point_count + 1);
    for (std::size_t i = 0; i <= point_count; ++i) {
      points[i].first_row = begin[i];
      points[i].last_row = begin[i + 1];
    }
    rows.resize(row_count);
    for (std::size_t row = 0; row < row_count; ++row) {
      rows[begin[point_of[row]]++] = static_cast<int>(row);
    }
  }

  /// The other blocks that each point meets, and the pattern of their equations.
  void Connect(const ceres::CRSMatrix& jacobian) {
    const auto others = blocks.size() - point_count;
    Pairs pairs;
    std::vector<int> met;
    const auto meet = [&](int row) {
      ForBlocks(jacobian, row, [&](int place, int) {
        const int other = place - static_cast<int>(point_count);
        if (other >= 0) met.push_back(other);
      });
    };
    const auto sort = [&] {
      std::sort(met.begin(), met.end());
      met.erase(std::unique(met.begin(), met.end()), met.end());
      pairs.Add(met);
    };
    std::size_t gain = 0, own = 0;
    for (std::size_t i = 0; i < point_count; ++i) {
      Point& point = points[i];
      met.clear();
      for (std::size_t k = point.first_row; k < point.last_row; ++k) meet(rows[k]);
      sort();
      point.first_block = met_blocks.size();
      met_blocks.insert(met_blocks.end(), met.begin(), met.end());
      point.last_block = met_blocks.size();
      for (const int other : met) point.width += SizeOf(other);
      const auto size = static_cast<std::size_t>(blocks[i].tangent);
      point.gain = gain;
      point.own = own;
      gain += size * static_cast<std::size_t>(point.width);
      own += size * size;
    }
    gains.resize(gain);
    owns.resize(own);
    for (std::size_t k = points.back().first_row; k < points.back().last_row; ++k) {
      met.clear();
      meet(rows[k]);
      sort();
    }
    std::vector<int> sizes;
    for (std::size_t i = 0; i < others; ++i) sizes.push_back(SizeOf(static_cast<int>(i)));
    pattern = std::make_shared<const BlockPattern>(std::move(sizes), std::move(pairs).Take());
  }
  [[nodiscard]] int SizeOf(int other) const {
    return blocks[point_count + static_cast<std::size_t>(other)].tangent;
  }
  [[nodiscard]] std::span<const int> MetBy(const Point& point) const {
    return std::span(met_blocks).subspan(point.first_block, point.last_block - point.first_block);
  }

  /// Sums the equations of the other blocks: those of points by pieces, side by side.
  void Eliminate(const ceres::CRSMatrix& jacobian) {
    equations.emplace(pattern);
    const std::size_t bytes = sizeof(double) * equations->values().size();
    const std::size_t pieces =
        std::clamp<std::size_t>(kMaxBytesOfPieces / std::max<std::size_t>(1, bytes), 1, kPieces);
    const std::size_t size = point_count / pieces + 1;
    std::vector<std::optional<BlockSymmetricMatrix>> sums(pieces);
    std::vector<std::vector<std::size_t>> undetermined(pieces);
    ParallelForChunks(
        point_count, size, [&](std::size_t piece, std::size_t begin, std::size_t end) {
          sums[piece].emplace(pattern);
          MatrixXd work;
          for (std::size_t i = begin; i < end; ++i) {
            if (!EliminatePoint(jacobian, i, &work, &*sums[piece]))
              undetermined[piece].push_back(i);
          }
        });
    std::vector<std::string> names;
    for (const std::vector<std::size_t>& of_piece : undetermined) {
      for (const std::size_t i : of_piece) names.push_back(NameOf(i));
    }
    if (!names.empty()) {
      throw UndeterminedError("the residuals do not determine these points", names);
    }
    for (const std::optional<BlockSymmetricMatrix>& sum : sums) {
      if (!sum) continue;
      for (std::size_t k = 0; k < sum->values().size(); ++k) {
        equations->values()[k] += sum->values()[k];
      }
    }
    const Point& rest = points.back();
    for (std::size_t k = rest.first_row; k < rest.last_row; ++k) {
      AddRow(jacobian, rows[k]);
    }
  }

  /// Columns of the point and of the blocks that it meets, row by row of its own.
  void Gather(const ceres::CRSMatrix& jacobian, std::size_t i, MatrixXd* out) const {
    const Point& point = points[i];
    const std::span<const int> met = MetBy(point);
    const int size = blocks[i].tangent;
    std::vector<int> first_column;
    int next = size;
    for (const int other : met) {
      first_column.push_back(next);
      next += SizeOf(other);
    }
    out->setZero(static_cast<Index>(point.last_row - point.first_row), size + point.width);
    for (std::size_t k = point.first_row; k < point.last_row; ++k) {
      const auto row = static_cast<Index>(k - point.first_row);
      ForBlocks(jacobian, rows[k], [&](int place, int entry) {
        int column = 0;
        if (static_cast<std::size_t>(place) >= point_count) {
          const int other = place - static_cast<int>(point_count);
          const auto found = std::lower_bound(met.begin(), met.end(), other);
          column = first_column[static_cast<std::size_t>(found - met.begin())];
        }
        for (int c = 0; c < blocks[static_cast<std::size_t>(place)].tangent; ++c) {
          (*out)(row, column + c) = jacobian.values[static_cast<std::size_t>(entry + c)];
        }
      });
    }
  }

  /// False where its rows do not determine the point.
  bool EliminatePoint(const ceres::CRSMatrix& jacobian,
                      std::size_t i,
                      MatrixXd* work,
                      BlockSymmetricMatrix* sum) {
    const Point& point = points[i];
    const Index size = blocks[i].tangent;
    Gather(jacobian, i, work);
    const VectorXd length = work->leftCols(size).colwise().norm().transpose();
    if (work->rows() < size || !(length.minCoeff() > 0.0)) return false;
    for (Index c = 0; c < size; ++c) work->col(c) /= length[c];
    Triangularise(static_cast<int>(size), work);
    const auto r = work->topLeftCorner(size, size).triangularView<Eigen::Upper>();
    MatrixXd r_inverse = MatrixXd::Identity(size, size);
    if (!(work->diagonal().head(size).cwiseAbs().minCoeff() > 0.0)) return false;
    r.solveInPlace(r_inverse);
    // Columns have unit length: |R| is the root of their number (Frobenius).
    const double condition = std::sqrt(static_cast<double>(size)) * r_inverse.norm();
    if (!(condition * kDetermined < 1.0)) return false;
    r_inverse = length.cwiseInverse().asDiagonal() * r_inverse;
    Eigen::Map<MatrixXd>(owns.data() + point.own, size, size) = r_inverse * r_inverse.transpose();
    const auto t = work->topRightCorner(size, point.width);
    Eigen::Map<MatrixXd>(gains.data() + point.gain, size, point.width) = -r_inverse * t;
    const Index left = work->rows() - size;
    if (left == 0) return true;
    const auto rest = work->bottomRightCorner(left, point.width);
    const std::span<const int> met = MetBy(point);
    Index column = 0;
    for (const int j : met) {
      Index row = 0;
      for (const int other : met) {
        if (other >= j) {
          sum->Block(other, j).noalias() +=
              rest.middleCols(row, SizeOf(other)).transpose() * rest.middleCols(column, SizeOf(j));
        }
        row += SizeOf(other);
      }
      column += SizeOf(j);
    }
    return true;
  }

  /// A residual that has no point.
  void AddRow(const ceres::CRSMatrix& jacobian, int row) {
    ForBlocks(jacobian, row, [&](int place_a, int entry_a) {
      ForBlocks(jacobian, row, [&](int place_b, int entry_b) {
        if (place_b > place_a) return;
        const int a = place_a - static_cast<int>(point_count);
        const int b = place_b - static_cast<int>(point_count);
        const Eigen::Map<const VectorXd> of_a(jacobian.values.data() + entry_a, SizeOf(a));
        const Eigen::Map<const VectorXd> of_b(jacobian.values.data() + entry_b, SizeOf(b));
        equations->Block(a, b).noalias() += of_a * of_b.transpose();
      });
    });
  }

  void Invert() {
    if (pattern->rows() == 0) return;
    scale = VectorXd(pattern->rows());
    std::vector<std::string> free;
    for (int b = 0; b < pattern->block_count(); ++b) {
      const VectorXd diagonal = equations->Block(b, b).diagonal();
      if (!(diagonal.minCoeff() > 0.0)) {
        free.push_back(NameOf(point_count + static_cast<std::size_t>(b)));
      }
      scale.segment(pattern->offset(b), diagonal.size()) = diagonal.cwiseSqrt().cwiseInverse();
    }
    if (!free.empty()) {
      throw UndeterminedError("the residuals do not determine these blocks", free);
    }
    ScaleBlocks(scale, &*equations);
    factor.emplace(pattern);
    const BlockCholesky::Outcome outcome = factor->Factorize(*equations);
    if (!outcome.positive_definite || outcome.smallest_pivot_ratio < kSurePivot) {
      RequireDetermined();
    }
    inverse.emplace(factor->SelectedInverse());
    ScaleBlocks(scale, &*inverse);
    equations.reset();
  }

  /// The direction of the least eigenvalue by inverse iteration, and what moves along it.
  void RequireDetermined() {
    BlockSymmetricMatrix shifted = *equations;
    for (int b = 0; b < pattern->block_count(); ++b) {
      shifted.Block(b, b).diagonal().array() += kDetermined;
    }
    BlockCholesky of_shifted(pattern);
    VectorXd x(pattern->rows());
    for (Index k = 0; k < x.size(); ++k) x[k] = 1.0 + 0.5 * std::sin(1.0 + static_cast<double>(k));
    double least = 0.0;
    if (of_shifted.Factorize(shifted).positive_definite) {
      constexpr int kIterations = 8;
      for (int step = 0; step < kIterations; ++step) {
        x.normalize();
        MatrixXd column = x;
        of_shifted.Solve(column);
        x = column;
      }
      x.normalize();
      least = x.dot(equations->Multiply(x).col(0));
    }
    if (least > kDetermined) {
      if (factor->Factorize(*equations).positive_definite) return;
    }
    std::vector<std::string> names;
    const double most = x.cwiseAbs().maxCoeff();
    constexpr double kMoves = 0.01;
    for (int b = 0; b < pattern->block_count(); ++b) {
      const auto part = x.segment(pattern->offset(b), pattern->size(b));
      if (part.cwiseAbs().maxCoeff() < kMoves * most) continue;
      names.push_back(NameOf(point_count + static_cast<std::size_t>(b)));
    }
    throw UndeterminedError(names.size() > 1
                                ? "these blocks can move together and change no residual"
                                : "the residuals do not determine this block",
                            names);
  }

  /// What a block is of the others: its unknowns are gain times those of `others`, plus noise of
  /// its own residuals.
  struct Combination {
    std::span<const int> others;
    MatrixXd gain;
  };
  /// `self`: the place among the others, of one that is no point.
  [[nodiscard]] Combination CombinationOf(int place, const int* self) const {
    const auto p = static_cast<std::size_t>(place);
    const Index size = blocks[p].tangent;
    if (p >= point_count) return {std::span(self, 1), MatrixXd::Identity(size, size)};
    const Point& point = points[p];
    return {MetBy(point), Eigen::Map<const MatrixXd>(gains.data() + point.gain, size, point.width)};
  }

  /// C over these blocks; nothing where one of its pairs is not in the pattern.
  [[nodiscard]] std::optional<MatrixXd> Selected(const Combination& a, const Combination& b) const {
    MatrixXd out(a.gain.cols(), b.gain.cols());
    Index row = 0;
    for (const int i : a.others) {
      Index column = 0;
      for (const int j : b.others) {
        if (!inverse->Contains(std::max(i, j), std::min(i, j))) return std::nullopt;
        auto block = out.block(row, column, SizeOf(i), SizeOf(j));
        if (i >= j) {
          block = inverse->Block(i, j);
        } else {
          block = inverse->Block(j, i).transpose();
        }
        column += SizeOf(j);
      }
      row += SizeOf(i);
    }
    return out;
  }

  /// The same by a solution with the factor.
  [[nodiscard]] MatrixXd Solved(const Combination& a, const Combination& b) const {
    MatrixXd x = MatrixXd::Zero(pattern->rows(), b.gain.rows());
    Index column = 0;
    for (const int j : b.others) {
      x.middleRows(pattern->offset(j), SizeOf(j)) +=
          b.gain.middleCols(column, SizeOf(j)).transpose();
      column += SizeOf(j);
    }
    x = scale.asDiagonal() * x;
    factor->Solve(x);
    x = scale.asDiagonal() * x;
    MatrixXd out = MatrixXd::Zero(a.gain.rows(), b.gain.rows());
    Index row = 0;
    for (const int i : a.others) {
      out += a.gain.middleCols(row, SizeOf(i)) * x.middleRows(pattern->offset(i), SizeOf(i));
      row += SizeOf(i);
    }
    return out;
  }

  [[nodiscard]] MatrixXd Tangent(int a, int b) const {
    const int self_a = a - static_cast<int>(point_count),
              self_b = b - static_cast<int>(point_count);
    const Combination of_a = CombinationOf(a, &self_a), of_b = CombinationOf(b, &self_b);
    MatrixXd out = MatrixXd::Zero(of_a.gain.rows(), of_b.gain.rows());
    if (!of_a.others.empty() && !of_b.others.empty()) {
      if (const std::optional<MatrixXd> selected = Selected(of_a, of_b)) {
        out = of_a.gain * *selected * of_b.gain.transpose();
      } else {
        out = Solved(of_a, of_b);
      }
    }
    if (a == b && static_cast<std::size_t>(a) < point_count) {
      out += Eigen::Map<const MatrixXd>(
          owns.data() + points[static_cast<std::size_t>(a)].own, out.rows(), out.cols());
    }
    return out;
  }

  /// Number of values of a block, and its place; kConstant for one that was constant.
  [[nodiscard]] int PlaceOf(const double* block, const char* argument) const {
    const auto found = place_of.find(block);
    if (found == place_of.end()) throw InputError(argument, "was no block of the problem");
    return found->second;
  }
  [[nodiscard]] int Size(const double* block, int place, bool tangent) const {
    if (place == kConstant) return constant_size.at(block)[tangent ? 1 : 0];
    const Estimated& of = blocks[static_cast<std::size_t>(place)];
    return tangent ? of.tangent : of.ambient;
  }
  [[nodiscard]] MatrixXd Lifted(int place, const MatrixXd& rows_of_it) const {
    const MatrixXd& plus = blocks[static_cast<std::size_t>(place)].plus;
    return plus.size() > 0 ? MatrixXd(plus * rows_of_it) : rows_of_it;
  }

  void Get(const double* a, const double* b, bool tangent, double* values) const {
    const int place_a = PlaceOf(a, "a"), place_b = PlaceOf(b, "b");
    Eigen::Map<RowMajor> out(values, Size(a, place_a, tangent), Size(b, place_b, tangent));
    if (place_a == kConstant || place_b == kConstant) {
      out.setZero();
      return;
    }
    const MatrixXd c = Tangent(place_a, place_b);
    out = tangent ? c : MatrixXd(Lifted(place_b, Lifted(place_a, c).transpose()).transpose());
  }

  static constexpr int kConstant = -1;
  std::function<std::string(const double*)> name;
  std::vector<Estimated> blocks;  ///< points, then others
  std::size_t point_count;
  std::unordered_map<const double*, int> place_of;
  std::unordered_map<const double*, std::array<int, 2>> constant_size;
  int columns = 0;
  std::size_t row_count = 0;
  std::vector<int> block_of_column;
  std::vector<int> rows;      ///< of the Jacobian, by point
  std::vector<Point> points;  ///< and one more: the rows without a point
  std::vector<int> met_blocks;
  std::vector<double> gains, owns;
  std::shared_ptr<const BlockPattern> pattern;
  std::optional<BlockSymmetricMatrix> equations, inverse;
  VectorXd scale;
  std::optional<BlockCholesky> factor;
};

ProblemCovariance::ProblemCovariance(ceres::Problem& problem,
                                     std::span<double* const> points,
                                     const ProblemCovarianceOptions& options)
    : impl_(std::make_unique<Impl>(problem, points, options)) {}
ProblemCovariance::~ProblemCovariance() = default;
ProblemCovariance::ProblemCovariance(ProblemCovariance&&) noexcept = default;
ProblemCovariance& ProblemCovariance::operator=(ProblemCovariance&&) noexcept = default;

void ProblemCovariance::Get(const double* a, const double* b, double* values) const {
  impl_->Get(a, b, false, values);
}
void ProblemCovariance::GetInTangentSpace(const double* a, const double* b, double* values) const {
  impl_->Get(a, b, true, values);
}
std::size_t ProblemCovariance::rows() const { return impl_->row_count; }
std::size_t ProblemCovariance::unknowns() const { return static_cast<std::size_t>(impl_->columns); }

}  // namespace sarblock
