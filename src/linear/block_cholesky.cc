// SPDX-License-Identifier: Apache-2.0
#include "block_cholesky.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/ranks.h"
#include "core/threads.h"
#include "dense.h"
#include "front_ranks.h"
#include "fronts.h"
#include "symbolic.h"
#include <dlfcn.h>
#include <glog/logging.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using sparse::FrontMemory;
using sparse::OwnFronts;
using sparse::Symbolic;

/// Takes the memory of OpenBLAS for so many threads that call it, where the addresses of this
/// process are limited (ulimit -v): 128 MiB each, which it would ask for without end where they are
/// refused. Throws InputError where there is not as much. Nothing without a limit.
void TakeBlasMemory(int threads) {
  constexpr std::size_t kBytes = (std::size_t{128} << 20) + (std::size_t{1} << 16);  // of a buffer
  static std::mutex mutex;
  static int taken = 0;
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  void* const allocate = dlsym(RTLD_DEFAULT, "blas_memory_alloc");
  void* const release = dlsym(RTLD_DEFAULT, "blas_memory_free");
  if (allocate == nullptr || release == nullptr) return;
  const std::lock_guard lock(mutex);
  if (threads <= taken) return;
  const std::size_t missing = kBytes * static_cast<std::size_t>(threads - taken);
  void* const room =
      ::mmap(nullptr, missing, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) {
    throw InputError("ulimit -v",
                     "leaves this process no " + std::to_string(missing >> 20U) +
                         " MiB of addresses, which BLAS takes for " + std::to_string(threads) +
                         (threads == 1 ? " thread" : " threads") +
                         "; a higher limit is needed, or fewer --threads");
  }
  ::munmap(room, missing);
  std::vector<void*> buffers;
  for (int i = 0; i < threads; ++i) {
    buffers.push_back(reinterpret_cast<void* (*)(int)>(allocate)(0));
  }
  for (void* const buffer : buffers) reinterpret_cast<void (*)(void*)>(release)(buffer);
  taken = threads;
}

OwnFronts Divide(Symbolic symbolic, double divided_operations) {
  const Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr || symbolic.operations < divided_operations) {
    sparse::FrontDivision alone = sparse::DivideFronts(symbolic.fronts, 1);
    return {std::move(symbolic), std::move(alone), 0};
  }
  sparse::FrontDivision division = sparse::DivideFronts(symbolic.fronts, ranks->size());
  return {std::move(symbolic), std::move(division), ranks->rank()};
}

MatrixXd Permuted(const Symbolic& symbolic, const Eigen::Ref<const MatrixXd>& b) {
  CHECK_EQ(b.rows(), static_cast<Eigen::Index>(symbolic.original_row.size()));
  MatrixXd x(b.rows(), b.cols());
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < b.rows(); ++r) {
      x(r, c) = b(symbolic.original_row[static_cast<std::size_t>(r)], c);
    }
  }
  return x;
}

}  // namespace

struct BlockCholesky::Impl {
  std::shared_ptr<const BlockPattern> pattern;
  OwnFronts own;
  std::unique_ptr<FrontMemory> factor_memory;
  FrontMemory::Place factor;  ///< the own fronts' panels, column-major, lower part valid
  bool factored = false;
  FactorNeeds used;

  /// CHECKs that the last Factorize succeeded.
  void RequireFactor() const;
};

void BlockCholesky::Impl::RequireFactor() const {
  CHECK(factored) << "the matrix has not been factored";
}

BlockCholesky::BlockCholesky(std::shared_ptr<const BlockPattern> pattern,
                             std::span<const int> last,
                             double divided_operations)
    : impl_(std::make_unique<Impl>()) {
  TakeBlasMemory(ThreadsAllowed());
  dense::UseOneBlasThread();
  impl_->pattern = std::move(pattern);
  impl_->own = Divide(sparse::Analyse(*impl_->pattern, last), divided_operations);
}

BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

BlockCholesky::Outcome BlockCholesky::Factorize(const BlockSymmetricMatrix& matrix) {
  Impl& impl = *impl_;
  CHECK(matrix.pattern() == impl.pattern || *matrix.pattern() == *impl.pattern)
      << "the matrix has another pattern than the one analysed";
  impl.factored = false;
  if (!impl.factor) {
    impl.factor_memory =
        std::make_unique<FrontMemory>(FrontMemory::Rounded(impl.own.panel_entries));
    impl.factor = impl.factor_memory->Take(impl.own.panel_entries);
  }
  sparse::FrontFactorisation factorisation(impl.own, matrix.values(), impl.factor.get());
  const Outcome outcome = factorisation.Run();
  impl.used.factor = impl.own.panel_entries;
  impl.used.waiting = std::max(impl.used.waiting, factorisation.most_waiting());
  impl.factored = outcome.positive_definite;
  return outcome;
}

