// SPDX-License-Identifier: Apache-2.0
// Standard deviations that are wrong, and what residuals show that no standard deviation explains.
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "mistakes.h"
#include "sample.h"

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

enum class Measured { kRange, kAzimuth, kBoth };

const char* WordOf(Measured measured) {
  return measured == Measured::kRange     ? "ranges"
         : measured == Measured::kAzimuth ? "azimuths"
                                          : "ranges and azimuths";
}

/// Factors by which standard deviations are wrong by a mistake of units. With one given value also
/// its square root: a variance written as a standard deviation is too large by that.
std::vector<KnownNumber> SigmaNumbers(double given) {
  std::vector<KnownNumber> numbers;
  if (given > 0.0 && std::abs(given - 1.0) > 0.05) {
    numbers.push_back({std::sqrt(given), "a variance given as standard deviation"});
  }
  numbers.push_back({100.0, "centimetres for metres, or a hundred"});
  numbers.push_back({0.01, "metres written as centimetres, or a hundred"});
  numbers.push_back({1000.0, "milliseconds for seconds, millimetres for metres"});
  numbers.push_back({0.001, "thousandths"});
  return numbers;
}

/// The value that all looks of some passes have; NaN where they differ.
double CommonSigma(const Block& block, const Names& passes, Measured measured) {
  double common = kNotGiven;
  bool differ = measured == Measured::kBoth;
  ForLooks(block, passes, [&](std::size_t i) {
    const LookSigma sigma = block.SigmaOf(i);
    const double value = measured == Measured::kRange ? sigma.range_m : sigma.azimuth;
    if (std::isnan(common)) common = value;
    differ = differ || value != common;
  });
  return differ ? kNotGiven : common;
}

/// The known factor that a size may be, within two of its sigmas, or the size.
std::string FactorInFiles(const std::vector<KnownNumber>& numbers, const Size& size) {
  constexpr double kMaxPart = 0.2;
  for (const KnownNumber& number : numbers) {
    const double off = std::abs(size.value - number.value);
    if (off < 2.0 * size.sigma && off < kMaxPart * number.value) return InFiles(number.value);
  }
  return InFiles(size.value, size.sigma);
}

/// Standard deviations of the ranges and of the azimuths of some passes (empty: all).
void MultiplySigmas(const Names& passes, double ranges, double azimuths, Block* block) {
  for (const std::uint32_t p : PassesOf(*block, passes)) {
    block->passes[p].sigma.range_m *= ranges;
    block->passes[p].sigma.azimuth *= azimuths;
  }
  Looks& looks = block->looks;
  ForLooks(*block, passes, [&](std::size_t i) {
    if (!looks.range_sigma_m.empty()) looks.range_sigma_m[i] *= ranges;
    if (!looks.azimuth_sigma.empty()) looks.azimuth_sigma[i] *= azimuths;
  });
}

