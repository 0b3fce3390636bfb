// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/block.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

/// Fills the offsets of looks that are in order; false if they are not.
bool TakeOffsetsOfSorted(const std::vector<std::uint32_t>& point_of_look,
                         std::size_t point_count,
                         Looks* looks) {
  const std::size_t count = point_of_look.size();
  std::vector<std::uint8_t> sorted(PiecesOfLooks(count), 1);
  ForPiecesOfLooks(count, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    for (std::size_t i = std::max<std::size_t>(1, begin); i < end; ++i) {
      if (point_of_look[i - 1] < point_of_look[i] ||
          (point_of_look[i - 1] == point_of_look[i] && looks->pass[i - 1] <= looks->pass[i])) {
        continue;
      }
      sorted[piece] = 0;
      return;
    }
  });
  if (std::find(sorted.begin(), sorted.end(), 0) != sorted.end()) return false;
  std::vector<std::uint64_t>& offsets = looks->offsets;
  offsets.clear();
  ReserveInLargePages(point_count + 1, &offsets);
  offsets.resize(point_count + 1, count);
  ForPiecesOfLooks(count, [&](std::size_t, std::size_t begin, std::size_t end) {
    // The first point that does not begin before look i.
    std::size_t next = begin == 0 ? 0 : point_of_look[begin - 1] + std::size_t{1};
    for (std::size_t i = begin; i < end; ++i) {
      while (next <= point_of_look[i]) offsets[next++] = i;
    }
  });
  return true;
}

[[noreturn]] void RefuseEntry(const char* array, std::size_t index, const std::string& problem) {
  throw InputError(std::string(array) + "[" + std::to_string(index) + "]", problem);
}

std::string Got(double value) { return ", got " + NumberText(value); }
std::string Got(std::size_t value) { return ", got " + std::to_string(value); }

constexpr double kRightAngle_rad = 0.5 * std::numbers::pi;

/// "BEGINNING 'PASS' must be a number above 0, got -1".
void RequirePositive(const char* array,
                     std::size_t index,
                     double value,
                     const char* beginning = "",
                     const std::string& pass = {}) {
  const char* const problem = ProblemOfPositive(value);
  if (problem == nullptr) return;
  const std::string whose = pass.empty() ? "" : beginning + (" '" + pass + "' ");
  RefuseEntry(array, index, whose + MustBe(problem, NumberText(value)));
}

void RequirePasses(const std::vector<Pass>& passes) {
  std::unordered_map<std::string_view, std::size_t> first;
  for (std::size_t i = 0; i < passes.size(); ++i) {
    const Pass& pass = passes[i];
    const auto [found, is_new] = first.emplace(pass.id, i);
    if (!is_new) {
      RefuseEntry("passes",
                  i,
                  "has the id '" + pass.id + "' of passes[" + std::to_string(found->second) +
                      "]; every pass needs one of its own");
    }
    if (pass.path.piece_count() == 0) {
      RefuseEntry("passes", i, "'" + pass.id + "' has no flight path; set path to a FlightPath");
    }
    if (!std::isfinite(pass.start_s) || !std::isfinite(pass.end_s) ||
        !(pass.start_s < pass.end_s)) {
      RefuseEntry("passes",
                  i,
                  "'" + pass.id + "' must have start_s less than end_s, got " +
                      NumberText(pass.start_s) + " and " + NumberText(pass.end_s) +
                      "; SetStripSpans() sets them");
    }
    if (pass.side != LookSide::kLeft && pass.side != LookSide::kRight) {
      RefuseEntry("passes", i, "'" + pass.id + "' has no side; kLeft or kRight is allowed");
    }
    if (const auto problem = pass.swath ? ProblemOf(*pass.swath) : std::nullopt) {
      RefuseEntry("passes",
                  i,
                  "'" + pass.id + "': " +
                      kSwathKeys[static_cast<std::size_t>(pass.swath->kind)].key + " " + *problem);
    }
    if (!(std::abs(pass.squint_rad) < kRightAngle_rad)) {
      RefuseEntry("passes",
                  i,
                  "'" + pass.id + "' must have a squint between -pi/2 and pi/2 [rad], exclusive" +
                      Got(pass.squint_rad));
    }
  }
}

void RequireLength(const char* array, std::size_t length, std::size_t needed, bool may_be_empty) {
  if (length == needed || (may_be_empty && length == 0)) return;
  throw InputError(array,
                   "must have " + std::to_string(needed) + " entries" +
                       (may_be_empty ? ", or none" : "") + Got(length));
}

