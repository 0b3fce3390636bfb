// SPDX-License-Identifier: Apache-2.0
#include "decompositions.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace sarblock::dense {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigenpairs SymmetricEigenpairs(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd SymmetricEigenvalues(const MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Cholesky::Cholesky(const MatrixXd& a) : llt_(a) {}
MatrixXd Cholesky::L() const { return llt_.matrixL(); }
double Cholesky::LogDeterminant() const {
  return 2.0 * llt_.matrixLLT().diagonal().array().log().sum();
}
MatrixXd Cholesky::Solve(const MatrixXd& b) const { return llt_.solve(b); }
VectorXd Cholesky::Solve(const VectorXd& b) const { return llt_.solve(b); }
MatrixXd Cholesky::Inverse() const { return Solve(MatrixXd(MatrixXd::Identity(rows(), rows()))); }
MatrixXd Cholesky::SolveLower(MatrixXd b) const {
  llt_.matrixL().solveInPlace(b);
  return b;
}
VectorXd Cholesky::SolveLower(VectorXd b) const {
  llt_.matrixL().solveInPlace(b);
  return b;
}

PivotedCholesky::PivotedCholesky(const MatrixXd& a) : ldlt_(a) {}
bool PivotedCholesky::PivotsAbove(double least) const {
  return ldlt_.info() == Eigen::Success && ldlt_.vectorD().minCoeff() > least;
}
MatrixXd PivotedCholesky::Solve(const MatrixXd& b) const { return ldlt_.solve(b); }
VectorXd PivotedCholesky::Solve(const VectorXd& b) const { return ldlt_.solve(b); }

Orthogonal::Orthogonal(const MatrixXd& a) : qr_(a) {}
MatrixXd Orthogonal::Q(Index columns) const {
  return qr_.householderQ() * MatrixXd::Identity(qr_.rows(), columns);
}
MatrixXd Orthogonal::R() const {
  return qr_.matrixQR().topRows(std::min(qr_.rows(), qr_.cols())).triangularView<Eigen::Upper>();
}

PivotedOrthogonal::PivotedOrthogonal(const MatrixXd& a) : qr_(a) {}
PivotedOrthogonal::PivotedOrthogonal(const MatrixXd& a, double threshold) : qr_(a) {
  qr_.setThreshold(threshold);
}
MatrixXd PivotedOrthogonal::Basis() const {
  return qr_.householderQ() * MatrixXd::Identity(qr_.rows(), qr_.rank());
}
MatrixXd PivotedOrthogonal::Solve(const MatrixXd& b) const { return qr_.solve(b); }

SingularValues DecomposeSingular(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

}  // namespace sarblock::dense
