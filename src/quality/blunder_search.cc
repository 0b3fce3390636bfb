// SPDX-License-Identifier: Apache-2.0
#include "blunder_search.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include "point_sweep.h"
#include "solve/rank.h"
#include "solve/solve_block.h"
#include "solve/structure.h"
#include "verdict_tests.h"
#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

/// Looks are units 0, 1, ...; the known position is the unit after them.
Eigen::Index UnitOf(const PointResiduals& residuals, Eigen::Index row) {
  return std::min(row / 2, static_cast<Eigen::Index>(residuals.looks.size()));
}

/// Row of the largest |w|; -1 where nothing has a test.
Eigen::Index LargestRow(const PointResiduals& residuals) {
  Eigen::Index largest = -1;
  double w = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const double here = std::abs(residuals.w(i));
    if (!(here > w)) continue;  // NaN neither
    w = here;
    largest = i;
  }
  return largest;
}

bool MayExplain(const PointResiduals& residuals, Eigen::Index i, Eigen::Index k, double accepted) {
  const double w_k = residuals.w(k);
  if (std::isnan(w_k)) return false;  // an error there shows nowhere
  const double rho = residuals.Correlation(i, k);
  if (std::abs(rho) > kSameTest) return true;
  const double freed = (residuals.w(i) - rho * w_k) / std::sqrt((1.0 - rho) * (1.0 + rho));
  return std::abs(freed) <= accepted;
}

bool IsRemoved(const PointResiduals& residuals, const SuspectSet& set, Eigen::Index row) {
  const Eigen::Index unit = UnitOf(residuals, row);
  if (unit == static_cast<Eigen::Index>(residuals.looks.size())) return set.control;
  return std::find(set.looks.begin(),
                   set.looks.end(),
                   residuals.looks[static_cast<std::size_t>(unit)]) != set.looks.end();
}

}  // namespace

SuspectSet FindSuspects(const PointResiduals& residuals, double separation) {
  SuspectSet set;
  const Eigen::Index largest = LargestRow(residuals);
  if (largest < 0) return set;
  const auto looks = static_cast<Eigen::Index>(residuals.looks.size());
  std::vector<std::uint8_t> suspect(residuals.looks.size() + 1, 0);
  const double accepted = NormalQuantile(0.5 * (1.0 + separation));
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const auto unit = static_cast<std::size_t>(UnitOf(residuals, k));
    if (MayExplain(residuals, largest, k, accepted)) suspect[unit] = 1;
  }
  const Eigen::Index first = UnitOf(residuals, largest);
  set.largest_w = residuals.w(largest);
  set.azimuth = first < looks && largest % 2 == 1;
  if (first < looks) set.looks.push_back(residuals.looks[static_cast<std::size_t>(first)]);
  for (Eigen::Index unit = 0; unit < looks; ++unit) {
    if (unit == first || suspect[static_cast<std::size_t>(unit)] == 0) continue;
    set.looks.push_back(residuals.looks[static_cast<std::size_t>(unit)]);
  }
  set.control = first == looks || suspect.back() != 0;
  set.rest_determines = RestDetermines(residuals, set);
  return set;
}

bool RestDetermines(const PointResiduals& residuals, const SuspectSet& set) {
  if (set.looks.size() >= residuals.looks_of_point) return false;
  Eigen::Matrix3d left = Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    if (!IsRemoved(residuals, set, i)) continue;
    left -= residuals.information.row(i).transpose() * residuals.information.row(i);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(left, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > kMinInformationPart;
}

double ReachOf(const PointResiduals& residuals, const SuspectSet& set) {
  double reach = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const double w = residuals.w(i);
    if (std::isnan(w) || (set.rest_determines && !IsRemoved(residuals, set, i))) continue;
    reach += std::abs(w) * std::sqrt(residuals.corrections_share(i, i) / residuals.q_vv(i, i));
  }
  return reach;
}

bool StaysSuspect(const PointResiduals& residuals, double max_reach, double critical) {
  const Eigen::Index i = LargestRow(residuals);
  if (i < 0) return false;
  const double part = std::sqrt(residuals.corrections_share(i, i) / residuals.q_vv(i, i));
  return std::abs(residuals.w(i)) - part * max_reach > critical;
}

std::string DescribeContradiction(const Block& block, const SuspectSet& set) {
  std::string text = "its observations contradict each other and none can be identified as wrong: ";
  for (std::size_t i = 0; i < set.looks.size(); ++i) {
    text += (i == 0 ? "" : ", ") + block.passes[block.looks.pass[set.looks[i]]].id;
  }
  if (set.control) text += set.looks.empty() ? "its known position" : ", its known position";
  return text;
}

