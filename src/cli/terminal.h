// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sarblock::cli {

/// Columns of a terminal that text for people is fitted to.
inline constexpr std::size_t kColumns = 80;

/// Breaks lines longer than kColumns (of UTF-8 characters) at spaces; the next lines are indented
/// by four more than the first. Rows of tables (cells parted by three spaces or more) stay as they
/// are, and so does a word that is longer than a line.
[[nodiscard]] std::string FitColumns(std::string_view text);

/// The same for the text of --help: what follows a broken line begins below its description.
[[nodiscard]] std::string FitHelp(std::string_view text);

/// Remaining time of the running stage, from its progress. Parts of a stage may cost very different
/// times (blocks of a study, iterations), so nothing is shown until the extrapolated total has
/// stayed within 30 % for a third of the time spent, and nothing again once the shown time turns
/// out wrong by a factor of two. From one call to the next the shown time differs from a countdown
/// by at most a quarter.
class RemainingTime {
 public:
  /// To be called with every report of progress, times in seconds of any clock that only goes on.
  /// Seconds until this stage ends, or nothing.
  std::optional<double> Update(std::string_view stage,
                               std::size_t done,
                               std::size_t total,
                               double now_s);

 private:
  [[nodiscard]] bool IsStable(double spent_s);
  std::string stage_;
  std::size_t done_ = 0;
  double begin_s_ = 0.0;
  std::vector<std::pair<double, double>> whole_s_;  ///< time spent, whole time extrapolated
  std::optional<double> shown_s_;
  double shown_at_s_ = 0.0;
};

}  // namespace sarblock::cli