Hypothesis ScaledSigma(const Block& block, const Names& passes, Measured measured, double factor) {
  Hypothesis out;
  out.kind = MistakeKind::kSigma;
  out.cause = measured == Measured::kRange     ? "sigma.range"
              : measured == Measured::kAzimuth ? "sigma.azimuth"
                                               : "sigma.all";
  out.passes = passes;
  out.undo = [passes, measured](Block* edited, double log_factor) {
    const double by = std::exp(-log_factor);
    MultiplySigmas(passes,
                   measured == Measured::kAzimuth ? 1.0 : by,
                   measured == Measured::kRange ? 1.0 : by,
                   edited);
  };
  out.free = true;
  out.logarithm = true;
  out.value = std::log(factor);
  out.step = 0.1;
  out.unit = "1";
  out.numbers = SigmaNumbers(CommonSigma(block, passes, measured));
  out.says = [passes, measured](const Size& size) {
    const bool large = size.value > 1.0;
    const double by = large ? size.value : 1.0 / size.value;
    return "the standard deviations of the " + std::string(WordOf(measured)) + " " +
           PassesPhrase(passes) + " are " + SizeOf(by, size.sigma / size.value * by, "").text +
           " times too " + (large ? "large" : "small");
  };
  out.change = [passes, measured, numbers = out.numbers](const Size& size) {
    return "block.toml: [sigma] (or the columns of observations.csv) of the " +
           std::string(WordOf(measured)) + " " + PassesPhrase(passes) + " divided by " +
           FactorInFiles(numbers, size);
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// All standard deviations of ranges and azimuths are variances: a factor of its own for each
/// value.
Hypothesis SquaredSigmas() {
  Hypothesis out;
  out.kind = MistakeKind::kSigma;
  out.cause = "sigma.variance";
  out.parameters = 0;
  out.undo = [](Block* edited, double) {
    const auto root = [](double* value) { *value = std::sqrt(*value); };
    for (Pass& pass : edited->passes) {
      root(&pass.sigma.range_m);
      root(&pass.sigma.azimuth);
    }
    for (double& sigma_m : edited->looks.range_sigma_m) root(&sigma_m);
    for (double& sigma : edited->looks.azimuth_sigma) root(&sigma);
  };
  out.says = [](const Size&) {
    return std::string("the standard deviations of the ranges and azimuths are variances");
  };
  out.change = [](const Size&) {
    return std::string(
        "block.toml: in [sigma] (or the columns of observations.csv) the square roots of the "
        "standard deviations");
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// Natural logarithms of what the standard deviations of a group of observations are to be
/// multiplied by.
struct LogFactors {
  double ranges = 0.0, azimuths = 0.0, known_points = 0.0;
  bool found = false;  ///< they no longer change
  Fit fit;             ///< the solution with them
  SampleResiduals residuals;
  double known_redundancy = 0.0;
  /// Sum of ln sigma^2 of the known points times their redundancy, on the way to them.
  double log_sigmas_known = 0.0;
};

enum class Groups { kLooks, kKnownPoints };

void Multiply(const LogFactors& factors, Block* block) {
  MultiplySigmas({}, std::exp(factors.ranges), std::exp(factors.azimuths), block);
  for (KnownPosition& known : block->points.known) {
    known.covariance_enu_m2 *= std::exp(2.0 * factors.known_points);
  }
}

/// v'Pv and redundancy of the ranges (column 0) or azimuths (1).
std::pair<double, double> SumsOf(const SampleResiduals& residuals, Eigen::Index column) {
  double square = 0.0, redundancy = 0.0;
  for (Eigen::Index i = 0; i < residuals.whitened_errors.rows(); ++i) {
    const double error = residuals.whitened_errors(i, column);
    const double part = residuals.redundancy(i, column);
    if (!std::isfinite(error) || !std::isfinite(part)) continue;
    square += error * error;
    redundancy += part;
  }
  return {square, redundancy};
}

/// Variance components of some groups with all others as given (Förstner 1979): a few solutions,
/// each with the standard deviations that the residuals of the one before ask for.
LogFactors EstimateFactors(const Facts& facts, Groups groups, Trials* trials) {
  constexpr double kSettled = 0.1;
  constexpr int kMostRounds = 12;
  LogFactors out;
  out.fit = facts.before;
  out.residuals = facts.residuals;
  SampleResiduals& residuals = out.residuals;
  double step = 0.0;
  const auto grow = [&](double square, double redundancy, double* log_factor) {
    if (!(redundancy > 0.0) || !(square > 0.0)) return 0.0;
    const double by = 0.5 * std::log(square / redundancy);
    step = std::max(step, std::abs(by));
    *log_factor += by;
    return by;
  };
  for (int round = 0; round < kMostRounds && out.fit.solved; ++round) {
    step = 0.0;
    const double redundancy = residuals.known_redundancy;
    double of_known = 0.0;
    if (groups == Groups::kKnownPoints) {
      of_known = grow(residuals.known_square, redundancy, &out.known_points);
    } else {
      const auto [range_square, range_redundancy] = SumsOf(residuals, 0);
      const auto [azimuth_square, azimuth_redundancy] = SumsOf(residuals, 1);
      grow(range_square, range_redundancy, &out.ranges);
      grow(azimuth_square, azimuth_redundancy, &out.azimuths);
    }
    if (step < kSettled) {
      out.found = true;
      break;
    }
    Hypothesis multiplied;
    multiplied.undo = [&out](Block* edited, double) { Multiply(out, edited); };
    out.fit = trials->With(multiplied, 0.0, {.warm = &out.fit.state, .effort = Effort::kQuick});
    if (!out.fit.solved) break;
    Block block = trials->given();
    Multiply(out, &block);
    residuals = ResidualsOf(block, facts.corrections, out.fit);
    out.known_redundancy = residuals.known_redundancy;
    out.log_sigmas_known += of_known * (redundancy + out.known_redundancy);
  }
  return out;
}

/// Redundancy numbers of the measurements with these factors. Those of ResidualsOf() leave out
/// what the corrections follow: together looks have what the block's redundancy has beside known
/// points and priors.
Eigen::MatrixX2d RedundancyWith(const LogFactors& factors, const Facts& facts, Trials* trials) {
  Block block = trials->given();
  Multiply(factors, &block);
  const PriorSums priors = PriorsOf(block, facts.corrections, factors.fit);
  Eigen::MatrixX2d out =
      factors.residuals.redundancy.unaryExpr([](double r) { return std::isfinite(r) ? r : 0.0; });
  const double of_looks =
      factors.fit.counts.redundancy() - priors.redundancy - factors.residuals.known_redundancy;
  const double alone = out.sum();
  if (priors.known && of_looks > 0.0 && alone > of_looks) out *= of_looks / alone;
  return out;
}

}  // namespace

void AddSigmaMistakes(const Facts& facts, Trials* trials, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const double s0 = std::sqrt(facts.before.square_sum / facts.before.redundancy);
  if (!(s0 > 0.0) || !std::isfinite(s0)) return;
  const LogFactors factors = EstimateFactors(facts, Groups::kLooks, trials);
  LogFactors as_given;
  as_given.fit = facts.before;
  as_given.residuals = facts.residuals;
  trials->WeighLogSigmas(RedundancyWith(factors.fit.solved ? factors : as_given, facts, trials));
  const double both = factors.found ? 0.5 * (factors.ranges + factors.azimuths) : std::log(s0);
  std::array<Hypothesis, 3> of_all{
      ScaledSigma(block, {}, Measured::kBoth, std::exp(-both)),
      ScaledSigma(block, {}, Measured::kRange, std::exp(-factors.ranges)),
      ScaledSigma(block, {}, Measured::kAzimuth, std::exp(-factors.azimuths))};
  // The work may end before all are tried: where one is far off by itself, it comes first.
  constexpr double kAlike = 1.0;
  if (std::abs(factors.azimuths) > std::abs(factors.ranges) + kAlike) {
    std::swap(of_all[0], of_all[2]);
  } else if (std::abs(factors.ranges) > std::abs(factors.azimuths) + kAlike) {
    std::swap(of_all[0], of_all[1]);
  }
  std::move(of_all.begin(), of_all.end(), std::back_inserter(*out));
  out->push_back(SquaredSigmas());
  if (block.passes.size() < 2) return;
  for (const Measured measured : {Measured::kBoth, Measured::kRange, Measured::kAzimuth}) {
    for (const Pass& pass : block.passes) {
      // A pass whose residuals are as large as those of the others is not asked for.
      double sum = 0.0, count = 0.0;
      ForLooks(block, {pass.id}, [&](std::size_t i) {
        const auto row = facts.residuals.whitened_errors.row(static_cast<Eigen::Index>(i));
        const double square = measured == Measured::kRange     ? row[0] * row[0]
                              : measured == Measured::kAzimuth ? row[1] * row[1]
                                                               : row.squaredNorm();
        if (!std::isfinite(square)) return;
        sum += square;
        count += measured == Measured::kBoth ? 2.0 : 1.0;
      });
      const double overall_ratio =
          facts.before.square_sum / (2.0 * static_cast<double>(facts.before.looks));
      const double share = count > 0.0 ? sum / count / overall_ratio : 1.0;
      if (share < 1.3 && share > 0.3) continue;
      if (share > 1.0 && sum < 0.3 * facts.before.square_sum) continue;
      out->push_back(
          ScaledSigma(block, {pass.id}, measured, 1.0 / std::sqrt(share * overall_ratio)));
    }
  }
}

namespace {

/// v'Pv over redundancy of the looks at tie points, while corrections stay; 0 without redundancy.
double FactorOfTies(const Facts& facts) {
  const Block& block = facts.sample.block;
  double square = 0.0, redundancy = 0.0;
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kTie) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto error = facts.residuals.whitened_errors.row(row);
      const auto part = facts.residuals.redundancy.row(row);
      if (!error.allFinite() || !part.allFinite()) continue;
      square += error.squaredNorm();
      redundancy += part.sum();
    }
  }
  return redundancy >= 1.0 ? square / redundancy : 0.0;
}

}  // namespace

