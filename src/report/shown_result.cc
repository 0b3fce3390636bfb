// SPDX-License-Identifier: Apache-2.0
#include "shown_result.h"

#include "sarblock/core/error.h"
#include "sarblock/files/result.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "page.h"
#include <fmt/core.h>

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
      keep(looks.quality.redundancy[k], i, &out->redundancy[k]);
      keep(looks.mdb_m[k], i, &out->mdb_m[k]);
      keep(looks.influence_m[k], i, &out->influence_m[k]);
      keep(looks.quality.w[k], i, &out->w[k]);
      const bool weak =
          !looks.quality.redundancy[k].empty() &&
          !(static_cast<double>(looks.quality.redundancy[k][i]) >= ReportLooks::kMinTested);
      if (!looks.quality.w[k].empty() && !weak) {
        worst.Add(std::abs(static_cast<double>(looks.quality.w[k][i])), {i, k});
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

namespace {

bool HasSigma(const files::ResultPoints& points, std::size_t i) {
  return IsSolved(points.results.status[i]) && !std::isnan(SigmaOf(points, i, 0));
}

bool IsFree(const files::ResultPoints& points, std::size_t i) {
  return HasSigma(points, i) && points.role[i] != PointRole::kControl &&
         points.results.looks[i] > 1;
}

/// See AccuracyFigures::along_track.
double AlongTrack(const ResultFolder& result, const MapPlane& plane, std::size_t axis) {
  if (axis == 2) return 0.0;
  const files::ResultLooks& looks = result.file.looks;
  std::vector<double> weight(result.file.passes.size(), 0.0);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks.rejected[i] == 0 && IsFree(result.file.points, looks.point[i])) {
      weight[looks.pass[i]] += 1.0;
    }
  }
  double sum = 0.0, weights = 0.0;
  for (const std::span<const StripStation> strip : StripsOf(result.file)) {
    const auto first = plane.Place(strip.front().antenna_m);
    const auto last = plane.Place(strip.back().antenna_m);
    const double east_m = last[0] - first[0], north_m = last[1] - first[1];
    const double length2_m2 = east_m * east_m + north_m * north_m;
    if (!(length2_m2 > 0.0)) continue;
    const double along_m = axis == 0 ? east_m : north_m;
    sum += weight[strip.front().pass] * along_m * along_m / length2_m2;
    weights += weight[strip.front().pass];
  }
  return weights > 0.0 ? sum / weights : kAbsent;
}

ConvexHull HullOfControl(const files::ResultPoints& points, const MapPlane& plane) {
  std::vector<std::array<double, 2>> places_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.role[i] == PointRole::kControl) {
      places_m.push_back(plane.Place(points.results.position_m[i]));
    }
  }
  return ConvexHull(std::move(places_m));
}

AccuracyFigures::Group DescribeGroup(const files::ResultPoints& points,
                                     const std::vector<std::uint32_t>& members,
                                     const ConvexHull& hull,
                                     const MapPlane& plane) {
  AccuracyFigures::Group out;
  out.points = members.size();
  std::vector<double> angle_deg, looks;
  std::size_t outside = 0;
  for (const std::uint32_t i : members) {
    angle_deg.push_back(IntersectionOf_deg(points, i));
    looks.push_back(points.results.looks[i]);
    const std::array<double, 2> place = plane.Place(points.results.position_m[i]);
    if (!hull.Contains(place[0], place[1])) ++outside;
  }
  out.median_intersection_deg = SampleQuantile(std::move(angle_deg), 0.5);
  out.median_looks = SampleQuantile(std::move(looks), 0.5);
  if (hull.HasArea() && !members.empty()) {
    out.outside_control = static_cast<double>(outside) / static_cast<double>(members.size());
  }
  return out;
}

}  // namespace

std::array<const char*, 3> AxisNames(const Frame& frame) {
  if (frame.kind() == FrameKind::kGeocentric) return {"east", "north", "up"};
  return {"x", "y", "z"};
}

MapPlane::MapPlane(const ResultFolder& result) {
  const Frame& frame = result.file.frame;
  if (frame.kind() != FrameKind::kGeocentric) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const Eigen::Vector3d& p : result.file.points.results.position_m) {
    if (std::isnan(p[0])) continue;
    sum += p;
    count += 1.0;
  }
  if (count == 0.0) return;
  origin_m_ = sum / count;
  axes_ = frame.EnuFromFrame(origin_m_);
  const Geodetic place = frame.GeodeticFromFrame(origin_m_);
  middle_ = fmt::format("{:.4f}, {:.4f}", place.lat_rad * kDegPerRad, place.lon_rad * kDegPerRad);
}

