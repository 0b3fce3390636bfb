// SPDX-License-Identifier: Apache-2.0
#include "border.h"

#include <algorithm>
#include <numeric>

#include <glog/logging.h>

namespace sarblock {
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
