// SPDX-License-Identifier: Apache-2.0
#include "result_folder.h"

#include "sarblock/core/error.h"
#include "sarblock/files/result.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sarblock {
namespace {

constexpr std::size_t kMaxCorrelations = 40;

void ArrangeCorrelations(ResultFolder* out) {
  std::vector<ReportCorrelation>& list = out->correlations;
  const auto larger = [](const ReportCorrelation& a, const ReportCorrelation& b) {
    return std::abs(a.correlation) > std::abs(b.correlation);
  };
  const std::vector<ParameterResult>& parameters = out->file.parameters;
  for (const ParameterCovariance& entry : out->file.parameter_covariance) {
    if (entry.a == entry.b) continue;
    const double correlation =
        entry.covariance / (parameters[entry.a].sigma * parameters[entry.b].sigma);
    if (!(std::abs(correlation) > kHighCorrelation)) continue;
    ++out->correlation_count;
    list.push_back({entry.a, entry.b, correlation});
    std::push_heap(list.begin(), list.end(), larger);
    if (list.size() > kMaxCorrelations) {
      std::pop_heap(list.begin(), list.end(), larger);
      list.pop_back();
    }
  }
  std::sort(list.begin(), list.end(), larger);
}

/// Keeps the looks with the largest `size`.
class LargestLooks {
 public:
  explicit LargestLooks(std::vector<ReportLook>* list) : list_(list) {}
  void Add(double size, ReportLook look) {
    const bool full = heap_.size() == ReportLooks::kMaxWorst;
    if (std::isnan(size) || (full && !(size > heap_.front().first))) return;
    heap_.emplace_back(size, look);
    std::push_heap(heap_.begin(), heap_.end(), &Larger);
    if (!full) return;
    std::pop_heap(heap_.begin(), heap_.end(), &Larger);
    heap_.pop_back();
  }
  void Finish() {
    std::sort_heap(heap_.begin(), heap_.end(), &Larger);
    for (const auto& [size, look] : heap_) list_->push_back(look);
  }

 private:
  using Entry = std::pair<double, ReportLook>;
  static bool Larger(const Entry& a, const Entry& b) { return a.first > b.first; }
  std::vector<Entry> heap_;
  std::vector<ReportLook>* list_;
};

void ArrangeLooks(const files::ResultLooks& looks, ReportLooks* out) {
  LargestLooks worst(&out->worst), left_out(&out->left_out);
  std::map<std::string, std::size_t> by_reason;
  const auto keep = [](const std::vector<float>& from, std::size_t i, std::vector<float>* to) {
    if (!from.empty() && !std::isnan(from[i])) to->push_back(from[i]);
  };
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::array<double, 2> residual_m{looks.range_residual_m[i], looks.azimuth_residual_m[i]};
    if (looks.rejected[i] != 0) {
      ++out->rejected;
      const RejectReason reason = looks.reason[i];
      ++by_reason[NameOf(reason == RejectReason::kNone ? RejectReason::kGiven : reason)];
      const double range_m = std::abs(residual_m[0]), azimuth_m = std::abs(residual_m[1]);
      left_out.Add(std::fmax(range_m, azimuth_m), {i, azimuth_m > range_m ? 1U : 0U});
      continue;
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (!std::isnan(residual_m[k])) {
        out->residual_m[k].push_back(static_cast<float>(residual_m[k]));
      }
      keep(looks.redundancy[k], i, &out->redundancy[k]);
      keep(looks.mdb_m[k], i, &out->mdb_m[k]);
      keep(looks.influence_m[k], i, &out->influence_m[k]);
      keep(looks.w[k], i, &out->w[k]);
      const bool weak = !looks.redundancy[k].empty() &&
                        !(static_cast<double>(looks.redundancy[k][i]) >= ReportLooks::kMinTested);
      if (!looks.w[k].empty() && !weak) {
        worst.Add(std::abs(static_cast<double>(looks.w[k][i])), {i, k});
      }
    }
  }
  worst.Finish();
  left_out.Finish();
  out->rejected_by_reason.assign(by_reason.begin(), by_reason.end());
}

}  // namespace

ResultFolder Arrange(std::string path, files::ResultFile file) {
  ResultFolder out;
  out.path = std::move(path);
  out.file = std::move(file);
  for (std::uint32_t i = 0; i < out.file.points.size(); ++i) {
    if (!IsSolved(out.file.points.results.status[i])) out.unsolved.push_back(i);
  }
  ArrangeCorrelations(&out);
  ArrangeLooks(out.file.looks, &out.looks);
  return out;
}

ResultFolder ReadResultFolder(const std::filesystem::path& folder, ProgressSink* progress) {
  return Arrange(folder.string(),
                 files::ReadResult(folder, {.paths = false, .progress = progress}));
}

double SigmaOf(const files::ResultPoints& points, std::size_t point, std::size_t axis) {
  const std::vector<SymmetricEnu>& q_m2 = points.results.covariance_m2;
  return q_m2.empty() ? kAbsent : std::sqrt(q_m2[point][axis]);
}

double FixedPathSigmaOf(const files::ResultPoints& points, std::size_t point, std::size_t axis) {
  const std::vector<SymmetricEnu>& q_m2 = points.results.fixed_path_covariance_m2;
  return q_m2.empty() ? kAbsent : std::sqrt(q_m2[point][axis]);
}

double FigureOf(const std::vector<double>& of_points, std::size_t point) {
  return of_points.empty() ? kAbsent : of_points[point];
}

double IntersectionOf_deg(const files::ResultPoints& points, std::size_t point) {
  return FigureOf(points.results.intersection_rad, point) * kDegPerRad;
}

std::vector<std::span<const StripStation>> StripsOf(const files::ResultFile& file) {
  std::vector<std::span<const StripStation>> strips;
  for (std::size_t begin = 0; begin < file.strips.size();) {
    std::size_t end = begin + 1;
    while (end < file.strips.size() && file.strips[end].pass == file.strips[begin].pass) ++end;
    strips.push_back(std::span(file.strips).subspan(begin, end - begin));
    begin = end;
  }
  return strips;
}

}  // namespace sarblock