void BlockCholesky::Solve(Eigen::Ref<MatrixXd> b) const {
  impl_->RequireFactor();
  const Symbolic& symbolic = impl_->own.symbolic;
  MatrixXd x = Permuted(symbolic, b);
  sparse::SolveFronts(impl_->own, impl_->factor.get(), &x);
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < b.rows(); ++r) {
      b(symbolic.original_row[static_cast<std::size_t>(r)], c) = x(r, c);
    }
  }
}

BlockSymmetricMatrix BlockCholesky::SelectedInverse() const {
  impl_->RequireFactor();
  BlockSymmetricMatrix inverse(impl_->pattern);
  const std::size_t taken = sparse::InvertFronts(impl_->own, impl_->factor.get(), inverse.values());
  impl_->used.inverse_fronts = std::max(impl_->used.inverse_fronts, taken);
  return inverse;
}

bool BlockCholesky::divided() const { return impl_->own.divided(); }

std::size_t BlockCholesky::factor_entries() const { return impl_->own.symbolic.factor_entries; }

FactorNeeds BlockCholesky::Needs() const {
  const OwnFronts& own = impl_->own;
  FactorNeeds largest;
  for (const FactorNeeds& needs : sparse::NeedsOfRanks(own.symbolic.fronts, own.division)) {
    if (sparse::MaxDoubles(needs) >= sparse::MaxDoubles(largest)) largest = needs;
  }
  largest.operations = 0.5 * own.symbolic.operations;
  largest.dissected = own.symbolic.dissected;
  return largest;
}

FactorNeeds BlockCholesky::Used() const { return impl_->used; }

}  // namespace sarblock

namespace sarblock::sparse {
namespace {

using Eigen::MatrixXd;

int RowCount(const MatrixXd& x) { return static_cast<int>(x.rows()); }
int ColumnCount(const MatrixXd& x) { return static_cast<int>(x.cols()); }

/// Calls visit(row of R, row of the parent's front, rows) for the rows of R of a front that its
/// parent eliminates, or for the others.
enum class Part { kEliminated, kRemaining };
template <typename Visit>
void ForRuns(const Front& front, const Front& parent, Part part, const Visit& visit) {
  for (const Run& run : front.runs) {
    const int split = std::clamp(parent.eliminated - run.parent_begin, 0, run.length);
    const int begin = part == Part::kEliminated ? 0 : split;
    const int end = part == Part::kEliminated ? split : run.length;
    if (begin < end) visit(run.begin + begin, run.parent_begin + begin, end - begin);
  }
}

/// x = L^-1 x. What a front subtracts from rows further up is summed along the tree, so that only
/// sums cross from rank to rank.
class Forward {
 public:
  Forward(const OwnFronts& own, const double* factor, MatrixXd* x)
      : own_(own), fronts_(own.symbolic.fronts), factor_(factor), x_(*x), sums_(fronts_.size()) {}

  void Run(Ranks* ranks) {
    for (int stage = 0; stage < own_.division.stages; ++stage) {
      for (const std::size_t f : own_.stages[At(stage)]) Work(f);
      if (ranks != nullptr && stage + 1 < own_.division.stages) MoveUp(stage, ranks);
    }
  }

 private:
  void Work(std::size_t f) {
    const Front& front = fronts_[f];
    const int n = front.eliminated;
    for (const int child : front.children) {
      ForRuns(fronts_[At(child)], front, Part::kEliminated, [&](int row, int to, int rows) {
        x_.middleRows(front.first_row + to, rows) -= sums_[At(child)].middleRows(row, rows);
      });
    }
    const double* const panel = factor_ + own_.panel[f];
    double* const top = x_.data() + front.first_row;
    dense::SolveLeft(n, ColumnCount(x_), panel, front.height(), top, RowCount(x_));
    MatrixXd& sum = sums_[f];
    if (n == 0) {
      sum.setZero(front.remaining, x_.cols());
    } else if (front.remaining > 0) {
      sum.resize(front.remaining, x_.cols());
      dense::Product(front.remaining,
                     ColumnCount(x_),
                     n,
                     panel + n,
                     front.height(),
                     top,
                     RowCount(x_),
                     sum.data(),
                     front.remaining);
    }
    for (const int child : front.children) {
      ForRuns(fronts_[At(child)], front, Part::kRemaining, [&](int row, int to, int rows) {
        sum.middleRows(to - n, rows) += sums_[At(child)].middleRows(row, rows);
      });
      sums_[At(child)].resize(0, 0);
    }
  }