void AddControlSigma(const Facts& facts, Trials* trials, Hypotheses* out) {
  constexpr double kTooLarge = 4.0, kContradicted = 3.0, kLeastRedundancy = 3.0;
  if (!facts.before.solved || facts.sample.block.points.known.empty()) return;
  Hypothesis hypothesis;
  hypothesis.kind = MistakeKind::kSigma;
  hypothesis.cause = "sigma.control";
  hypothesis.undo = [](Block* edited, double log_factor) {
    for (KnownPosition& known : edited->points.known) {
      known.covariance_enu_m2 *= std::exp(-2.0 * log_factor);
    }
  };
  hypothesis.logarithm = true;
  hypothesis.unit = "1";
  if (FactorOfTies(facts) > kContradicted) return;  // it is not the control alone
  if (!(facts.residuals.known_square > kTooLarge * facts.residuals.known_redundancy)) return;
  const LogFactors factors = EstimateFactors(facts, Groups::kKnownPoints, trials);
  const double redundancy = factors.known_redundancy;
  hypothesis.value = -factors.known_points;
  if (!factors.fit.solved || !(redundancy >= kLeastRedundancy) || !(hypothesis.value < 0.0)) return;
  hypothesis.log_cost = factors.log_sigmas_known / hypothesis.value;
  hypothesis.says = [redundancy](const Size& size) {
    const double by = 1.0 / size.value;
    return "the standard deviations of the known points are " +
           SizeOf(by, by / std::sqrt(2.0 * redundancy), "").text + " times too small";
  };
  hypothesis.change = [](const Size& size) {
    return "points.csv: the standard deviations of the known points times " +
           InFiles(1.0 / size.value, size.sigma / (size.value * size.value));
  };
  hypothesis.screened = true;
  hypothesis.local = true;
  out->push_back(std::move(hypothesis));
}

