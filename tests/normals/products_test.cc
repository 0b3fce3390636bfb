// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <numeric>
#include <vector>

#include "normals/kernels.h"
#include <Eigen/Core>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<const ProductKernels*> AllKernels() {
  std::vector<const ProductKernels*> all{&BaselineKernels()};
  if (&KernelsOfThisMachine() != all[0]) all.push_back(&KernelsOfThisMachine());
  return all;
}

Eigen::MatrixXd Random(Eigen::Index rows, Eigen::Index columns, RandomStream* random) {
  Eigen::MatrixXd out(rows, columns);
  for (double& x : out.reshaped()) x = 2.0 * random->Uniform() - 1.0;
  return out;
}

/// Blocks of every size from 1 to 17 and of 24, with a symmetric matrix over them.
class ProductKernelsTest : public testing::Test {
 protected:
  ProductKernelsTest() {
    for (int size = 1; size <= 17; ++size) size_.push_back(size);
    size_.push_back(24);
    for (const int size : size_) {
      begin_.push_back(width_);
      width_ += size;
    }
    std::size_t values = 0;
    for (std::size_t i = 0; i < size_.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        value_.push_back(values);
        values += static_cast<std::size_t>(size_[i] * size_[j]);
      }
    }
    blocks_ = {static_cast<int>(size_.size()), begin_.data(), size_.data(), value_.data()};
    matrix_ = Random(width_, width_, &random_);
    matrix_ = (matrix_ + matrix_.transpose()).eval();
    lower_.resize(values);
    ForBlocks([this](std::size_t at, auto rows, auto columns, auto i, auto j) {
      Eigen::Map<Eigen::MatrixXd>(&lower_[at], rows, columns) = matrix_.block(i, j, rows, columns);
    });
  }
  template <typename F>
  void ForBlocks(F&& f) const {
    std::size_t k = 0;
    for (std::size_t i = 0; i < size_.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) f(value_[k++], size_[i], size_[j], begin_[i], begin_[j]);
    }
  }
  RandomStream random_{1979, 3};
  std::vector<int> size_, begin_;
  int width_ = 0;
  std::vector<std::size_t> value_;
  PointBlocks blocks_;
  Eigen::MatrixXd matrix_;
  std::vector<double> lower_;  // its blocks
};

// Second route: Eigen's products of whole matrices.
TEST_F(ProductKernelsTest, SquaresAreThoseOfWholeMatrices) {
  const Eigen::Index stride = width_ + 3;
  for (const ProductKernels* kernels : AllKernels()) {
    for (int terms = 1; terms <= 7; ++terms) {
      const RowMajor x = Random(terms, stride, &random_);
      std::vector<double> values = lower_;
      kernels->AddSquare(
          blocks_, x.data(), static_cast<std::size_t>(stride), terms, -1.0, values.data());
      const Eigen::MatrixXd expected =
          matrix_ - x.leftCols(width_).transpose() * x.leftCols(width_);
      ForBlocks([&](std::size_t at, auto rows, auto columns, auto i, auto j) {
        const Eigen::Map<Eigen::MatrixXd> block(&values[at], rows, columns);
        EXPECT_LE((block - expected.block(i, j, rows, columns)).norm(), 1e-13) << rows << columns;
      });
    }
  }
}

TEST_F(ProductKernelsTest, ProductsWithTheMatrixAreThoseOfWholeMatrices) {
  const Eigen::Index stride = width_ + 3;
  const RowMajor t = Random(3, stride, &random_);
  const RowMajor expected = t.leftCols(width_) * matrix_;
  for (const ProductKernels* kernels : AllKernels()) {
    RowMajor y = RowMajor::Zero(3, stride);
    kernels->AddProductWithMatrix(
        blocks_, t.data(), static_cast<std::size_t>(stride), lower_.data(), y.data());
    EXPECT_LE((y.leftCols(width_) - expected).norm(), 1e-12 * expected.norm());
    Eigen::Matrix3d form = Eigen::Matrix3d::Identity();
    kernels->AddQuadraticForm(
        blocks_, t.data(), static_cast<std::size_t>(stride), lower_.data(), form.data());
    const Eigen::Matrix3d whole =
        Eigen::Matrix3d::Identity() + expected * t.leftCols(width_).transpose();
    EXPECT_LE((form - whole).norm(), 1e-13 * whole.norm());
  }
}

TEST_F(ProductKernelsTest, RowsOfALookTurnAsWholeMatricesDo) {
  for (const ProductKernels* kernels : AllKernels()) {
    for (const int columns : size_) {
      const RowMajor rows = Random(2, columns, &random_);
      const Eigen::MatrixXd basis = Random(9, 5, &random_);
      RowMajor out = Random(5, columns + 2, &random_);
      const RowMajor expected = out.leftCols(columns) + basis.topRows(2).transpose() * rows;
      kernels->AddTurned(out.data(),
                         static_cast<std::size_t>(columns) + 2,
                         5,
                         basis.data(),
                         9,
                         rows.row(0).data(),
                         rows.row(1).data(),
                         columns);
      EXPECT_LE((out.leftCols(columns) - expected).norm(), 1e-14 * columns);
      Eigen::MatrixXd products = Eigen::MatrixXd::Zero(columns, 4);
      const RowMajor other = Random(3, columns + 4, &random_),
                     own = Random(3, columns + 4, &random_);
      kernels->AddProducts(products.data(),
                           columns,
                           4,
                           own.data(),
                           other.data(),
                           static_cast<std::size_t>(columns) + 4,
                           3);
      Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(columns, 0.31), gradient = diagonal;
      const Eigen::Vector2d whitened_error = Random(2, 1, &random_);
      kernels->AddLook(columns,
                       rows.row(0).data(),
                       rows.row(1).data(),
                       whitened_error.data(),
                       diagonal.data(),
                       gradient.data());
      const Eigen::VectorXd squares = rows.colwise().squaredNorm();
      EXPECT_LE((diagonal.array() - 0.31 - squares.array()).matrix().norm(), 1e-14 * columns);
      EXPECT_LE(
          (gradient.array() - 0.31 - (rows.transpose() * whitened_error).array()).matrix().norm(),
          1e-14 * columns);
      Eigen::VectorXd sum = Eigen::VectorXd::Constant(columns, 0.47);
      const Eigen::Vector3d factor = Random(3, 1, &random_);
      kernels->AddCombination(
          columns, own.data(), static_cast<std::size_t>(columns) + 4, 3, factor.data(), sum.data());
      const Eigen::VectorXd combined = own.leftCols(columns).transpose() * factor;
      EXPECT_LE((sum.array() - 0.47 - combined.array()).matrix().norm(), 1e-14 * columns);
      const Eigen::MatrixXd whole = own.leftCols(columns).transpose() * other.leftCols(4);
      EXPECT_LE((products - whole).norm(), 1e-14 * columns);
    }
  }
}

}  // namespace
}  // namespace sarblock