  void MoveUp(int stage, Ranks* ranks) {
    std::vector<RankPart> parts;
    FrontMoves moves(own_, &parts);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      if (own_.division.stage[f] != stage || !own_.division.Crosses(fronts_[f], f)) continue;
      const std::size_t parent = At(fronts_[f].parent);
      if (own_.Owns(parent)) sums_[f].resize(fronts_[f].remaining, x_.cols());
      const std::size_t count = At(fronts_[f].remaining) * At(ColumnCount(x_));
      moves.Add(sums_[f].data(), count, own_.division.owner[f], own_.division.owner[parent]);
    }
    ranks->Share(parts);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      const bool gone = own_.division.stage[f] == stage && own_.division.Crosses(fronts_[f], f);
      if (gone && own_.Owns(f)) sums_[f].resize(0, 0);
    }
  }

  const OwnFronts& own_;
  const std::vector<Front>& fronts_;
  const double* factor_;
  MatrixXd& x_;
  std::vector<MatrixXd> sums_;  // by front, over R, until the parent has taken it
};

/// x_J of one front of x = L'^-1 x, all rows of R being there.
void WorkBackward(const Symbolic& symbolic,
                  const Front& front,
                  const double* panel,
                  MatrixXd* remaining,
                  MatrixXd& x) {
  const int n = front.eliminated, height = front.height();
  double* const top = x.data() + front.first_row;
  if (front.remaining > 0) {
    remaining->resize(front.remaining, x.cols());
    int row = 0;
    for (const int block : front.rows) {
      const int begin = symbolic.row_begin[At(block)];
      const int size = symbolic.row_begin[At(block) + 1] - begin;
      remaining->middleRows(row, size) = x.middleRows(begin, size);
      row += size;
    }
    dense::SubtractTransposedProduct(n,
                                     ColumnCount(x),
                                     front.remaining,
                                     panel + n,
                                     height,
                                     remaining->data(),
                                     front.remaining,
                                     top,
                                     RowCount(x));
  }
  dense::SolveLeftTransposed(n, ColumnCount(x), panel, height, top, RowCount(x));
}

/// The rows that a stage eliminates, from the ranks that have them to all.
void ShareRows(const OwnFronts& own, int stage, Ranks* ranks, MatrixXd* x) {
  std::vector<RankPart> parts;
  for (Eigen::Index column = 0; column < x->cols(); ++column) {
    for (std::size_t f = 0; f < own.symbolic.fronts.size(); ++f) {
      if (own.division.stage[f] != stage) continue;
      const Front& front = own.symbolic.fronts[f];
      const std::span<double> rows(x->col(column).data() + front.first_row, At(front.eliminated));
      AddPart(std::as_writable_bytes(rows), own.division.owner[f], &parts);
    }
  }
  ranks->Share(parts);
}

}  // namespace

void SolveFronts(const OwnFronts& own, const double* factor, MatrixXd* x) {
  Ranks* const ranks = RanksOf(own);
  Forward(own, factor, x).Run(ranks);
  MatrixXd remaining;
  for (int stage = own.division.stages; stage-- > 0;) {
    const std::vector<std::size_t>& fronts = own.stages[At(stage)];
    for (auto f = fronts.rbegin(); f != fronts.rend(); ++f) {
      WorkBackward(own.symbolic, own.symbolic.fronts[*f], factor + own.panel[*f], &remaining, *x);
    }
    if (ranks != nullptr) ShareRows(own, stage, ranks, x);
  }
}

}  // namespace sarblock::sparse

namespace sarblock {
namespace {

/// Columns that are solved for at once: their memory.
constexpr int kTermsAtOnce = 256;

int Terms(const Eigen::MatrixXd& k) { return static_cast<int>(k.rows()); }

}  // namespace

Eigen::VectorXd BorderedMatrix::Diagonal() const {
  Eigen::VectorXd out(rows());
  for (int b = 0; b < sparse.block_count(); ++b) {
    out.segment(sparse.offset(b), sparse.size(b)) = sparse.Block(b, b).diagonal();
  }
  return out - border.ColumnSquares();
}

Eigen::MatrixXd BorderedMatrix::ToDense() const {
  const Eigen::MatrixXd t = border.ToDense();
  return sparse.ToDense() - t.transpose() * t;
}

Eigen::MatrixXd BorderedMatrix::Multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  Eigen::MatrixXd out = sparse.Multiply(x);
  if (border.terms() > 0) border.AddTransposedTimes(-border.Times(x), out);
  return out;
}