namespace {

/// Chance that residuals which are noise show a pattern, all tests of a block together.
constexpr double kPatternLevel = 1e-3;
/// Looks of a pass from which on it is tested.
constexpr std::size_t kFewestLooks = 12;
/// Fourth moment from which on tails are heavy: that of Student's t with nine degrees of freedom.
constexpr double kHeavyTails = 4.2;
/// Median size of a standard normal error, and the part of it that most errors have at least.
constexpr double kMedianOfNormal = 0.6745, kPartOfMedian = 0.4;
/// v'Pv over redundancy of all but the worst points below which these alone are as large as is
/// said: a factor of five, which heavy tails do not make.
constexpr double kSmallWithoutWorst = 0.04;
/// Part of its own error that a residual has to show to be looked at.
constexpr double kShownPart = 0.02;

/// A residual of a look: v in units of its standard deviation times the square root of its
/// redundancy, its weight in a sum of errors, and where it was measured.
struct Residual {
  double v = 0.0, r = 0.0;
  double sigma_m = 0.0;
  double time_s = 0.0, range_m = 0.0;
  [[nodiscard]] double w() const { return v / std::sqrt(r); }
};

struct Found {
  double statistic = 0.0;  ///< standard normal without a pattern
  std::string text;
};

/// sum x v over its standard deviation, x less its weighted mean, and the slope of v/r on x.
struct Trend {
  double statistic = 0.0, slope = 0.0;
};

template <typename Place>
Trend TrendOn(const std::vector<Residual>& residuals, const Place& place) {
  double weight = 0.0, mean = 0.0;
  for (const Residual& r : residuals) {
    weight += r.r;
    mean += r.r * place(r);
  }
  mean /= weight;
  double product = 0.0, square = 0.0;
  for (const Residual& r : residuals) {
    const double x = place(r) - mean;
    product += x * r.v;
    square += x * x * r.r;
  }
  if (!(square > 0.0)) return {};
  return {product / std::sqrt(square), product / square};
}

double MeanSigma_m(const std::vector<Residual>& residuals) {
  double sum = 0.0;
  for (const Residual& r : residuals) sum += r.sigma_m;
  return sum / static_cast<double>(residuals.size());
}

template <typename Place>
double ExtentOf(const std::vector<Residual>& residuals, const Place& place) {
  double least = place(residuals.front()), most = least;
  for (const Residual& r : residuals) {
    least = std::min(least, place(r));
    most = std::max(most, place(r));
  }
  return most - least;
}

std::string Metres(double value_m) { return Digits(std::abs(value_m), 2) + " m"; }

/// Tests of one component of a pass, and what they say of all passes.
constexpr std::size_t kTestsOfPass = 5, kOfNeighbours = 4;
constexpr std::array<const char*, kTestsOfPass> kCommon = {
    "have one sign",
    "have a trend with range",
    "have a trend along the strips",
    "bend along the strips",
    "that follow each other in time are alike: their errors are correlated along the strips"};

/// All tests of one component of one pass.
std::vector<Found> TestsOfPass(std::vector<Residual> residuals, const std::string& who) {
  std::vector<Found> out;
  if (residuals.size() < kFewestLooks) return out;
  std::sort(residuals.begin(), residuals.end(), [](const Residual& a, const Residual& b) {
    return a.time_s < b.time_s;
  });
  const double sigma_m = MeanSigma_m(residuals);
  const auto range = [](const Residual& r) { return r.range_m; };
  const auto time = [](const Residual& r) { return r.time_s; };
  double sum = 0.0, weight = 0.0, neighbours = 0.0, pairs = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    sum += residuals[i].v;
    weight += residuals[i].r;
    if (i == 0) continue;
    // Errors of points do not make looks of one pass alike, since these see different points.
    neighbours +=
        std::clamp(residuals[i - 1].w(), -3.0, 3.0) * std::clamp(residuals[i].w(), -3.0, 3.0);
    pairs += 1.0;
  }
  out.push_back({sum / std::sqrt(weight),
                 "residuals of the " + who + " have one sign, " + Metres(sigma_m * sum / weight) +
                     " in the mean"});
  const Trend by_range = TrendOn(residuals, range);
  out.push_back(
      {by_range.statistic,
       "residuals of the " + who + (by_range.slope > 0.0 ? " rise" : " fall") + " with range, " +
           Metres(sigma_m * by_range.slope * ExtentOf(residuals, range)) + " from near to far"});
  const Trend by_time = TrendOn(residuals, time);
  out.push_back({by_time.statistic,
                 "residuals of the " + who + (by_time.slope > 0.0 ? " rise" : " fall") +
                     " along the strip, " +
                     Metres(sigma_m * by_time.slope * ExtentOf(residuals, time)) +
                     " from its start to its end"});
  const double middle_s = 0.5 * (residuals.front().time_s + residuals.back().time_s);
  const double half_s = 0.5 * (residuals.back().time_s - residuals.front().time_s);
  const auto square = [&](const Residual& r) {
    const double t = (r.time_s - middle_s) / half_s;
    return t * t;
  };
  const Trend by_square = TrendOn(residuals, square);
  out.push_back({by_square.statistic,
                 "residuals of the " + who + " bend along the strip, " +
                     Metres(sigma_m * by_square.slope) + " from its middle to its ends"});
  // Corrections follow the mean and the trend of a pass and leave neighbours unlike.
  out.push_back({neighbours / std::sqrt(pairs),
                 "residuals of the " + who +
                     " that follow each other in time are alike: their "
                     "errors are correlated along the strip"});
  return out;
}

