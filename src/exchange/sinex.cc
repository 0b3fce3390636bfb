// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "core/utc.h"
#include "export.h"
#include "files/result_tables.h"
#include "linear/block_cholesky.h"
#include "tables/csv.h"
#include <Eigen/Core>
#include <fmt/core.h>

namespace sarblock {

/// Covariances of the exported points in frame axes.
struct SinexCovariance {
  /// Cross covariance of two different points, by their places in ExportView::points, row > column.
  struct Cross {
    std::size_t row = 0;
    std::size_t column = 0;
    Eigen::Matrix3d covariance_m2;  ///< rows those of `row`
  };
  std::vector<Eigen::Matrix3d> own;
  std::vector<Cross> cross;  ///< sorted by row, then column; empty if not asked for
};

/// The points' own covariances from points.csv and, for the pairs in pairs.csv, the symmetric part
/// of the cross covariance:
///
///     (Q_ab + Q_ab') / 2 = (Q_a + Q_b - cov(b - a)) / 2
///
/// The covariance of a difference determines no more; the difference of the two points has exactly
/// the covariance of the table. Throws InputError if the matrix is then not positive definite,
/// which can happen because covariances of pairs that are not given count as zero.
[[nodiscard]] SinexCovariance FormCovariance(const ExportView& view);

namespace {

Eigen::Matrix3d ToFrame(const Frame& frame, const Eigen::Vector3d& p_m, const SymmetricEnu& c) {
  const Eigen::Matrix3d enu = MatrixOf(c);
  const Eigen::Matrix3d enu_from_frame = frame.EnuFromFrame(p_m);
  const Eigen::Matrix3d turned = enu_from_frame.transpose() * enu * enu_from_frame;
  return 0.5 * (turned + turned.transpose());
}

void RequirePositiveDefinite(const SinexCovariance& covariance) {
  const std::size_t points = covariance.own.size();
  std::vector<std::pair<int, int>> pairs;
  for (const auto& block : covariance.cross) {
    pairs.emplace_back(static_cast<int>(block.row), static_cast<int>(block.column));
  }
  BlockSymmetricMatrix matrix(std::vector<int>(points, 3), std::move(pairs));
  std::vector<Eigen::Vector3d> scale(points);  // to correlations
  for (std::size_t i = 0; i < points; ++i) {
    scale[i] = covariance.own[i].diagonal().cwiseSqrt().cwiseInverse();
    matrix.Block(static_cast<int>(i), static_cast<int>(i)) =
        scale[i].asDiagonal() * covariance.own[i] * scale[i].asDiagonal();
  }
  for (const auto& block : covariance.cross) {
    matrix.Block(static_cast<int>(block.row), static_cast<int>(block.column)) =
        scale[block.row].asDiagonal() * block.covariance_m2 * scale[block.column].asDiagonal();
  }
  BlockCholesky factor(matrix);
  const BlockCholesky::Outcome outcome = factor.Factorize(matrix);
  constexpr double kMinPivot = 1e-13;  // fifteen digits are written
  if (outcome.positive_definite && outcome.smallest_pivot_ratio > kMinPivot) return;
  throw InputError(
      "cross",
      "the covariance with the pairs of pairs.csv is not positive definite, because those of the "
      "other pairs are not given; pairs = \"all\" in the adjustment gives them all, --no-cross "
      "leaves all out");
}

}  // namespace

SinexCovariance FormCovariance(const ExportView& view) {
  const files::ResultFile& result = view.result;
  SinexCovariance covariance;
  std::vector<std::size_t> place(result.points.size(), view.points.size());
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const std::uint32_t point = view.points[i];
    place[point] = i;
    covariance.own.push_back(
        ToFrame(result.frame, view.Position_m(point), view.Covariance_m2(point)));
  }
  if (!view.options.cross_covariances) return covariance;
  for (const PairResult& pair : result.pairs) {
    const std::size_t a = place[pair.a], b = place[pair.b];
    if (a == b || std::max(a, b) == view.points.size() || std::isnan(pair.covariance_m2[0])) {
      continue;
    }
    const Eigen::Matrix3d difference =
        ToFrame(result.frame, view.Position_m(pair.a), pair.covariance_m2);
    covariance.cross.push_back({std::max(a, b),
                                std::min(a, b),
                                0.5 * (covariance.own[a] + covariance.own[b] - difference)});
  }
  const auto key = [](const SinexCovariance::Cross& c) { return std::pair(c.row, c.column); };
  std::stable_sort(covariance.cross.begin(),
                   covariance.cross.end(),
                   [&key](const auto& x, const auto& y) { return key(x) < key(y); });
  covariance.cross.erase(
      std::unique(covariance.cross.begin(),
                  covariance.cross.end(),
                  [&key](const auto& x, const auto& y) { return key(x) == key(y); }),
      covariance.cross.end());
  if (!covariance.cross.empty()) RequirePositiveDefinite(covariance);
  return covariance;
}