BorderedMatrix BorderedMatrix::Scaled(const Eigen::VectorXd& d) const {
  BorderedMatrix out(sparse, border.Scaled(d));
  ScaleBlocks(d, &out.sparse);
  return out;
}

void ScaleBlocks(const Eigen::VectorXd& d, BlockSymmetricMatrix* matrix) {
  for (int j = 0; j < matrix->block_count(); ++j) {
    for (const int i : matrix->RowsOfColumn(j)) {
      matrix->Block(i, j) = d.segment(matrix->offset(i), matrix->size(i)).asDiagonal() *
                            matrix->Block(i, j) *
                            d.segment(matrix->offset(j), matrix->size(j)).asDiagonal();
    }
  }
}

bool BorderedCholesky::Factorize(const BorderedMatrix& matrix) {
  if (!factor_.Factorize(matrix.sparse).positive_definite) return false;
  const Border& t = matrix.border;
  z_ = Border(t.shared_pattern());
  k_.setIdentity(t.terms(), t.terms());
  if (t.terms() == 0) return true;
  const int most = t.pattern().MaxTerms();
  for (int first = 0; first < most; first += kTermsAtOnce) {
    SolveTerms(t, first, std::min(kTermsAtOnce, most - first));
  }
  for (const BorderPattern::Group& group : t.pattern().groups()) {
    const Eigen::MatrixXd product = t.Of(group) * z_.Of(group).transpose();
    k_(group.terms, group.terms) -= product;
  }
  return dense::Factor(Terms(k_), k_.data(), Terms(k_)) == 0;
}

/// Z of some terms of every group: A joins no two groups, so one column serves all of them.
void BorderedCholesky::SolveTerms(const Border& t, int first, int count) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(t.columns(), count);
  const auto terms_of = [&](const BorderPattern::Group& group) {
    return std::clamp(static_cast<int>(group.terms.size()) - first, 0, count);
  };
  for (const BorderPattern::Group& group : t.pattern().groups()) {
    const int terms = terms_of(group);
    columns(group.columns, Eigen::seqN(0, terms)) =
        t.Of(group).middleRows(first, terms).transpose();
  }
  factor_.Solve(columns);
  for (const BorderPattern::Group& group : t.pattern().groups()) {
    const int terms = terms_of(group);
    z_.Of(group).middleRows(first, terms) =
        columns(group.columns, Eigen::seqN(0, terms)).transpose();
  }
}

void BorderedCholesky::Solve(Eigen::Ref<Eigen::MatrixXd> b) const {
  if (z_.terms() == 0) {
    factor_.Solve(b);
    return;
  }
  Eigen::MatrixXd of_border = z_.Times(b);
  const int columns = static_cast<int>(b.cols());
  dense::SolveLeft(Terms(k_), columns, k_.data(), Terms(k_), of_border.data(), Terms(k_));
  dense::SolveLeftTransposed(Terms(k_), columns, k_.data(), Terms(k_), of_border.data(), Terms(k_));
  factor_.Solve(b);
  z_.AddTransposedTimes(of_border, b);
}

BorderedInverse BorderedCholesky::SelectedInverse() const {
  BorderedInverse out{factor_.SelectedInverse(), Border(z_.shared_pattern())};
  if (z_.terms() == 0) return out;
  Eigen::MatrixXd k_inverse = k_;
  dense::InvertFromFactor(Terms(k_), k_inverse.data(), Terms(k_));
  k_inverse.triangularView<Eigen::StrictlyUpper>() = k_inverse.transpose();
  for (const BorderPattern::Group& group : z_.pattern().groups()) {
    out.border.Of(group).noalias() = k_inverse(group.terms, group.terms).eval() * z_.Of(group);
  }
  // S^-1 = A^-1 + Z (K^-1 Z'), where the blocks of A are: within a group.
  BlockSymmetricMatrix& blocks = out.blocks;
  for (int j = 0; j < blocks.block_count(); ++j) {
    if (blocks.size(j) == 0) continue;
    const int g = z_.pattern().GroupOf(blocks.offset(j));
    if (g < 0) continue;
    const BorderPattern::Group& group = z_.pattern().groups()[static_cast<std::size_t>(g)];
    const auto of_column =
        out.border.Of(group).middleCols(z_.pattern().PlaceOf(blocks.offset(j)), blocks.size(j));
    for (const int i : blocks.RowsOfColumn(j)) {
      if (blocks.size(i) == 0) continue;
      blocks.Block(i, j) += z_.Of(group)
                                .middleCols(z_.pattern().PlaceOf(blocks.offset(i)), blocks.size(i))
                                .transpose() *
                            of_column;
    }
  }
  return out;
}

}  // namespace sarblock
