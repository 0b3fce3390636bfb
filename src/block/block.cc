// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/block.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/memory.h"
#include "core/threads.h"

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
  Gather(old_of_new, &looks->pass);
  Gather(old_of_new, &looks->flags);
  Gather(old_of_new, &looks->time_s);
  Gather(old_of_new, &looks->range_m);
  Gather(old_of_new, &looks->cone);
  Gather(old_of_new, &looks->range_sigma_m);
  Gather(old_of_new, &looks->azimuth_sigma);
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
