// SPDX-License-Identifier: Apache-2.0
#include "block_matrix.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <glog/logging.h>

namespace sarblock {

BlockPattern::BlockPattern(std::vector<int> sizes, const std::vector<std::pair<int, int>>& pairs)
    : sizes_(std::move(sizes)) {
  const std::size_t count = sizes_.size();
  offsets_.resize(count + 1);
  for (std::size_t b = 0; b < count; ++b) {
    CHECK_GE(sizes_[b], 0) << "block " << b;
    offsets_[b + 1] = offsets_[b] + sizes_[b];
  }
  // Rows bucketed by column first, so that only short lists are sorted.
  std::vector<std::size_t> begin(count + 1, 0);
  for (const auto& [a, b] : pairs) {
    CHECK(a >= 0 && b >= 0 && a < block_count() && b < block_count()) << a << ", " << b;
    ++begin[static_cast<std::size_t>(std::min(a, b)) + 1];
  }
  for (std::size_t j = 0; j < count; ++j) {
    begin[j + 1] += begin[j] + 1;  // the diagonal
  }
  std::vector<int> bucket(begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t j = 0; j < count; ++j) {
    bucket[next[j]++] = static_cast<int>(j);
  }
  for (const auto& [a, b] : pairs) {
    bucket[next[static_cast<std::size_t>(std::min(a, b))]++] = std::max(a, b);
  }
  column_begin_.assign(count + 1, 0);
  for (std::size_t j = 0; j < count; ++j) {
    const auto first = bucket.begin() + static_cast<std::ptrdiff_t>(begin[j]);
    const auto end = bucket.begin() + static_cast<std::ptrdiff_t>(begin[j + 1]);
    std::sort(first, end);
    rows_.insert(rows_.end(), first, std::unique(first, end));
    column_begin_[j + 1] = rows_.size();
  }
  value_begin_.resize(rows_.size() + 1);
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t slot = column_begin_[j]; slot < column_begin_[j + 1]; ++slot) {
      value_begin_[slot + 1] = value_begin_[slot] + static_cast<std::size_t>(size(rows_[slot])) *
                                                        static_cast<std::size_t>(sizes_[j]);
    }
  }
  if (block_count() <= kTableLimit) {
    table_.assign(count * (count + 1) / 2, -1);
    for (int j = 0; j < block_count(); ++j) {
      std::size_t slot = FirstSlot(j);
      for (const int i : RowsOfColumn(j)) {
        table_[TableIndex(i, j)] = static_cast<std::int32_t>(slot++);
      }
    }
  }
}

std::span<const int> BlockPattern::RowsOfColumn(int column) const {
  const auto j = static_cast<std::size_t>(column);
  return std::span(rows_).subspan(column_begin_[j], column_begin_[j + 1] - column_begin_[j]);
}

std::size_t BlockPattern::Search(int i, int j) const {
  const std::span<const int> rows = RowsOfColumn(j);
  const auto found = std::lower_bound(rows.begin(), rows.end(), i);
  if (found == rows.end() || *found != i) {
    return kAbsent;
  }
  return FirstSlot(j) + static_cast<std::size_t>(found - rows.begin());
}

void BlockPattern::SlotsOfPairs(std::span<const int> blocks, std::size_t* out) const {
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    if (table_.empty()) {
      for (std::size_t i = j; i < blocks.size(); ++i) {
        out[i * (i + 1) / 2 + j] = Slot(blocks[i], blocks[j]);
      }
      continue;
    }
    const std::int32_t* slots = table_.data() + TableIndex(0, blocks[j]);
    std::size_t at = j * (j + 1) / 2 + j;
    for (std::size_t i = j; i < blocks.size(); at += ++i) {
      const std::int32_t slot = slots[blocks[i]];
      if (slot < 0) FailMissing(blocks[i], blocks[j]);
      out[at] = static_cast<std::size_t>(slot);
    }
  }
}

void BlockPattern::FailMissing(int i, int j) {
  LOG(FATAL) << "block (" << i << ", " << j << ") is not in the pattern";
}

BlockSymmetricMatrix::BlockSymmetricMatrix()
    : BlockSymmetricMatrix(std::make_shared<const BlockPattern>()) {}

BlockSymmetricMatrix::BlockSymmetricMatrix(std::vector<int> sizes,
                                           std::vector<std::pair<int, int>> pairs)
    : BlockSymmetricMatrix(std::make_shared<const BlockPattern>(std::move(sizes), pairs)) {}

BlockSymmetricMatrix::BlockSymmetricMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)), values_(pattern_->ValueBegin(pattern_->slot_count()), 0.0) {}