namespace {

constexpr std::size_t kMaxEstimates = 99999;  // five digits of an index
constexpr const char* kNoTime = "00:000:00000";

// Years, day of the year and seconds of the day: YY:DDD:SSSSS.
std::string SinexTime(const UtcTime& time) {
  const std::string text = UtcText(time);  // 2022-10-16T01:50:44Z
  const auto number = [&text](std::size_t at, std::size_t digits) {
    return std::atoi(text.substr(at, digits).c_str());
  };
  using std::chrono::sys_days;
  const std::chrono::year year(number(0, 4));
  const sys_days day = year / std::chrono::month(static_cast<unsigned>(number(5, 2))) /
                       std::chrono::day(static_cast<unsigned>(number(8, 2)));
  const auto of_year = (day - sys_days(year / 1 / 1)).count() + 1;
  const int second = number(11, 2) * 3600 + number(14, 2) * 60 + number(17, 2);
  return fmt::format("{:02}:{:03}:{:05}", number(2, 2), of_year, second);
}

struct DataSpan {
  std::string start = kNoTime, end = kNoTime, middle = kNoTime;
};

// From the start of the first strip to the end of the last one; unknown unless every pass has an
// epoch.
DataSpan SpanOf(const files::ResultFile& result) {
  UtcTime first, last;
  bool any = false;
  for (const files::ResultPass& pass : result.passes) {
    const auto epoch = ParseUtc(pass.epoch_utc);
    if (!epoch) return {};
    const UtcTime start = AddSeconds(*epoch, pass.start_s), end = AddSeconds(*epoch, pass.end_s);
    if (!any || SecondsBetween(first, start) < 0.0) first = start;
    if (!any || SecondsBetween(last, end) > 0.0) last = end;
    any = true;
  }
  if (!any) return {};
  const UtcTime middle = AddSeconds(first, 0.5 * SecondsBetween(first, last));
  return {SinexTime(first), SinexTime(last), SinexTime(middle)};
}

// Four characters a site: the ids themselves where they fit, else numbers.
std::vector<std::string> SiteCodes(const ExportView& view) {
  const IdTable& ids = view.result.points.ids;
  const auto fits = [&ids](std::uint32_t point) {
    const std::string_view id = ids[point];
    return id.size() <= 4 && std::all_of(id.begin(), id.end(), [](char c) {
             return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
           });
  };
  const bool own = std::all_of(view.points.begin(), view.points.end(), fits);
  std::vector<std::string> codes;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (own) {
      codes.push_back(fmt::format("{:<4}", ids[view.points[i]]));
    } else if (view.points.size() <= 9999) {
      codes.push_back(fmt::format("{:04}", i + 1));
    } else {  // base 36
      std::string code(4, '0');
      std::size_t rest = i;
      for (auto digit = code.rbegin(); digit != code.rend(); ++digit, rest /= 36) {
        *digit = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"[rest % 36];
      }
      codes.push_back(code);
    }
  }
  return codes;
}

// Printable ASCII of at most `size` characters.
std::string Ascii(std::string_view text, std::size_t size) {
  std::string out(text.substr(0, size));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  return out;
}

// Degrees, minutes and seconds in columns I3, I2, F4.1.
std::string Angle(double degrees) {
  const long tenths = std::lround(std::abs(degrees) * 36000.0);
  return fmt::format("{:>3} {:2} {:4.1f}",
                     fmt::format("{}{}", degrees < 0.0 ? "-" : "", tenths / 36000),
                     tenths / 600 % 60,
                     static_cast<double>(tenths % 600) / 10.0);
}

class SinexWriter {
 public:
  SinexWriter(const std::filesystem::path& file, const ExportView& view)
      : view_(view), out_(file), span_(SpanOf(view.result)), codes_(SiteCodes(view)) {}