std::size_t CountTests(const LookQuality& quality, const std::vector<ControlQuality>& control) {
  const auto has_test = [](float w) { return !std::isnan(w); };
  std::size_t tests = 0;
  for (const std::vector<float>& w : quality.w) {
    tests += static_cast<std::size_t>(std::count_if(w.begin(), w.end(), has_test));
  }
  for (const ControlQuality& of : control) tests += std::isnan(of.w) ? 0U : 1U;
  return tests;
}

namespace {

void WarnOfFindings(AdjustResult* result) {
  std::size_t kept = 0;
  for (const BlunderFinding& finding : result->snooping->findings) {
    kept += finding.action == BlunderFinding::Action::kKept ? 1U : 0U;
  }
  if (kept > 0) {
    Warn(result,
         std::to_string(kept) +
             " suspected blunders were kept in the adjustment, see the findings of the search");
  }
  if (result->snooping->rounds >= kMaxSearchRounds) {
    Warn(result,
         "the search for blunders ended after " + std::to_string(result->snooping->rounds) +
             " rounds and is not complete");
  }
}

}  // namespace

void FillReasons(const AdjustmentProblem& problem,
                 const std::vector<std::size_t>& dropped,
                 AdjustResult* result) {
  const Block& block = problem.block;
  std::vector<RejectReason>& reason = result->looks.reason;
  std::vector<std::uint8_t>& rejected = result->looks.rejected;
  reason.assign(block.looks.size(), RejectReason::kNone);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (rejected[i] == 0) continue;
    reason[i] = block.looks.rejected(i) ? RejectReason::kGiven : RejectReason::kNoValue;
  }
  const auto mark = [&](std::size_t look, RejectReason why) {
    rejected[look] = 1;
    reason[look] = why;
  };
  for (const std::size_t look : dropped) mark(look, RejectReason::kRobust);
  if (!result->snooping) return;
  for (const std::uint64_t look : result->snooping->robust) mark(look, RejectReason::kRobust);
  for (const BlunderFinding& finding : result->snooping->findings) {
    if (!LeavesOut(finding)) continue;
    for (const std::uint64_t look : finding.looks) {
      mark(look, finding.located() ? RejectReason::kBlunder : RejectReason::kSuspect);
    }
  }
  WarnOfFindings(result);
}

namespace {

/// Control points that are kept for the datum.
constexpr std::size_t kMinControlPoints = 3;

using Action = BlunderFinding::Action;

/// A point whose largest statistic is above the critical value.
struct Candidate {
  std::uint32_t point = 0;
  double w = 0.0;
};

/// What a removal takes, so that it can be undone.
struct Removal {
  std::uint32_t point = 0;
  PointStatus status = PointStatus::kAdjusted;
  std::string reason;
  std::int32_t control_of = -1;
  std::vector<std::uint64_t> looks;
};

class Search {
 public:
  Search(const AdjustOptions& options,
         const SolveAgain& solve,
         AdjustmentProblem* problem,
         BlockState* state,
         ProgressSink* progress,
         std::vector<BlunderFinding> found)
      : options_(options),
        solve_(solve),
        problem_(*problem),
        state_(*state),
        progress_(progress),
        fixed_(problem->block.points.size(), 0),
        readmitted_(problem->look_used.size(), 0),
        taken_back_(problem->block.points.size(), 0),
        given_(*problem),
        given_state_(*state),
        given_looks_(static_cast<double>(CountProblem(*problem).looks)) {
    report_.findings = std::move(found);
  }

  std::optional<SnoopingReport> Run() {
    const bool searched = !report_.findings.empty();
    if (options_.quality.snooping == Snooping::kRobust && !searched) StartRobust();
    bool stands = Rounds();
    while (stands && Readmit()) stands = Rounds();
    if (!stands) {
      GiveWay();
      return std::nullopt;
    }
    NameReadmitted();
    return std::move(report_);
  }

 private:
  [[nodiscard]] bool Rounds();
  [[nodiscard]] bool LeavesOutTooMany() const;
  void GiveWay();
  void TestSolution();
  [[nodiscard]] std::vector<Candidate> Candidates() const;
  [[nodiscard]] bool TakeCandidates();
  [[nodiscard]] PointResiduals ResidualsOf(std::uint32_t point) const;
  [[nodiscard]] bool Examine(const Candidate& candidate, double* max_reach);
  [[nodiscard]] bool MayRelease(std::uint32_t point) const;
  void Remove(const SuspectSet& set, BlunderFinding* finding);
  void Undo(std::size_t keep, const std::string& note);
  void DropOfRobust(std::uint32_t point, double limit);
  void StartRobust();
  [[nodiscard]] bool Readmit();
  void NameReadmitted();