void BlockSymmetricMatrix::SetZero() { std::fill(values_.begin(), values_.end(), 0.0); }

Eigen::MatrixXd BlockSymmetricMatrix::ToDense() const {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows(), rows());
  for (int j = 0; j < block_count(); ++j) {
    for (const int i : RowsOfColumn(j)) {
      dense.block(offset(i), offset(j), size(i), size(j)) = Block(i, j);
    }
  }
  dense.triangularView<Eigen::StrictlyUpper>() = dense.transpose();
  return dense;
}

Eigen::MatrixXd BlockSymmetricMatrix::Multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  CHECK_EQ(x.rows(), rows());
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(rows(), x.cols());
  for (int j = 0; j < block_count(); ++j) {
    for (const int i : RowsOfColumn(j)) {
      const Eigen::Map<const Eigen::MatrixXd> block = Block(i, j);
      if (i == j) {
        y.middleRows(offset(j), size(j)) +=
            block.selfadjointView<Eigen::Lower>() * x.middleRows(offset(j), size(j));
      } else {
        y.middleRows(offset(i), size(i)).noalias() += block * x.middleRows(offset(j), size(j));
        y.middleRows(offset(j), size(j)).noalias() +=
            block.transpose() * x.middleRows(offset(i), size(i));
      }
    }
  }
  return y;
}

namespace {

std::size_t AsPlace(int i) { return static_cast<std::size_t>(i); }

/// Representative of a block, the paths to it halved (Tarjan 1975).
int RootOf(int block, std::vector<int>* parent) {
  std::vector<int>& p = *parent;
  while (p[AsPlace(block)] != block) {
    p[AsPlace(block)] = p[AsPlace(p[AsPlace(block)])];
    block = p[AsPlace(block)];
  }
  return block;
}

/// The first block of each block's connected component.
std::vector<int> ComponentsOf(const BlockPattern& matrix) {
  std::vector<int> parent(AsPlace(matrix.block_count()));
  std::iota(parent.begin(), parent.end(), 0);
  for (int j = 0; j < matrix.block_count(); ++j) {
    for (const int i : matrix.RowsOfColumn(j)) {
      const int a = RootOf(i, &parent), b = RootOf(j, &parent);
      parent[AsPlace(std::max(a, b))] = std::min(a, b);
    }
  }
  for (int j = 0; j < matrix.block_count(); ++j) parent[AsPlace(j)] = RootOf(j, &parent);
  return parent;
}

}  // namespace

BorderPattern::BorderPattern(const BlockPattern& matrix,
                             int terms,
                             const std::vector<std::pair<int, int>>& places)
    : terms_(terms),
      columns_(matrix.rows()),
      group_of_(AsPlace(columns_), -1),
      place_of_(AsPlace(columns_), 0) {
  if (terms == 0) return;
  const std::vector<int> component = ComponentsOf(matrix);
  std::vector<int> group_of_component(component.size(), -1);
  for (const auto& [term, block] : places) {
    int& group = group_of_component[AsPlace(component[AsPlace(block)])];
    if (group < 0) {
      group = static_cast<int>(groups_.size());
      groups_.emplace_back();
    }
    groups_[AsPlace(group)].terms.push_back(term);
  }
  for (Group& group : groups_) {
    std::sort(group.terms.begin(), group.terms.end());
    group.terms.erase(std::unique(group.terms.begin(), group.terms.end()), group.terms.end());
  }
  for (int block = 0; block < matrix.block_count(); ++block) {
    const int group = group_of_component[AsPlace(component[AsPlace(block)])];
    if (group < 0) continue;
    std::vector<int>& columns = groups_[AsPlace(group)].columns;
    for (int i = 0; i < matrix.size(block); ++i) {
      const std::size_t column = AsPlace(matrix.offset(block) + i);
      group_of_[column] = group;
      place_of_[column] = static_cast<int>(columns.size());
      columns.push_back(matrix.offset(block) + i);
    }
  }
  Finish();
}

BorderPattern::BorderPattern(int terms, int columns)
    : terms_(terms),
      columns_(columns),
      group_of_(AsPlace(columns), terms > 0 ? 0 : -1),
      place_of_(AsPlace(columns), 0) {
  std::iota(place_of_.begin(), place_of_.end(), 0);
  if (terms > 0) {
    Group& all = groups_.emplace_back();
    all.terms.resize(AsPlace(terms));
    std::iota(all.terms.begin(), all.terms.end(), 0);
    all.columns = place_of_;
  }
  Finish();
}

void BorderPattern::Finish() {
  groups_of_.resize(AsPlace(terms_));
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    group.begin = value_count_;
    value_count_ += group.terms.size() * group.columns.size();
    for (const int term : group.terms) groups_of_[AsPlace(term)].push_back(static_cast<int>(g));
  }
}