  void Head() {
    const auto created = ParseUtc(view_.options.created_utc);
    Add("%=SNX 2.02 {0} {1} {0} {2} {3} C {4:05} 1 S\n",
        view_.options.agency,
        created ? SinexTime(*created) : kNoTime,
        span_.start,
        span_.end,
        3 * view_.points.size());
    Add("*{:-<79}\n", "");
    Add("+FILE/REFERENCE\n");
    Add(" {:<18} {}\n", "DESCRIPTION", Ascii(view_.result.summary.block, 60));
    Add(" {:<18} {}\n", "OUTPUT", "Points of a radar stereo block adjustment");
    Add(" {:<18} sarblock {}\n", "SOFTWARE", Version());
    Add("-FILE/REFERENCE\n");
    const Ellipsoid& ellipsoid = view_.result.frame.ellipsoid();
    Add("+FILE/COMMENT\n"
        " Body-fixed axes of {}, a = {} m, f = {}.\n"
        " Technique C: the format has no code for radar ranges.\n"
        " Points and their site codes: the table .sites.csv next to this file.\n"
        " Standard deviations {} the a-posteriori variance factor.\n"
        "{}{}"
        "-FILE/COMMENT\n",
        Ascii(ellipsoid.name, 20),
        ellipsoid.a_m,
        ellipsoid.flattening,
        view_.result.summary.sigma_scaled_by_posterior ? "are scaled by" : "do not contain",
        " Correlations of different points that are not listed are not known.\n",
        view_.result.realization.empty()
            ? ""
            : fmt::format(" Frame: {}.\n", Ascii(view_.Realization(), 60)));
  }

  void Statistics() {
    const files::ResultSummary& summary = view_.result.summary;
    Add("+SOLUTION/STATISTICS\n");
    Statistic("NUMBER OF OBSERVATIONS", summary.Count("observations"));
    Statistic("NUMBER OF UNKNOWNS", summary.Count("parameters"));
    Statistic("NUMBER OF DEGREES OF FREEDOM", summary.Count("redundancy"));
    // Variance factor of the observations and degrees of freedom above, priors included.
    double factor = summary.sigma0_squared;
    for (const ObservationGroup& group : summary.groups) {
      if (group.name == "all") factor = group.factor();
    }
    Statistic("VARIANCE FACTOR", factor);
    Add("-SOLUTION/STATISTICS\n");
  }

  void Sites() {
    Add("+SITE/ID\n*CODE PT __DOMES__ T _STATION DESCRIPTION__ APPROX_LON_ APPROX_LAT_ _APP_H_\n");
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      const std::uint32_t point = view_.points[i];
      const Geodetic place = view_.result.frame.GeodeticFromFrame(view_.Position_m(point));
      const double turn = 2.0 * std::numbers::pi;
      const double lon_rad = place.lon_rad < 0.0 ? place.lon_rad + turn : place.lon_rad;
      Add(" {}  A --------- C {:<22} {} {} {:7.1f}\n",
          codes_[i],
          Ascii(view_.result.points.ids[point], 22),
          Angle(lon_rad * kDegPerRad),
          Angle(place.lat_rad * kDegPerRad),
          place.h_m);
      FlushIfLong();
    }
    Add("-SITE/ID\n+SOLUTION/EPOCHS\n*CODE PT SOLN T _DATA_START_ __DATA_END__ _MEAN_EPOCH_\n");
    for (const std::string& code : codes_) {
      Add(" {}  A    1 C {} {} {}\n", code, span_.start, span_.end, span_.middle);
      FlushIfLong();
    }
    Add("-SOLUTION/EPOCHS\n");
  }

  void Estimates(const SinexCovariance& covariance) {
    Add("+SOLUTION/ESTIMATE\n"
        "*INDEX TYPE__ CODE PT SOLN _REF_EPOCH__ UNIT S __ESTIMATED VALUE____ _STD_DEV___\n");
    const double epoch_year = view_.result.epoch_year;
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      const Eigen::Vector3d& p_m = view_.Position_m(view_.points[i]);
      for (Eigen::Index k = 0; k < 3; ++k) {
        Add(" {:5} STA{}   {}  A    1 {} m    1 {:21.14E} {:11.5E}\n",
            3 * i + static_cast<std::size_t>(k) + 1,
            "XYZ"[k],
            codes_[i],
            std::isnan(epoch_year) ? span_.middle : SinexTime(TimeOfJulianYear(epoch_year)),
            p_m[k],
            std::sqrt(covariance.own[i](k, k)));
      }
      FlushIfLong();
    }
    Add("-SOLUTION/ESTIMATE\n");
  }

  void Matrix(const SinexCovariance& covariance) {
    Add("+SOLUTION/MATRIX_ESTIMATE L COVA\n"
        "*PARA1 PARA2 ____PARA2+0__________ ____PARA2+1__________ ____PARA2+2__________\n");
    auto cross = covariance.cross.begin();  // sorted by row, then column
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      const auto first = cross;
      while (cross != covariance.cross.end() && cross->row == i) ++cross;
      for (Eigen::Index k = 0; k < 3; ++k) {
        for (auto block = first; block != cross; ++block) {
          Row(i, k, block->column, block->covariance_m2, 3);
        }
        Row(i, k, i, covariance.own[i], k + 1);
      }
    }
    Add("-SOLUTION/MATRIX_ESTIMATE L COVA\n");
  }

  void Finish() {
    Add("%ENDSNX\n");
    out_.Write(text_);
    out_.Commit();
  }

  [[nodiscard]] const std::vector<std::string>& codes() const { return codes_; }
  [[nodiscard]] bool has_time() const { return span_.start != kNoTime; }

 private:
  template <typename... Values>
  void Add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  void FlushIfLong() {
    constexpr std::size_t kLong = 1 << 16;
    if (text_.size() < kLong) return;
    out_.Write(text_);
    text_.clear();
  }
  void Statistic(const char* name, double value) {
    if (std::isfinite(value)) Add(" {:<30} {:22.15f}\n", name, value);
  }
  // Elements (3 row + k, 3 column + 0 ... count - 1).
  void Row(std::size_t row,
           Eigen::Index k,
           std::size_t column,
           const Eigen::Matrix3d& block_m2,
           Eigen::Index count) {
    Add(" {:5} {:5}", 3 * row + static_cast<std::size_t>(k) + 1, 3 * column + 1);
    for (Eigen::Index l = 0; l < count; ++l) Add(" {:21.14E}", block_m2(k, l));
    text_ += '\n';
    FlushIfLong();
  }

  const ExportView& view_;
  AtomicFile out_;
  DataSpan span_;
  std::vector<std::string> codes_;
  std::string text_;
};