  const AdjustOptions& options_;
  const SolveAgain& solve_;
  AdjustmentProblem& problem_;
  BlockState& state_;
  ProgressSink* progress_;
  SnoopingReport report_;
  std::optional<ReducedSystem> system_;
  std::optional<CorrectionCovariance> inverse_;
  LookQuality quality_;
  std::vector<ControlQuality> control_quality_;
  ReliabilityFigures figures_;
  double scale_ = 1.0;  // of w to the statistic that is tested
  double critical_ = 0.0;
  PassConnection connection_;
  std::vector<Removal> removals_;  // of the last round
  bool one_at_a_time_ = false;
  std::vector<std::uint8_t> fixed_;       // by point: reported, not touched again
  std::vector<std::uint8_t> readmitted_;  // by look: once is enough
  std::vector<std::uint8_t> taken_back_;  // by point: so too
  // Before the search, so that it can be undone.
  Participation given_;
  BlockState given_state_;
  double given_looks_;  // in use
};

/// Quality figures and critical value at the present solution. Where the last round's removals left
/// corrections open they are undone first.
void Search::TestSolution() {
  for (;;) {
    try {
      FormDetermined(state_, {}, &problem_, &system_, progress_);
      FactorRegular(&*system_);
      break;
    } catch (const UndeterminedError&) {
      if (removals_.empty()) throw;
      one_at_a_time_ = removals_.size() > 1;
      Undo(0, one_at_a_time_ ? "" : "without it the corrections are not determined");
      solve_(RobustLoss::kNone);
    }
  }
  removals_.clear();
  inverse_.reset();
  if (problem_.layout.size() > 0) inverse_ = system_->SelectedInverse();
  PointSweep sweep = SweepPoints(
      problem_, state_, inverse_ ? &*inverse_ : nullptr, true, progress_, system_->kept());
  control_quality_ = ControlQualities(problem_, state_, sweep.covariance_m2);
  quality_ = std::move(sweep.quality);
  const ProblemCounts counts = CountProblem(problem_);
  const double redundancy =
      static_cast<double>(counts.observations) - static_cast<double>(counts.parameters);
  figures_ = MakeReliability(options_.quality, CountTests(quality_, control_quality_), redundancy);
  const bool tau = options_.quality.test == BlunderTest::kTau;
  critical_ = tau ? figures_.critical_tau : figures_.critical_w;
  const double sigma0 = std::sqrt(2.0 * system_->cost() / redundancy);
  scale_ = tau ? 1.0 / sigma0 : 1.0;
  connection_ = ConnectPasses(problem_);
  ++report_.rounds;
}

std::vector<Candidate> Search::Candidates() const {
  std::vector<Candidate> found;
  const auto& offsets = problem_.block.looks.offsets;
  std::size_t next = 0;
  for (std::uint32_t point = 0; point < problem_.block.points.size(); ++point) {
    double largest = 0.0;
    for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      for (const std::vector<float>& w : quality_.w) {
        largest = std::max(largest, std::abs(static_cast<double>(w[i])));  // NaN never wins
      }
    }
    for (; next < control_quality_.size() && control_quality_[next].point <= point; ++next) {
      if (control_quality_[next].point == point) {
        largest = std::max(largest, std::abs(control_quality_[next].w));
      }
    }
    if (fixed_[point] == 0 && scale_ * largest > critical_) found.push_back({point, largest});
  }
  std::stable_sort(
      found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.w > b.w; });
  return found;
}

/// Known positions may go while enough of them remain.
bool Search::MayRelease(std::uint32_t point) const {
  if (options_.quality.snooping == Snooping::kNone) return false;
  std::size_t others = 0;
  for (const ControlEquations& control : problem_.control) {
    const bool counts = problem_.Solves(control.point) && problem_.control_of[control.point] >= 0;
    if (counts && control.point != point) ++others;
  }
  return others >= kMinControlPoints;
}

/// Takes what the set names, or the whole point where too little remains of it.
void Search::Remove(const SuspectSet& set, BlunderFinding* finding) {
  const std::uint32_t point = finding->point;
  Removal removal{point,
                  problem_.point_status[point],
                  problem_.point_reason[point],
                  problem_.control_of[point],
                  {}};
  const auto& offsets = problem_.block.looks.offsets;
  for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem_.look_used[i] != 0) removal.looks.push_back(i);
  }
  removals_.push_back(std::move(removal));
  if (set.control) problem_.control_of[point] = -1;
  if (set.rest_determines) {
    for (const std::uint64_t look : set.looks) problem_.look_used[look] = 0;
    finding->action = set.control ? Action::kControlReleased : Action::kRejected;
    return;
  }
  problem_.LeaveOut(point, PointStatus::kApart, DescribeContradiction(problem_.block, set));
  finding->action = Action::kPointLeftOut;
}

