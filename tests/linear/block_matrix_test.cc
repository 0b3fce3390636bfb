// SPDX-License-Identifier: Apache-2.0
#include "linear/block_matrix.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

BlockSymmetricMatrix Mixed() {  // sizes 2, 1, 3; pairs given twice, upside down and out of order
  return {{2, 1, 3}, {{2, 0}, {0, 2}, {1, 1}, {0, 1}}};
}

TEST(BlockMatrixTest, HoldsTheDiagonalAndEachPairOnce) {  // hand count
  const BlockSymmetricMatrix matrix = Mixed();
  EXPECT_EQ(matrix.rows(), 6);
  EXPECT_EQ(matrix.offset(2), 3);
  EXPECT_EQ(matrix.values().size(), 4u + 2u + 6u + 1u + 9u);
  const auto rows = matrix.RowsOfColumn(0);
  EXPECT_EQ(std::vector<int>(rows.begin(), rows.end()), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(matrix.Contains(2, 2));
  EXPECT_FALSE(matrix.Contains(2, 1));
  EXPECT_FALSE(matrix.Contains(0, 2)) << "only the lower triangle is stored";
  EXPECT_FALSE(matrix.Contains(3, 0));
}

TEST(BlockMatrixTest, DenseFormMirrorsTheLowerTriangle) {  // hand value
  BlockSymmetricMatrix matrix = Mixed();
  matrix.Block(0, 0) << 4.25, 99.0, 0.5, 3.125;  // the 99 lies above the diagonal
  matrix.Block(1, 0) << 1.5, -2.75;
  matrix.Block(2, 0) << 1, 2, 3, 4, 5, 6;
  const MatrixXd dense = matrix.ToDense();
  EXPECT_EQ(dense(0, 1), 0.5);
  EXPECT_EQ(dense(1, 0), 0.5);
  EXPECT_EQ(dense(2, 1), -2.75);
  EXPECT_EQ(dense(1, 2), -2.75);
  EXPECT_EQ(dense(5, 0), 5.0);
  EXPECT_EQ(dense(1, 4), 4.0);
  EXPECT_EQ(dense(3, 2), 0.0);
  matrix.SetZero();
  EXPECT_EQ(matrix.ToDense().norm(), 0.0);
}

TEST(BlockMatrixTest, MultiplyEqualsTheDenseProduct) {  // second route
  BlockSymmetricMatrix matrix = Mixed();
  std::mt19937_64 engine(71);
  std::normal_distribution<double> normal;
  for (double& value : matrix.values()) {
    value = normal(engine);
  }
  const VectorXd x = VectorXd::LinSpaced(6, -1.3, 2.9);
  // Sums of six products of order one: a few 1e-16.
  EXPECT_LE((matrix.Multiply(x) - matrix.ToDense() * x).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(BlockMatrixTest, FindsTheSameBlocksWithAndWithoutTheTable) {  // second route: search in rows
  std::mt19937_64 engine(5);
  for (const int count : {BlockPattern::kTableLimit, BlockPattern::kTableLimit + 1}) {
    std::vector<std::pair<int, int>> pairs;
    for (int k = 0; k < 4 * count; ++k) {
      pairs.emplace_back(static_cast<int>(engine() % static_cast<unsigned>(count)),
                         static_cast<int>(engine() % static_cast<unsigned>(count)));
    }
    const BlockPattern pattern(std::vector<int>(static_cast<std::size_t>(count), 1), pairs);
    int fixed = 0;
    for (int k = 0; k < 100000; ++k) {
      const int a = static_cast<int>(engine() % static_cast<unsigned>(count));
      const int j = k % 3 == 0 ? a : pairs[static_cast<std::size_t>(k % (4 * count))].first;
      const int i = k % 2 == 0 ? a : pairs[static_cast<std::size_t>(k % (4 * count))].second;
      const auto rows = pattern.RowsOfColumn(j);
      const auto place = std::find(rows.begin(), rows.end(), i);
      const std::size_t slot = pattern.Find(i, j);
      if (place == rows.end()) {
        ASSERT_EQ(slot, BlockPattern::kAbsent);
      } else {
        ASSERT_EQ(slot, pattern.FirstSlot(j) + static_cast<std::size_t>(place - rows.begin()));
        ++fixed;
      }
    }
    EXPECT_GT(fixed, 10000);
    std::vector<std::pair<int, int>> all;  // of blocks two apart
    for (int i = 1; i < count; i += 2) {
      for (int j = std::max(1, i - 8); j < i; j += 2) all.emplace_back(i, j);
    }
    const BlockPattern band(std::vector<int>(static_cast<std::size_t>(count), 2), all);
    const std::array<int, 5> five{1, 3, 5, 7, 9};
    std::array<std::size_t, 15> found{};
    band.SlotsOfPairs(five, found.data());
    for (std::size_t i = 0, k = 0; i < five.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j, ++k) {
        ASSERT_EQ(found[k], band.Slot(five[i], five[j]));
      }
    }
    for (int j = 0; j < count; ++j) {  // what stands below a column, two at a time
      for (const int i : pattern.RowsOfColumn(j)) {
        if (i == j) continue;
        const std::array<int, 2> blocks{j, i};
        std::array<std::size_t, 3> slots{};
        pattern.SlotsOfPairs(blocks, slots.data());
        ASSERT_EQ(slots[0], pattern.Slot(j, j));
        ASSERT_EQ(slots[1], pattern.Slot(i, j));
        ASSERT_EQ(slots[2], pattern.Slot(i, i));
      }
    }
  }
}

TEST(BlockMatrixTest, CopiesShareThePatternAndNotTheValues) {
  const BlockSymmetricMatrix one = Mixed();
  BlockSymmetricMatrix two = one;
  two.Block(1, 1)(0, 0) = 7.5;
  EXPECT_EQ(one.Block(1, 1)(0, 0), 0.0);
  EXPECT_EQ(one.pattern(), two.pattern());
  EXPECT_EQ(BlockSymmetricMatrix().rows(), 0);
}

TEST(BlockMatrixDeathTest, StopsAtABlockOutsideThePattern) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  BlockSymmetricMatrix matrix = Mixed();
  EXPECT_DEATH((void)matrix.Block(2, 1), "block \\(2, 1\\) is not in the pattern");
  EXPECT_DEATH(BlockSymmetricMatrix({1, 1}, {{0, 2}}), "0, 2");
}

}  // namespace
}  // namespace sarblock