void CheckOptions(const ExportView& view) {
  const std::string& agency = view.options.agency;
  const bool good = agency.size() == 3 && std::all_of(agency.begin(), agency.end(), [](char c) {
                      return std::isalnum(static_cast<unsigned char>(c)) != 0;
                    });
  if (!good) {
    throw InputError("agency", "must be three letters or digits, got '" + agency + "'");
  }
  if (view.points.empty()) throw InputError("format", "the result has no solved point to write");
  if (3 * view.points.size() > kMaxEstimates) {
    throw InputError("format",
                     "SINEX counts " + std::to_string(kMaxEstimates) +
                         " estimates at most, these points have " +
                         std::to_string(3 * view.points.size()));
  }
  for (const std::uint32_t point : view.points) {
    if (view.HasCovariance(point)) continue;
    throw InputError(
        "format",
        "SINEX holds a covariance, and point '" + std::string(view.result.points.ids[point]) +
            "' of this result has none (covariance = \"" + view.result.summary.covariance + "\")");
  }
}

void WriteSites(const std::filesystem::path& file,
                const ExportView& view,
                const std::vector<std::string>& codes) {
  constexpr Columns kColumns{{
      {"code", ColumnNeed::kRequired, CellKind::kText},
      {"point", ColumnNeed::kRequired, CellKind::kPoint},
      {"role", ColumnNeed::kRequired, CellKind::kText},
  }};
  const auto table = WriteCsv(file, kColumns);
  WriteEach(codes.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const std::uint32_t point = view.points[i];
    NewRow(batch)
        .Text(kColumns("code"), codes[i].substr(0, codes[i].find(' ')))
        .Id(kColumns("point"), view.result.points.ids, point)
        .Text(kColumns("role"), files::NameOf(view.result.points.role[point]));
  });
  table->Commit();
}

}  // namespace

std::filesystem::path SitesOf(std::filesystem::path sinex) {
  return sinex.replace_extension(".sites.csv");
}

void WriteSinex(const std::filesystem::path& file, const ExportView& view, ExportReport* report) {
  CheckOptions(view);
  const SinexCovariance covariance = FormCovariance(view);
  SinexWriter writer(file, view);
  writer.Head();
  writer.Statistics();
  writer.Sites();
  writer.Estimates(covariance);
  writer.Matrix(covariance);
  const std::filesystem::path sites = SitesOf(file);
  WriteSites(sites, view, writer.codes());
  writer.Finish();
  report->files = {file, sites};
  if (!view.result.parameters.empty()) {
    report->not_carried.emplace_back("parameters of passes and their covariances with the points");
  }
  report->not_carried.emplace_back(
      covariance.cross.empty() ? "covariances between points"
                               : "antisymmetric parts of covariances between points, and those of "
                                 "pairs that pairs.csv does not have");
  if (!writer.has_time()) {
    report->warnings.push_back("not every pass has an epoch in UTC: times are " +
                               std::string(kNoTime) + ", unknown");
  }
  if (covariance.cross.empty() && view.points.size() > 1) {
    report->warnings.push_back(
        "the matrix has the points' own covariances only; with pairs = \"all\" the result would "
        "have those between points too");
  }
}

}  // namespace sarblock