/// Takes back the removals from the `keep`-th on. With a note their points are kept and reported,
/// without they are candidates again.
void Search::Undo(std::size_t keep, const std::string& note) {
  while (removals_.size() > keep) {
    const Removal& removal = removals_.back();
    problem_.point_status[removal.point] = removal.status;
    problem_.point_reason[removal.point] = removal.reason;
    problem_.control_of[removal.point] = removal.control_of;
    for (const std::uint64_t look : removal.looks) problem_.look_used[look] = 1;
    const auto finding =
        std::find_if(report_.findings.rbegin(), report_.findings.rend(), [&](const auto& f) {
          return f.point == removal.point && f.action != Action::kKept;
        });
    if (note.empty()) {
      report_.findings.erase(std::next(finding).base());
    } else {
      finding->action = Action::kKept;
      finding->note = note;
      fixed_[removal.point] = 1;
    }
    removals_.pop_back();
  }
}

/// Residuals of a point; where hundreds of passes see it, only those of the look of its largest
/// |w|.
PointResiduals Search::ResidualsOf(std::uint32_t point) const {
  const CorrectionCovariance* inverse = inverse_ ? &*inverse_ : nullptr;
  PointLinearization at(problem_, state_, inverse);
  if (inverse == nullptr || inverse->bordered.RowOf(point) < 0) {
    return at.At(point).Residuals();
  }
  const auto& offsets = problem_.block.looks.offsets;
  std::uint64_t largest = offsets[point];
  float largest_w = 0.0F;
  for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    for (const std::vector<float>& w : quality_.w) {
      if (!(std::abs(w[i]) > largest_w)) continue;
      largest_w = std::abs(w[i]);
      largest = i;
    }
  }
  return at.At(point).ResidualsOf(largest);
}

/// Decides on one candidate; true where something was removed.
bool Search::Examine(const Candidate& candidate, double* max_reach) {
  const PointResiduals residuals = ResidualsOf(candidate.point);
  if (!StaysSuspect(residuals, *max_reach, critical_ / scale_)) return false;
  const SuspectSet set = FindSuspects(residuals, options_.quality.separation);
  BlunderFinding finding;
  finding.point = candidate.point;
  finding.round = report_.rounds;
  finding.w = set.largest_w;
  finding.azimuth = set.azimuth;
  finding.looks = set.looks;
  finding.control = set.control;
  if (set.control && !MayRelease(candidate.point)) {
    finding.note = "the control left would not fix the block";
    fixed_[candidate.point] = 1;
    report_.findings.push_back(std::move(finding));
    return false;
  }
  *max_reach += ReachOf(residuals, set);
  report_.findings.push_back(finding);
  Remove(set, &report_.findings.back());
  return true;
}

/// One round; false where nothing was removed.
bool Search::TakeCandidates() {
  const std::vector<Candidate> candidates = Candidates();
  double max_reach = 0.0;
  for (const Candidate& candidate : candidates) {
    if (!Examine(candidate, &max_reach)) continue;
    // The passes are looked at one removal at a time only where a round is known to cut them.
    const bool cut = one_at_a_time_ && !connection_.IsKeptBy(ConnectPasses(problem_));
    if (cut) Undo(removals_.size() - 1, "without it the passes would not be connected");
    if (one_at_a_time_ && !cut) break;
  }
  if (removals_.empty()) return false;
  if (!connection_.IsKeptBy(ConnectPasses(problem_))) {
    Undo(0, "");
    one_at_a_time_ = true;
    return TakeCandidates();
  }
  return true;
}

/// False where too much had to go.
bool Search::Rounds() {
  if (LeavesOutTooMany()) return false;  // the robust start
  TestSolution();
  while (report_.rounds < kMaxSearchRounds && TakeCandidates()) {
    if (LeavesOutTooMany()) return false;
    solve_(RobustLoss::kNone);
    TestSolution();
  }
  return true;
}

bool Search::LeavesOutTooMany() const {
  const auto left = static_cast<double>(CountProblem(problem_).looks);
  return given_looks_ - left > kMaxLeftOut * given_looks_;
}

/// Everything as it was given.
void Search::GiveWay() {
  given_.Restore(&problem_);
  state_ = std::move(given_state_);
  solve_(options_.robust);
}