std::array<double, 2> MapPlane::Place(const Eigen::Vector3d& position_m) const {
  const Eigen::Vector3d place_m = axes_ * (position_m - origin_m_);
  return {place_m[0], place_m[1]};
}

AccuracyFigures DescribeAccuracy(const ResultFolder& result) {
  const files::ResultPoints& points = result.file.points;
  AccuracyFigures out;
  std::vector<std::uint32_t> members, free;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (HasSigma(points, i)) members.push_back(i);
    if (IsFree(points, i)) free.push_back(i);
  }
  out.points = members.size();
  out.free_points = free.size();
  if (members.empty()) return out;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> sigma_m;
    std::uint32_t largest = members.front();
    for (const std::uint32_t i : members) {
      sigma_m.push_back(SigmaOf(points, i, k));
      if (SigmaOf(points, i, k) > SigmaOf(points, largest, k)) largest = i;
    }
    constexpr std::array kParts{0.5, 0.95};
    const std::vector<double> parts = SampleQuantiles(std::move(sigma_m), kParts);
    out.median_m[k] = parts[0];
    out.most_m[k] = parts[1];
    out.largest_m[k] = SigmaOf(points, largest, k);
    out.largest_point[k] = std::string(points.ids[largest]);
  }
  out.weakest = static_cast<int>(std::max_element(out.median_m.begin(), out.median_m.end()) -
                                 out.median_m.begin());
  if (free.empty()) return out;
  std::array<double, 3> free_median_m{};
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> sigma_m;
    for (const std::uint32_t i : free) sigma_m.push_back(SigmaOf(points, i, k));
    free_median_m[k] = SampleQuantile(std::move(sigma_m), 0.5);
  }
  out.weakest = static_cast<int>(std::max_element(free_median_m.begin(), free_median_m.end()) -
                                 free_median_m.begin());
  const auto weak = static_cast<std::size_t>(out.weakest);
  std::vector<double> parts;
  for (const std::uint32_t i : free) {
    const double looks_m = FixedPathSigmaOf(points, i, weak), whole_m = SigmaOf(points, i, weak);
    parts.push_back(1.0 - looks_m * looks_m / (whole_m * whole_m));
  }
  out.path_part = SampleQuantile(std::move(parts), 0.5);
  const MapPlane plane(result);
  out.along_track = AlongTrack(result, plane, weak);
  const ConvexHull hull = HullOfControl(points, plane);
  out.all = DescribeGroup(points, free, hull, plane);
  out.median_intersection_deg = out.all.median_intersection_deg;
  const std::size_t twentieth = std::max<std::size_t>(1, free.size() / 20);
  std::partial_sort(free.begin(),
                    free.begin() + static_cast<std::ptrdiff_t>(twentieth),
                    free.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return SigmaOf(points, a, weak) > SigmaOf(points, b, weak);
                    });
  free.resize(twentieth);
  out.weak = DescribeGroup(points, free, hull, plane);
  return out;
}

namespace {

constexpr double kPathsDecide = 0.6, kLooksDecide = 0.4;
constexpr double kMinAlong = 0.7, kMaxAcross = 0.3;
constexpr double kGoodAngle_deg = 60.0;

enum class Direction { kAlong, kRanges, kBoth, kUnknown };

Direction DirectionOf(const AccuracyFigures& accuracy) {
  if (std::isnan(accuracy.along_track)) return Direction::kUnknown;
  if (accuracy.along_track > kMinAlong) return Direction::kAlong;
  return accuracy.along_track < kMaxAcross ? Direction::kRanges : Direction::kBoth;
}

std::string Percent(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

/// What would lower the part of the looks, briefly.
std::string LooksBriefly(const AccuracyFigures& accuracy) {
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return "azimuth accuracy, more looks";
    case Direction::kBoth:
      return "azimuth and range accuracy, more looks";
    case Direction::kUnknown:
      return "more and better looks";
    case Direction::kRanges:
      break;
  }
  return accuracy.median_intersection_deg < kGoodAngle_deg ? "larger angles, more and better ranges"
                                                           : "more and better ranges";
}

std::string LooksInWords(const AccuracyFigures& accuracy) {
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return "more accurate azimuths (image times) or more looks per point";
    case Direction::kBoth:
      return "more accurate azimuths and ranges or more looks per point";
    case Direction::kUnknown:
      return "more accurate looks or more of them per point";
    case Direction::kRanges:
      break;
  }
  return accuracy.median_intersection_deg < kGoodAngle_deg
             ? fmt::format(
                   "larger intersection angles (the median is {} degrees), more looks per "
                   "point or more accurate ranges",
                   ReadableNumber(accuracy.median_intersection_deg, 3))
             : "more looks per point or more accurate ranges";
}