/// Lengths and indices, so that nothing is read beyond an array.
void RequireArrays(const Block& block) {
  const Points& points = block.points;
  const Looks& looks = block.looks;
  const std::size_t n = looks.size();
  RequireLength("points.role", points.role.size(), points.ids.size(), false);
  RequireLength("points.given_m", points.given_m.size(), points.size(), false);
  Looks::ForColumns([&](const char* name, auto column, auto... standard) {
    RequireLength(name, (looks.*column).size(), n, sizeof...(standard) == 1);
  });
  const std::vector<std::uint64_t>& offsets = looks.offsets;
  if (offsets.size() != points.size() + 1) {
    throw InputError("looks.offsets",
                     "must have one entry more than there are points, " +
                         std::to_string(points.size() + 1) + Got(offsets.size()) +
                         "; SortLooksByPoint() makes them");
  }
  if (offsets.front() != 0) RefuseEntry("looks.offsets", 0, "must be 0" + Got(offsets.front()));
  for (std::size_t j = 1; j < offsets.size(); ++j) {
    if (offsets[j] >= offsets[j - 1] && offsets[j] <= n) continue;
    RefuseEntry("looks.offsets",
                j,
                "must be between the entry before, " + std::to_string(offsets[j - 1]) +
                    ", and the number of looks, " + std::to_string(n) + Got(offsets[j]) +
                    "; SortLooksByPoint() makes them");
  }
  if (offsets.back() != n) {
    RefuseEntry("looks.offsets",
                points.size(),
                "must be the number of looks, " + std::to_string(n) + Got(offsets.back()) +
                    "; SortLooksByPoint() makes them");
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (looks.pass[i] < block.passes.size()) continue;
    RefuseEntry("looks.pass",
                i,
                "must be below " + std::to_string(block.passes.size()) + ", the number of passes" +
                    Got(std::size_t{looks.pass[i]}));
  }
}

void RequireSigma(const Block& block, std::size_t i) {
  const std::string& pass = block.passes[block.looks.pass[i]].id;
  const LookSigma sigma = block.SigmaOf(i);
  constexpr const char* kWhose = "the standard deviation of the look or of its pass";
  RequirePositive("looks.range_sigma_m", i, sigma.range_m, kWhose, pass);
  RequirePositive("looks.azimuth_sigma", i, sigma.azimuth, kWhose, pass);
  if (sigma.azimuth_unit == AzimuthUnit::kHertz && !block.MeasuresDoppler(i)) {
    RefuseEntry("looks.azimuth_sigma",
                i,
                "is in hertz, of the look or its pass '" + pass +
                    "', which needs a Doppler: flag kDoppler and a cone [Hz]");
  }
}

void RequireCone(const Block& block, std::size_t i) {
  const Looks& looks = block.looks;
  const bool doppler = (looks.flags[i] & Looks::kDoppler) != 0;
  if (!doppler) {
    if (looks.cone.empty() || std::abs(looks.cone[i]) < kRightAngle_rad) return;
    RefuseEntry("looks.cone",
                i,
                "a squint must be between -pi/2 and pi/2 [rad], exclusive" + Got(looks.cone[i]));
  }
  if (looks.cone.empty()) RefuseEntry("looks.flags", i, "kDoppler needs the array looks.cone [Hz]");
  if (!std::isfinite(looks.cone[i])) {
    RefuseEntry("looks.cone", i, "a Doppler must be finite" + Got(looks.cone[i]));
  }
  const Pass& pass = block.passes[looks.pass[i]];
  RequirePositive("looks.flags",
                  i,
                  pass.wavelength_m,
                  "kDoppler needs a wavelength; wavelength_m of pass",
                  pass.id);
}

void RequireLooks(const Block& block) {
  const Looks& looks = block.looks;
  constexpr unsigned kAllFlags =
      Looks::kRejected | Looks::kDoppler | Looks::kAzimuthSeconds | Looks::kAzimuthHertz;
  constexpr unsigned kUnits = Looks::kAzimuthSeconds | Looks::kAzimuthHertz;
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> point_of_pass(block.passes.size(), kNone);  // whose look came last
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const unsigned flags = looks.flags[i];
      if ((flags & ~kAllFlags) != 0) {
        RefuseEntry("looks.flags", i, "must be a sum of Looks::Flag" + Got(std::size_t{flags}));
      }
      if (looks.rejected(i)) continue;
      if ((flags & kUnits) == kUnits) {
        RefuseEntry("looks.flags", i, "kAzimuthSeconds and kAzimuthHertz exclude each other");
      }
      if (std::exchange(point_of_pass[looks.pass[i]], point) == point) {
        RefuseEntry("looks.pass",
                    i,
                    "is a second look of pass '" + block.passes[looks.pass[i]].id + "' at point '" +
                        std::string(block.points.ids[static_cast<std::uint32_t>(point)]) +
                        "'; one is allowed");
      }
      if (std::isinf(looks.time_s[i])) {
        RefuseEntry("looks.time_s", i, "must be finite, or NaN of a plan" + Got(looks.time_s[i]));
      }
      if (!std::isnan(looks.range_m[i])) RequirePositive("looks.range_m", i, looks.range_m[i]);
      RequireCone(block, i);
      RequireSigma(block, i);
    }
  }
}