/// One of the tests of all passes together: what all have in common is no matter of one.
struct Pooled {
  double sum = 0.0;
  int passes = 0;
  void Add(double statistic) {
    sum += statistic;
    ++passes;
  }
  [[nodiscard]] double statistic() const { return sum / std::sqrt(std::max(1, passes)); }
};

/// Normal errors have a fourth moment of 3. Tails do not make errors `much_larger` than stated
/// while most of them are as large as is said now.
Found TestOfTails(const std::vector<double>& tests, bool much_larger, const char* who) {
  double fourth = 0.0, second = 0.0;
  for (const double w : tests) {
    second += w * w;
    fourth += w * w * w * w;
  }
  const auto n = static_cast<double>(tests.size());
  const double moment = n * fourth / (second * second);
  std::vector<double> sizes(tests);
  for (double& size : sizes) size = std::abs(size);
  const bool of_most = much_larger && Median(std::move(sizes)) > kPartOfMedian * kMedianOfNormal;
  // All residuals of a point with two looks are one.
  const double shown = moment > kHeavyTails && !of_most ? moment - 3.0 : 0.0;
  return {shown / std::sqrt(48.0 / n),
          std::string("errors of the ") + who + " have heavy tails, a fourth moment of " +
              Digits(moment, 3) + " where noise has 3: blunders, or robust = \"huber\""};
}

}  // namespace