/// "north (along track)"
std::string WeakestName(const AccuracyFigures& accuracy, const Frame& frame) {
  const std::string axis = AxisNames(frame)[static_cast<std::size_t>(accuracy.weakest)];
  if (accuracy.weakest == 2) return axis;
  switch (DirectionOf(accuracy)) {
    case Direction::kAlong:
      return axis + " (along track)";
    case Direction::kRanges:
      return axis + " (across track)";
    case Direction::kBoth:
      return axis + " (along some tracks, across others)";
    case Direction::kUnknown:
      break;
  }
  return axis;
}

}  // namespace

Advice AdviceOf(const AccuracyFigures& accuracy, const Frame& frame) {
  if (accuracy.free_points == 0) return {"", ""};
  const std::string weakest = WeakestName(accuracy, frame);
  const double part = accuracy.path_part;
  if (std::isnan(part)) {
    return {LooksBriefly(accuracy),
            fmt::format(
                "The weakest component is {}: {} would help.", weakest, LooksInWords(accuracy))};
  }
  const std::string paths = "control points or better flight paths";
  const std::string shares = fmt::format(
      "The weakest component is {}: {} of its variance comes from the flight paths and "
      "{} from the noise of the looks, so ",
      weakest,
      Percent(part),
      Percent(1.0 - part));
  if (part > kPathsDecide) return {"control, better paths", shares + paths + " would help most."};
  if (part < kLooksDecide) {
    return {LooksBriefly(accuracy), shares + LooksInWords(accuracy) + " would help most."};
  }
  return {
      "control, and " + LooksBriefly(accuracy),
      shares + "both would have to improve: " + paths + ", and " + LooksInWords(accuracy) + "."};
}

namespace {

std::string Brief(double value) { return ReadableNumber(value, 3); }

/// "in x" of a local frame, "east" of a geocentric one.
std::array<std::string, 3> AxisPhrases(const Frame& frame) {
  std::array<std::string, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool geocentric = frame.kind() == FrameKind::kGeocentric;
    out[k] = std::string(geocentric ? "" : "in ") + AxisNames(frame)[k];
  }
  return out;
}

const char* Plural(std::size_t count) { return count == 1 ? "" : "s"; }

/// "0.38 m in x, 1.6 m in y and 2.8 m in z"
std::string AxesPhrase(const std::array<double, 3>& sigma_m,
                       const std::array<std::string, 3>& axes) {
  return fmt::format("{} m {}, {} m {} and {} m {}",
                     Brief(sigma_m[0]),
                     axes[0],
                     Brief(sigma_m[1]),
                     axes[1],
                     Brief(sigma_m[2]),
                     axes[2]);
}

/// What the global test says where it failed: by how much, and what that means for the figures.
std::string FitClause(const files::ResultSummary& summary) {
  if (!summary.chi_square || summary.chi_square->passed) return "";
  const files::ResultTest& test = *summary.chi_square;
  const bool worse = test.sigma0_squared * test.redundancy > test.chi_square.upper;
  return fmt::format("; residuals are {} times as large as stated, {}",
                     Brief(std::sqrt(test.sigma0_squared)),
                     summary.sigma_scaled_by_posterior
                         ? "by which the standard deviations of this report are scaled"
                     : worse ? "and the standard deviations too small by about this factor"
                             : "and the standard deviations may be too large");
}

/// What check points say of an accepted accuracy. Where they contradict, a reason says it.
std::string CheckClause(const files::ResultSummary& summary) {
  if (!summary.checks || summary.checks->points == 0) {
    return "; without check points nothing independent confirms the accuracy";
  }
  if (!summary.checks->realistic) return "";
  return fmt::format("; {} check point{} agree{} with the predicted accuracy",
                     summary.checks->points,
                     Plural(summary.checks->points),
                     summary.checks->points == 1 ? "s" : "");
}

std::string StatusSentence(const files::ResultSummary& summary) {
  const std::string rounds =
      fmt::format("{} iteration{}", summary.iterations, Plural(summary.iterations));
  if (summary.status == "not_converged") {
    return fmt::format(
        "The adjustment did not converge in {}: the Newton decrement was {} sigma, so its numbers "
        "are those of an unfinished solution.",
        rounds,
        Brief(summary.remaining_step));
  }
  if (summary.status == "intersected") {
    return "Every point was intersected alone from its looks, with the flight paths taken as "
           "exact: the standard deviations hold the noise of the looks only.";
  }
  if (summary.status == "predicted") {
    return "This is a plan: the covariance follows from geometry and weights alone, nothing was "
           "measured, so there is nothing to accept or to reject.";
  }
  switch (summary.verdict) {
    case Verdict::kAccepted:
      return fmt::format("The adjustment converged in {} and every test is passed{}.",
                         rounds,
                         CheckClause(summary));
    case Verdict::kTestsFailed:
      return fmt::format("The adjustment converged in {}, but tests failed{}{}.",
                         rounds,
                         FitClause(summary),
                         CheckClause(summary));
    case Verdict::kNotAccepted:
      return fmt::format(
          "The adjustment converged in {} to a solution whose standard deviations mean nothing.",
          rounds);
  }
  return "";
}

