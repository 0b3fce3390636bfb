// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <vector>

#include "model/parameters.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// Residuals this much smaller than their standard deviations count as exact: the rest of their
/// square sum is rounding.
inline constexpr double kMinVariance = 1e-10;

/// Figures of one candidate: a set of columns added to a model.
struct CandidateFigures {
  int columns = 0;
  double statistic = 0.0;  ///< what the columns take off the square sum
  double f = 0.0;
  double probability = 1.0;
  double delta_bic = 0.0;
  double condition = 0.0;        ///< infinite where the columns are not determined
  double effect_part = 0.0;      ///< Determinacy, where it is what keeps the columns out
  double penalty = 0.0;          ///< of the information criterion
  double posterior_prior = 0.0;  ///< NaN where a column has no prior
  double variance = 0.0;         ///< of a process: most likely prior variance; else 0
  bool regular = false;          ///< determined, and redundancy is left
};

/// 1 / least eigenvalue of a scaled symmetric matrix; infinite where it is not positive definite.
[[nodiscard]] double ConditionOf(const Eigen::MatrixXd& scaled);

/// v'Pv as a quadratic function of all candidate corrections, points eliminated, and stepwise
/// choice among its columns (docs/theory/selection.md, eqs. 1 to 9):
///
///     Omega(x) = constant - 2 b'x + x' S x
///
/// A model is a set of active columns, the others zero. Dense: one matrix of all columns; a step
/// costs columns^2 times the columns added.
class QuadraticModel {
 public:
  struct Data {
    Eigen::MatrixXd s;  ///< symmetric, priors included
    Eigen::VectorXd b;
    double constant = 0.0;
    Eigen::VectorXd full_diagonal;  ///< before points are eliminated
    Eigen::VectorXd prior_weight;   ///< 0: no prior
    Eigen::VectorXd log_count;      ///< log of the number of equations with this column
    double redundancy = 0.0;        ///< without any correction
  };
  explicit QuadraticModel(Data data);

  /// Makes `active` the model. False where its matrix is singular.
  [[nodiscard]] bool Reset(const std::vector<int>& active);
  /// Adds columns that Score() found regular.
  void Add(const std::vector<int>& columns);

  [[nodiscard]] const std::vector<int>& active() const { return active_; }
  [[nodiscard]] double square_sum() const { return omega_; }
  [[nodiscard]] double redundancy() const { return redundancy_; }

  /// ConditionOf() of `columns` as a model, scaled with full_diagonal.
  [[nodiscard]] double Condition(const std::vector<int>& columns) const;
  /// Rao's score test of columns that are not active.
  [[nodiscard]] CandidateFigures Score(const std::vector<int>& columns) const;
  /// Inverse of the matrix of the active columns, in their order.
  [[nodiscard]] Eigen::MatrixXd Covariance() const;
  /// Wald's test of removing active columns. `covariance` is Covariance().
  [[nodiscard]] CandidateFigures Wald(const std::vector<int>& columns,
                                      const Eigen::MatrixXd& covariance) const;
  /// Having `in` against having `out`, the smaller space; one of both is active.
  [[nodiscard]] CandidateFigures Exchange(const std::vector<int>& out,
                                          const std::vector<int>& in) const;
  /// Having columns as a process, with one prior variance that is the most likely one, against
  /// having `out`; either may be active. F is that of the columns without a prior against `below`.
  [[nodiscard]] CandidateFigures Process(const std::vector<int>& in,
                                         const std::vector<int>& out,
                                         const std::vector<int>& below) const;
  /// Most likely prior variances of sets of columns that are not active, each given the others'
  /// and the active columns (docs/theory/selection.md, eq. 8b); NaN where the observations say
  /// nothing of a set.
  [[nodiscard]] std::vector<double> MostLikelyVariances(
      const std::vector<std::vector<int>>& sets) const;
  /// Part of the information of the observations on columns that remains beside the active ones: 0
  /// where these explain all of it, 1 where they explain none.
  [[nodiscard]] double PartLeft(const std::vector<int>& columns) const;
  /// Gives columns a prior of this variance in place of what they have, infinite: none. Reset()
  /// where they are active.
  void SetPrior(const std::vector<int>& columns, double variance);

 private:
  /// The model of `columns` alone, in their order, nothing active.
  [[nodiscard]] QuadraticModel Reduced(const std::vector<int>& columns) const;
  /// Active columns in none of the sets.
  [[nodiscard]] std::vector<int> ActiveBut(
      std::initializer_list<const std::vector<int>*> sets) const;
  /// Tests columns with information `m` and gradient `g`, the others of the model eliminated,
  /// against a model without them.
  [[nodiscard]] CandidateFigures Test(const std::vector<int>& columns,
                                      const Eigen::MatrixXd& m,
                                      const Eigen::VectorXd& g,
                                      double square_without,
                                      double redundancy) const;
  /// Redundancy that columns take.
  [[nodiscard]] double Takes(const std::vector<int>& columns) const;

  Data data_;
  std::vector<int> active_;
  Eigen::MatrixXd s_;  // Schur complement after the active columns
  Eigen::VectorXd b_;
  double omega_ = 0.0;
  double redundancy_ = 0.0;
};

/// v'Pv as a quadratic function of the corrections of a system formed at `corrections`, with the
/// priors that `parameters` say; all but its redundancy.
[[nodiscard]] QuadraticModel::Data DataAt(const ReducedSystem& system,
                                          const Eigen::VectorXd& corrections,
                                          const std::vector<Parameter>& parameters);

}  // namespace sarblock