void RequireCovariance(const KnownPosition& known, bool is_control, std::size_t k) {
  const Eigen::Matrix3d& c = known.covariance_enu_m2;
  Eigen::Matrix3d scaled = Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!known.fixed[static_cast<std::size_t>(i)]) continue;
    const bool fits = std::isfinite(c(i, i)) && (is_control ? c(i, i) > 0.0 : c(i, i) >= 0.0);
    if (!fits) {
      RefuseEntry("points.known",
                  k,
                  "the variance of component " + std::to_string(i) + " (east, north, up) must be " +
                      (is_control ? "above 0" : "0 or above") + Got(c(i, i)));
    }
    for (Eigen::Index j = 0; j < i; ++j) {
      if (!known.fixed[static_cast<std::size_t>(j)] || (c(i, j) == 0.0 && c(j, i) == 0.0)) continue;
      const double scale = std::sqrt(c(i, i)) * std::sqrt(c(j, j));
      if (!(std::abs(c(i, j) - c(j, i)) <= 1e-9 * scale)) {
        RefuseEntry("points.known", k, "its covariance must be symmetric");
      }
      scaled(i, j) = scaled(j, i) = c(i, j) / scale;
    }
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(scaled);
  if (factor.info() != Eigen::Success) {
    RefuseEntry("points.known", k, "its covariance must be positive definite");
  }
}

void RequirePoints(const Points& points) {
  for (std::size_t k = 0; k < points.known.size(); ++k) {
    const KnownPosition& known = points.known[k];
    if (known.point >= points.size()) {
      RefuseEntry("points.known",
                  k,
                  "its point must be below " + std::to_string(points.size()) +
                      ", the number of points" + Got(std::size_t{known.point}));
    }
    if (k > 0 && known.point <= points.known[k - 1].point) {
      RefuseEntry("points.known",
                  k,
                  "must be sorted by point, each once: after " +
                      std::to_string(points.known[k - 1].point) + Got(std::size_t{known.point}));
    }
    const PointRole role = points.role[known.point];
    if (role == PointRole::kTie) {
      RefuseEntry("points.known", k, "is of a tie point; control or check is allowed");
    }
    if (!points.given_m[known.point].allFinite()) {
      RefuseEntry("points.given_m", known.point, "of a known point must be finite");
    }
    RequireCovariance(known, role == PointRole::kControl, k);
  }
  for (std::size_t j = 0; j < points.size(); ++j) {
    const PointRole role = points.role[j];
    if (role != PointRole::kTie && role != PointRole::kControl && role != PointRole::kCheck) {
      RefuseEntry("points.role", j, "must be kTie, kControl or kCheck");
    }
    if (role != PointRole::kControl) continue;
    if (points.FindKnown(static_cast<std::uint32_t>(j)) == nullptr) {
      RefuseEntry("points.role", j, "is control without an entry in points.known");
    }
  }
}

double ValueOr(const std::vector<double>& column, std::size_t row, double otherwise) {
  return column.empty() || std::isnan(column[row]) ? otherwise : column[row];
}

}  // namespace

std::size_t Looks::PointOf(std::size_t look) const {
  const auto after = std::upper_bound(offsets.begin(), offsets.end(), look);
  return static_cast<std::size_t>(after - offsets.begin()) - 1;
}

const KnownPosition* Points::FindKnown(std::uint32_t point) const {
  const auto found = std::lower_bound(
      known.begin(), known.end(), point, [](const KnownPosition& entry, std::uint32_t wanted) {
        return entry.point < wanted;
      });
  return found != known.end() && found->point == point ? &*found : nullptr;
}

LookSigma Block::SigmaOf(std::size_t look) const {
  LookSigma sigma = passes[looks.pass[look]].sigma;
  sigma.range_m = ValueOr(looks.range_sigma_m, look, sigma.range_m);
  if (const double own = ValueOr(looks.azimuth_sigma, look, kNotGiven); !std::isnan(own)) {
    const std::uint8_t flags = looks.flags[look];
    sigma.azimuth = own;
    sigma.azimuth_unit = (flags & Looks::kAzimuthHertz) != 0     ? AzimuthUnit::kHertz
                         : (flags & Looks::kAzimuthSeconds) != 0 ? AzimuthUnit::kSeconds
                                                                 : AzimuthUnit::kMetres;
  }
  return sigma;
}

double Block::ApproximateAzimuthUnit_m(std::size_t look, double speed_mps) const {
  if (!MeasuresDoppler(look)) return speed_mps;
  return 0.5 * passes[looks.pass[look]].wavelength_m * looks.range_m[look] / speed_mps;
}