void AddAccuracy(const ResultFolder& result, const AccuracyFigures& accuracy, Headline* out) {
  if (accuracy.points == 0) {
    out->sentences.push_back("No covariance was computed, so nothing can be said of the accuracy.");
    return;
  }
  const std::array<std::string, 3> axes = AxisPhrases(result.file.frame);
  if (accuracy.free_points == 0) {
    out->sentences.push_back(
        fmt::format("Control or a single look decides every point, so the standard deviations (in "
                    "the median {}) say nothing of the block.",
                    AxesPhrase(accuracy.median_m, axes)));
    return;
  }
  const auto weak = static_cast<std::size_t>(accuracy.weakest);
  out->sentences.push_back(
      fmt::format("Half of the {} points are known to {} or better, 95 % to {}; the weakest is {} "
                  "with {} m {} (one sigma).",
                  ReadableCount(accuracy.points),
                  AxesPhrase(accuracy.median_m, axes),
                  AxesPhrase(accuracy.most_m, axes),
                  accuracy.largest_point[weak],
                  Brief(accuracy.largest_m[weak]),
                  axes[weak]));
}

void AddAttention(const ResultFolder& result, Headline* out) {
  const files::ResultSummary& summary = result.file.summary;
  std::vector<std::string>& list = out->attention;
  for (const std::string& reason : summary.verdict_reasons) list.push_back(reason + ".");
  if (const std::size_t count = result.unsolved.size(); count > 0) {
    list.push_back(fmt::format("{} point{} could not be determined and {} left out.",
                               ReadableCount(count),
                               Plural(count),
                               count == 1 ? "was" : "were"));
  }
  if (result.looks.rejected > 0) {
    std::string reasons;
    for (const auto& [reason, count] : result.looks.rejected_by_reason) {
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, reason);
    }
    list.push_back(fmt::format("{} of {} looks were left out ({}).",
                               ReadableCount(result.looks.rejected),
                               ReadableCount(result.file.looks.size()),
                               reasons));
  }
  if (const std::size_t count = result.correlation_count; count > 0) {
    list.push_back(
        fmt::format("{} pair{} of corrections {} correlated above {}: what they do together is "
                    "known better than each alone.",
                    ReadableCount(count),
                    Plural(count),
                    count == 1 ? "is" : "are",
                    kHighCorrelation));
  }
  if (!summary.warnings.empty()) {
    const std::size_t count = summary.warnings.size();
    list.push_back(fmt::format(
        "The run gave {} warning{}, listed under Counts and settings.", count, Plural(count)));
  }
}

}  // namespace

Headline HeadlineOf(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const files::ResultSummary& summary = result.file.summary;
  Headline out;
  out.sentences.push_back(StatusSentence(summary));
  AddAccuracy(result, accuracy, &out);
  // A solution that is not accepted gets its reasons and no advice.
  if (summary.verdict != Verdict::kNotAccepted || summary.status == "predicted") {
    Advice advice = AdviceOf(accuracy, result.file.frame);
    out.would_help = advice.would_help;
    if (!advice.sentence.empty()) out.sentences.push_back(std::move(advice.sentence));
  }
  AddAttention(result, &out);
  if (summary.status == "predicted") {
    out.state = HeadlineState::kNeutral;
    out.word = "Predicted";
    return out;
  }
  const bool intersected = summary.status == "intersected";
  switch (summary.verdict) {
    case Verdict::kAccepted:
      out.state = HeadlineState::kAccepted;
      out.word = intersected ? "Intersected, accepted" : "Accepted";
      break;
    case Verdict::kTestsFailed:
      out.state = HeadlineState::kTestsFailed;
      out.word = intersected ? "Intersected, tests failed" : "Converged, tests failed";
      break;
    case Verdict::kNotAccepted:
      out.state = HeadlineState::kNotAccepted;
      out.word = intersected                         ? "Intersected, not accepted"
                 : summary.status == "not_converged" ? "Not accepted: not converged"
                                                     : "Not accepted";
      break;
  }
  return out;
}

}  // namespace sarblock
