// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "back.h"
#include "linear/block_cholesky.h"
#include "model/problem.h"
#include "pieces.h"
#include "point.h"
#include <Eigen/Core>

namespace sarblock {

/// What a system does with a point that hundreds of passes see (pieces.h).
enum class ManyLooks {
  kBorder,     ///< rows of a border, where that pays
  kEliminate,  ///< eliminates it like all others: the pattern has all pairs of its passes
};

/// S^-1 where it is wanted, unscaled: covariances of corrections.
struct CorrectionCovariance {
  BlockSymmetricMatrix blocks;  ///< on the pattern of S: of passes that see common points
  BorderedPoints bordered;      ///< points whose passes the pattern does not join
  Border t_c;  ///< their T C (PointColumns) where T is: rows of `bordered`, by parameter

  [[nodiscard]] int rows() const { return blocks.rows(); }
};

/// Memory and work of a system, in doubles and operations; nothing of it is allocated before it is
/// formed.
struct SystemNeeds {
  std::size_t matrix = 0;        ///< S on its pattern
  std::size_t border = 0;        ///< values of the rows of points that many passes see
  std::size_t partial_sums = 0;  ///< while it is formed, the most at once
  std::size_t kept = 0;          ///< factors of points
  double operations = 0.0;       ///< of the sum over points
  FactorNeeds factor;
};

/// The reduced normal equations of the corrections, points eliminated (model.md, section 7;
/// docs/theory/covariance.md, eq. (3)-(8)):
///
///     S = P + sum_j (Q2' J_c)' (Q2' J_c),   g = P x + sum_j (Q2' J_c)' Q2' e,    P priors
///
/// each point by a QR factorisation of its own equations, so that thin intersections cost no
/// digits. Where elimination of the points leaves enough of every correction's equations, the same
/// sum is formed as J_c' J_c - (Q' J_c)' (Q' J_c), which is less work for a point of many looks.
/// Scaled to unit diagonal before it is factored. The sums are formed in a fixed order: results do
/// not depend on the number of threads.
class ReducedSystem {
 public:
  /// Finds the pattern of S from the looks that take part. `most_kept_bytes`: see KeepFactors.
  explicit ReducedSystem(const AdjustmentProblem& problem,
                         std::size_t most_kept_bytes = 0,
                         ManyLooks many = ManyLooks::kBorder);

  /// From the next Form on the factors of points are kept for a sweep at the same state, if they
  /// fit into so many bytes.
  void KeepFactors(std::size_t most_bytes);

  /// Forms S and its right-hand side at a state, priors included, with `damping` times the
  /// diagonal of J'J added to every unknown (0: none).
  void Form(const BlockState& state,
            const Weighting& weighting,
            ProgressSink* progress,
            double damping = 0.0);

  /// The same after the points of the state have followed its corrections: each is moved until its
  /// own step is at most `settle_below` standard deviations (SettlePoint).
  void FormSettled(const Weighting& weighting,
                   double damping,
                   double settle_below,
                   BlockState* state,
                   ProgressSink* progress);

  /// S scaled to unit diagonal, except where elimination cancelled a diagonal element; reserves the
  /// factor. Requires at least one correction.
  [[nodiscard]] BorderedMatrix FormScaled();
  /// The factor of the scaled S, for callers that factor it themselves (solve/rank.h); after
  /// FormScaled.
  [[nodiscard]] BorderedCholesky& factor() { return *factor_; }
  [[nodiscard]] const AdjustmentProblem& problem() const { return problem_; }
  /// Units of the parameters in which the scaled S has a unit diagonal; after a factorisation.
  [[nodiscard]] const Eigen::VectorXd& Unit() const { return scale_; }

  /// Factors without looking for the null space; false where that fails. For damped systems.
  [[nodiscard]] bool FactorDamped();
  /// Decrease of the cost that the quadratic model predicts of a step of the corrections, their own
  /// part.
  [[nodiscard]] double PredictedDecrease(const Eigen::VectorXd& dx) const;

  /// Factors of the last Form, if it was asked to keep them, they fit, and neither damping nor a
  /// robust loss changed them; else null.
  [[nodiscard]] const KeptFactors* kept() const { return kept_ ? &*kept_ : nullptr; }