double Block::ApproximateAzimuthSigma_m(std::size_t look, double speed_mps) const {
  const LookSigma sigma = SigmaOf(look);
  return sigma.azimuth_unit == AzimuthUnit::kMetres
             ? sigma.azimuth
             : sigma.azimuth * ApproximateAzimuthUnit_m(look, speed_mps);
}

std::optional<std::string> ProblemOf(const Swath& swath) {
  const auto [near, far] = swath.limits;
  const bool angle = swath.kind == SwathKind::kLookAngle;
  if (near >= 0.0 && near < far && std::isfinite(far) && !(angle && far >= kRightAngle_rad)) {
    return std::nullopt;
  }
  const double factor = kSwathKeys[static_cast<std::size_t>(swath.kind)].factor;
  return std::string("must be near and far, 0 <= near < far") + (angle ? " < 90" : "") + ", got " +
         Digits(near / factor, 9) + " and " + Digits(far / factor, 9);
}

void Validate(const Block& block) {
  RequirePasses(block.passes);
  RequireArrays(block);
  RequirePoints(block.points);
  RequireLooks(block);
}

std::vector<std::uint32_t> SortLooksByPoint(const std::vector<std::uint32_t>& point_of_look,
                                            std::size_t point_count,
                                            Looks* looks) {
  std::vector<std::uint64_t>& offsets = looks->offsets;
  if (TakeOffsetsOfSorted(point_of_look, point_count, looks)) return {};
  offsets.assign(point_count + 1, 0);
  // Counting sort: offsets[j + 1] first counts the looks of point j, then is where j's next look
  // goes, and ends as the end of point j's looks.
  for (const std::uint32_t point : point_of_look) ++offsets[point + 1];
  std::uint64_t begin = 0;
  for (std::size_t j = 1; j <= point_count; ++j) {
    begin += std::exchange(offsets[j], begin);
  }
  std::vector<std::uint32_t> old_of_new(point_of_look.size());
  for (std::uint32_t old = 0; old < point_of_look.size(); ++old) {
    old_of_new[offsets[point_of_look[old] + 1]++] = old;
  }
  const auto by_pass = [looks](std::uint32_t a, std::uint32_t b) {
    // Looks of one pass (refused later as duplicates) keep the order of the file.
    return looks->pass[a] != looks->pass[b] ? looks->pass[a] < looks->pass[b] : a < b;
  };
  for (std::size_t j = 0; j < point_count; ++j) {
    const auto first = old_of_new.begin() + static_cast<std::ptrdiff_t>(offsets[j]);
    const auto last = old_of_new.begin() + static_cast<std::ptrdiff_t>(offsets[j + 1]);
    std::sort(first, last, by_pass);
  }
  Looks::ForColumns(
      [&](const char*, auto column, auto...) { Gather(old_of_new, &(looks->*column)); });
  return old_of_new;
}

void SetStripSpans(const std::vector<std::optional<std::array<double, 2>>>& fixed_s, Block* block) {
  std::vector<Pass>& passes = block->passes;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  using Spans = std::vector<std::array<double, 2>>;
  const Spans none(passes.size(), {kInfinity, -kInfinity});
  std::vector<Spans> pieces(PiecesOfLooks(block->looks.size()), none);
  ForPiecesOfLooks(block->looks.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    for (std::size_t look = begin; look < end; ++look) {
      if (block->looks.rejected(look)) continue;
      const double time_s = block->looks.time_s[look];
      std::array<double, 2>& span_s = pieces[piece][block->looks.pass[look]];
      span_s = {std::min(span_s[0], time_s), std::max(span_s[1], time_s)};  // NaN: a planned look
    }
  });
  Spans seen_s = none;
  for (const Spans& piece : pieces) {
    for (std::size_t i = 0; i < passes.size(); ++i) {
      seen_s[i] = {std::min(seen_s[i][0], piece[i][0]), std::max(seen_s[i][1], piece[i][1])};
    }
  }
  for (std::size_t i = 0; i < passes.size(); ++i) {
    Pass& pass = passes[i];
    const bool seen = seen_s[i][0] <= seen_s[i][1];
    if (seen) {
      pass.start_s = seen_s[i][0];
      pass.end_s = seen_s[i][1];
    }
    if (i < fixed_s.size() && fixed_s[i]) {
      pass.start_s = (*fixed_s[i])[0];
      pass.end_s = (*fixed_s[i])[1];
      if (!(pass.start_s < pass.end_s)) {
        throw InputError("pass " + pass.id + " start_s", "start_s must be less than end_s");
      }
    } else if (!seen && !pass.path.states().empty()) {
      pass.start_s = pass.path.start_s();
      pass.end_s = pass.path.end_s();
    } else if (!(pass.start_s < pass.end_s)) {
      pass.start_s -= 0.5;
      pass.end_s = pass.start_s + 1.0;
    }
  }
}

}  // namespace sarblock
