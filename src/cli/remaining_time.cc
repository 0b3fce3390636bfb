// SPDX-License-Identifier: Apache-2.0
#include "remaining_time.h"

#include <algorithm>

namespace sarblock::cli {

bool RemainingTime::IsStable(double spent_s) {
  constexpr double kLeast_s = 3.0, kPart_1 = 2.0 / 3.0, kSpread_1 = 1.3;
  constexpr std::size_t kLeast = 4;
  std::erase_if(whole_s_, [&](const auto& of) { return of.first < kPart_1 * spent_s; });
  if (spent_s < kLeast_s || whole_s_.size() < kLeast) return false;
  const auto [least, most] =
      std::minmax_element(whole_s_.begin(), whole_s_.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  return most->second < kSpread_1 * least->second;
}

std::optional<double> RemainingTime::Update(std::string_view stage,
                                            std::size_t done,
                                            std::size_t total,
                                            double now_s) {
  if (stage != stage_ || done < done_) {
    stage_ = stage;
    done_ = 0;
    begin_s_ = now_s;
    whole_s_.clear();
    told_s_.reset();
  }
  if (done == 0 || done >= total) return std::nullopt;
  const double spent_s = now_s - begin_s_;
  const double part_1 = static_cast<double>(done) / static_cast<double>(total);
  if (done > done_) whole_s_.emplace_back(spent_s, spent_s / part_1);
  done_ = done;
  const double left_s = spent_s / part_1 - spent_s;
  if (!told_s_) {
    if (!IsStable(spent_s)) return std::nullopt;
    told_s_ = left_s;
  } else {
    constexpr double kWrong_1 = 2.0, kStep_1 = 1.25, kEnd_s = 2.0;
    const double expected_s = std::max(*told_s_ - (now_s - told_at_s_), kEnd_s);
    if (left_s > kWrong_1 * expected_s || (expected_s > kEnd_s && left_s < expected_s / kWrong_1)) {
      told_s_.reset();
      whole_s_.clear();
      return std::nullopt;
    }
    told_s_ = std::clamp(left_s, expected_s / kStep_1, kStep_1 * expected_s);
  }
  told_at_s_ = now_s;
  return told_s_;
}

}  // namespace sarblock::cli