std::string FindPattern(const Block& block,
                        const std::vector<std::uint32_t>& suspects,
                        const SampleResiduals& residuals,
                        bool much_larger) {
  // Points that are in the sample because they are the worst of all are no part of a distribution.
  std::vector<std::uint8_t> chosen(block.looks.size(), 0);
  for (const std::uint32_t point : suspects) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      chosen[i] = 1;
    }
  }
  std::vector<Found> tests;
  for (const Eigen::Index component : {0, 1}) {
    std::vector<std::vector<Residual>> of_pass(block.passes.size());
    std::vector<double> all;
    for (std::size_t i = 0; i < block.looks.size(); ++i) {
      const double v = residuals.whitened_errors(static_cast<Eigen::Index>(i), component);
      const double r = residuals.redundancy(static_cast<Eigen::Index>(i), component);
      if (chosen[i] != 0 || !std::isfinite(v) || !(r > kShownPart)) continue;
      const std::uint32_t pass = block.looks.pass[i];
      const double sigma_m =
          component == 0 ? block.SigmaOf(i).range_m
                         : block.ApproximateAzimuthSigma_m(
                               i, block.passes[pass].path.states().front().velocity_mps.norm());
      of_pass[pass].push_back({v, r, sigma_m, block.looks.time_s[i], block.looks.range_m[i]});
      all.push_back(v / std::sqrt(r));
    }
    const char* word = component == 0 ? "ranges" : "azimuths";
    std::array<Pooled, kTestsOfPass> pooled;
    for (std::size_t pass = 0; pass < of_pass.size(); ++pass) {
      std::vector<Found> found =
          TestsOfPass(std::move(of_pass[pass]), word + (" of " + block.passes[pass].id));
      for (std::size_t k = 0; k < found.size(); ++k) {
        pooled[k].Add(found[k].statistic);
        if (k == kOfNeighbours) found[k].statistic = std::max(0.0, found[k].statistic);
        tests.push_back(std::move(found[k]));
      }
    }
    for (std::size_t k = 0; k < kTestsOfPass; ++k) {
      const double statistic = pooled[k].statistic();
      tests.push_back({k == kOfNeighbours ? std::max(0.0, statistic) : statistic,
                       std::string("residuals of the ") + word + " of all passes " + kCommon[k]});
    }
    if (all.size() >= kFewestLooks) tests.push_back(TestOfTails(all, much_larger, word));
    double square = 0.0;
    for (const double w : all) square += w * w;
    const bool small = square < kSmallWithoutWorst * static_cast<double>(all.size());
    if (!suspects.empty() && all.size() >= kFewestLooks && small) {
      return std::string("errors of the ") + word + " of a few points are much larger than all " +
             "others: blunders";
    }
  }
  if (tests.empty()) return "";
  const double limit =
      NormalQuantile(1.0 - 0.5 * kPatternLevel / static_cast<double>(tests.size()));
  const Found* most = nullptr;
  for (const Found& found : tests) {
    if (!(std::abs(found.statistic) > limit)) continue;
    if (most == nullptr || std::abs(found.statistic) > std::abs(most->statistic)) {
      most = &found;
    }
  }
  return most == nullptr ? "" : most->text;
}

}  // namespace sarblock