  [[nodiscard]] double cost() const { return cost_; }
  [[nodiscard]] int looks_not_evaluated() const { return looks_not_evaluated_; }
  /// Index of the first point that has a look without a value; PointTotals::kNoPoint if none has.
  [[nodiscard]] std::size_t first_not_evaluated() const { return first_not_evaluated_; }
  /// Looks that read a path continued beyond its ends: allowed on the way, not at a solution.
  [[nodiscard]] int looks_beyond_path() const { return looks_beyond_path_; }
  /// Largest relative change of a weight of an azimuth where weights were renewed.
  [[nodiscard]] double weight_change() const { return weight_change_; }
  /// Points whose own equations are rank deficient, ascending.
  [[nodiscard]] const std::vector<WeakPoint>& weak_points() const { return weak_points_; }
  /// Largest |g_i| / sqrt(H_ii) over points and corrections, dimensionless.
  [[nodiscard]] double gradient() const { return gradient_; }

  /// S and g as formed, unscaled, priors included.
  [[nodiscard]] const BorderedMatrix& matrix() const { return s_; }
  [[nodiscard]] const Eigen::VectorXd& right_side() const { return right_side_; }
  /// Diagonal of J'J of the corrections before points are eliminated, priors included.
  [[nodiscard]] const Eigen::VectorXd& full_diagonal() const { return full_diagonal_; }
  /// Square of the points' own Newton steps, in sigmas: twice the decrease of the cost by these
  /// steps.
  [[nodiscard]] double point_step_square() const { return point_step_square_; }

  /// Newton step of the corrections, -S^-1 g; once factored.
  [[nodiscard]] Eigen::VectorXd Step() const;
  /// Length of the whole Newton step in sigmas, sqrt(g' H^-1 g) over all unknowns.
  [[nodiscard]] double NewtonDecrement() const;
  /// The same where Step() is known.
  [[nodiscard]] double NewtonDecrement(const Eigen::VectorXd& step) const;

  [[nodiscard]] CorrectionCovariance SelectedInverse() const;
  [[nodiscard]] const BorderedPoints& bordered() const { return bordered_; }
  /// Memory and work with so many threads; analyses the pattern.
  [[nodiscard]] SystemNeeds Needs(int threads);
  [[nodiscard]] int rows() const { return pattern_->rows(); }
  /// How the sum over points is cut.
  [[nodiscard]] const PointPieces& pieces() const { return pieces_; }
  /// S^-1 B, any number of columns.
  [[nodiscard]] Eigen::MatrixXd SolveFor(const Eigen::Ref<const Eigen::MatrixXd>& b) const;
  /// Every B becomes S^-1 B: side by side, or one after the other where ranks (core/ranks.h) have
  /// divided the factor. Not from within a loop.
  void SolveEach(std::span<Eigen::MatrixXd> sets) const;

 private:
  /// The sums over points; `exact`: by Q2 for any number of looks. True if a point was added
  /// as a difference.
  bool Sum(const BlockState& state, const Weighting& weighting, bool exact);
  /// Copies the points that other ranks moved into the state of this one.
  void ShareMoved(const std::vector<std::uint32_t>& moved) const;
  [[nodiscard]] bool PointsTakeNearlyAll() const;
  void AddPriors(const BlockState& state);
  /// Adds the equation of the process for parameter `row` of `block`.
  void AddStep(const BlockState& state, int block, int row);
  [[nodiscard]] BorderedMatrix Scaled();
  /// The symbolic analysis, once.
  void Analyse();

  const AdjustmentProblem& problem_;
  BorderedPoints bordered_;
  PointPieces pieces_;
  std::shared_ptr<const BlockPattern> pattern_;
  std::shared_ptr<const BorderPattern> border_pattern_;
  BorderedMatrix s_;               // on the pattern from the first Form on
  Eigen::VectorXd right_side_;     // reduced gradient Q2-part, priors included
  Eigen::VectorXd full_diagonal_;  // of S0: before elimination
  Eigen::VectorXd full_gradient_;  // before elimination
  Eigen::VectorXd scale_;          // 1 / sqrt(S_ii)
  std::optional<BorderedCholesky> factor_;
  std::size_t bytes_of_factors_ = 0;  // of all points
  std::size_t kept_bytes_ = 0;        // 0: none
  std::optional<KeptFactors> kept_;
  std::vector<WeakPoint> weak_points_;
  BlockState* following_ = nullptr;  // while it is formed
  double settle_below_ = 0.0;
  bool exact_ = false;  // undamped sums by Q2: differences were found to lose digits
  double damping_ = 0.0;
  double cost_ = 0.0;
  double gradient_ = 0.0;
  double point_step_square_ = 0.0;
  int looks_not_evaluated_ = 0;
  std::size_t first_not_evaluated_ = PointTotals::kNoPoint;
  int looks_beyond_path_ = 0;
  double weight_change_ = 0.0;
};

}  // namespace sarblock