/// The looks of a point beyond `limit` in the robust solution, unless too little would remain.
void Search::DropOfRobust(std::uint32_t point, double limit) {
  SuspectSet far;
  const auto& offsets = problem_.block.looks.offsets;
  WhitenedLook at;
  for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem_.look_used[i] == 0) continue;
    if (!EvaluateWhitened(problem_, state_, {}, point, i, &at)) continue;
    if (at.whitened_error.squaredNorm() > limit) far.looks.push_back(i);
  }
  if (far.looks.empty()) return;
  const PointResiduals residuals =
      PointLinearization(problem_, state_, nullptr).At(point).Information();
  if (!RestDetermines(residuals, far)) return;
  for (const std::uint64_t look : far.looks) problem_.look_used[look] = 0;
  report_.robust.insert(report_.robust.end(), far.looks.begin(), far.looks.end());
}

/// A redescending loss finds a start that many blunders at once cannot mask.
void Search::StartRobust() {
  solve_(RobustLoss::kTukey);
  const double limit = FarSquare();
  const PassConnection before = ConnectPasses(problem_);
  for (std::uint32_t point = 0; point < problem_.block.points.size(); ++point) {
    if (problem_.Solves(point)) DropOfRobust(point, limit);
  }
  const auto take_back = [&] {
    for (const std::uint64_t look : report_.robust) problem_.look_used[look] = 1;
    report_.robust.clear();
  };
  if (!before.IsKeptBy(ConnectPasses(problem_))) take_back();
  try {
    FormDetermined(state_, {}, &problem_, &system_, progress_);
    FactorRegular(&*system_);
  } catch (const UndeterminedError&) {
    take_back();
  }
  solve_(RobustLoss::kNone);
}

/// Looks that were left out, though within the critical value in the solution without them: the
/// residual of a look left out scatters more than its measurement, never less.
bool Search::Readmit() {
  if (report_.rounds >= kMaxSearchRounds) return false;
  bool any = false;
  const auto try_look = [&](std::uint32_t point, std::uint64_t look) {
    if (readmitted_[look] != 0 || !problem_.Solves(point)) return;
    const auto corrected = problem_.model.CorrectedMotionAt(
        problem_.block.looks.pass[look], problem_.block.looks.time_s[look], state_.corrections);
    WhitenedLook at;
    if (!corrected || !EvaluateWhitened(problem_, state_, {}, point, look, &at)) return;
    if (!(scale_ * at.whitened_error.cwiseAbs().maxCoeff() <= critical_)) return;
    readmitted_[look] = 1;
    problem_.look_used[look] = 1;
    any = true;
  };
  for (BlunderFinding& finding : report_.findings) {
    if (finding.action == Action::kRejected) {
      for (const std::uint64_t look : finding.looks) try_look(finding.point, look);
    }
    if (finding.action != Action::kPointLeftOut || taken_back_[finding.point] != 0) continue;
    if (!TakeBack(finding.point, &problem_, &state_)) continue;
    taken_back_[finding.point] = 1;
    finding.action = Action::kReadmitted;
    any = true;
  }
  for (const std::uint64_t look : report_.robust) {
    try_look(static_cast<std::uint32_t>(problem_.block.looks.PointOf(look)), look);
  }
  if (any) solve_(RobustLoss::kNone);
  return any;
}

/// The findings speak of what is still left out.
void Search::NameReadmitted() {
  const auto in_use = [&](std::uint64_t look) { return problem_.look_used[look] != 0; };
  std::set<std::uint64_t> named;
  for (auto finding = report_.findings.rbegin(); finding != report_.findings.rend(); ++finding) {
    if (finding->action != Action::kRejected) continue;
    // A look that was taken back and left out again belongs to the later finding.
    const auto gone =
        std::remove_if(finding->looks.begin(), finding->looks.end(), [&](std::uint64_t look) {
          return in_use(look) || !named.insert(look).second;
        });
    finding->looks.erase(gone, finding->looks.end());
    if (finding->looks.empty()) finding->action = Action::kReadmitted;
  }
  const auto gone =
      std::remove_if(report_.robust.begin(), report_.robust.end(), [&](std::uint64_t look) {
        return in_use(look) || named.count(look) != 0;
      });
  report_.robust.erase(gone, report_.robust.end());
}

}  // namespace

std::optional<SnoopingReport> SearchBlunders(const AdjustOptions& options,
                                             const SolveAgain& solve,
                                             AdjustmentProblem* problem,
                                             BlockState* state,
                                             ProgressSink* progress,
                                             std::vector<BlunderFinding> found) {
  return Search(options, solve, problem, state, progress, std::move(found)).Run();
}

}  // namespace sarblock