int BorderPattern::MaxTerms() const {
  std::size_t most = 0;
  for (const Group& group : groups_) most = std::max(most, group.terms.size());
  return static_cast<int>(most);
}

double BorderPattern::SquareOperations() const {
  double sum = 0.0;
  for (const Group& group : groups_) {
    const auto terms = static_cast<double>(group.terms.size());
    sum += terms * terms * static_cast<double>(group.columns.size());
  }
  return sum;
}

Border::Border(std::shared_ptr<const BorderPattern> pattern)
    : pattern_(std::move(pattern)), values_(pattern_->value_count(), 0.0) {}

Border::Border(const Eigen::MatrixXd& dense)
    : Border(std::make_shared<const BorderPattern>(static_cast<int>(dense.rows()),
                                                   static_cast<int>(dense.cols()))) {
  std::copy_n(dense.data(), values_.size(), values_.begin());
}

double* Border::At(int term, int column) {
  const int g = pattern_->GroupOf(column);
  CHECK_GE(g, 0) << "the border has no value in column " << column;
  const BorderPattern::Group& group = pattern_->groups()[AsPlace(g)];
  const auto at = std::lower_bound(group.terms.begin(), group.terms.end(), term);
  CHECK(at != group.terms.end() && *at == term)
      << "the border has no value of term " << term << " in column " << column;
  return values_.data() + group.begin + AsPlace(pattern_->PlaceOf(column)) * group.terms.size() +
         static_cast<std::size_t>(at - group.terms.begin());
}

Eigen::MatrixXd Border::Rows(int first, int count) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(count, columns());
  for (const BorderPattern::Group& group : pattern_->groups()) {
    const ConstPart part = Of(group);
    const auto begin = std::lower_bound(group.terms.begin(), group.terms.end(), first);
    for (auto at = begin; at != group.terms.end() && *at < first + count; ++at) {
      for (std::size_t c = 0; c < group.columns.size(); ++c) {
        out(*at - first, group.columns[c]) =
            part(at - group.terms.begin(), static_cast<Eigen::Index>(c));
      }
    }
  }
  return out;
}

// Plain loops: of the few values of a group, what Eigen sets up for indexed rows takes twice as
// long as the sums.
Eigen::MatrixXd Border::Times(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(terms(), x.cols());
  Eigen::MatrixXd sums(pattern_->MaxTerms(), x.cols());
  for (const BorderPattern::Group& group : pattern_->groups()) {
    auto of_group = sums.topRows(Count(group.terms));
    of_group.setZero();
    const ConstPart part = Of(group);
    for (Eigen::Index j = 0; j < part.cols(); ++j) {
      const int row = group.columns[static_cast<std::size_t>(j)];
      for (Eigen::Index c = 0; c < x.cols(); ++c) of_group.col(c) += part.col(j) * x(row, c);
    }
    for (Eigen::Index c = 0; c < x.cols(); ++c) {
      for (Eigen::Index i = 0; i < part.rows(); ++i) {
        out(group.terms[static_cast<std::size_t>(i)], c) += of_group(i, c);
      }
    }
  }
  return out;
}

void Border::AddTransposedTimes(const Eigen::MatrixXd& y, Eigen::Ref<Eigen::MatrixXd> x) const {
  Eigen::MatrixXd terms_of(pattern_->MaxTerms(), y.cols());
  for (const BorderPattern::Group& group : pattern_->groups()) {
    const ConstPart part = Of(group);
    for (Eigen::Index c = 0; c < y.cols(); ++c) {
      for (Eigen::Index i = 0; i < part.rows(); ++i) {
        terms_of(i, c) = y(group.terms[static_cast<std::size_t>(i)], c);
      }
    }
    const auto of_group = terms_of.topRows(part.rows());
    for (Eigen::Index j = 0; j < part.cols(); ++j) {
      const int row = group.columns[static_cast<std::size_t>(j)];
      for (Eigen::Index c = 0; c < y.cols(); ++c) x(row, c) += part.col(j).dot(of_group.col(c));
    }
  }
}

Eigen::VectorXd Border::ColumnSquares() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(columns());
  for (const BorderPattern::Group& group : pattern_->groups()) {
    out(group.columns) = Of(group).colwise().squaredNorm().transpose();
  }
  return out;
}

Border Border::Scaled(const Eigen::VectorXd& d) const {
  Border out(pattern_);
  for (const BorderPattern::Group& group : pattern_->groups()) {
    out.Of(group) = Of(group) * d(group.columns).asDiagonal();
  }
  return out;
}

}  // namespace sarblock
