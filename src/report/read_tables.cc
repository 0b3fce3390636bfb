// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "io/csv_reader.h"
#include "io/table_file.h"
#include "read_summary.h"
#include "result_folder.h"
#include "statistics.h"

namespace sarblock {
namespace {

constexpr std::size_t kStepRows = 100000;
constexpr std::size_t kMostCorrelations = 40;

/// A table of the folder, or nothing.
class Tables {
 public:
  Tables(const std::filesystem::path& folder, ProgressSink* progress)
      : folder_(folder), progress_(progress) {}

  /// Calls `row` for every row of a table that is there.
  template <typename Row>
  void ForEach(const char* name, std::span<const CsvColumn> columns, const Row& row) const {
    const auto file = FindTable(folder_, name);
    if (!file) return;
    CsvReader reader(*file, columns);
    for (std::size_t n = 0; reader.Next(); ++n) {
      if (n % kStepRows == 0) Step(progress_, "read", n, 0, name);
      row(reader);
    }
  }

 private:
  const std::filesystem::path& folder_;
  ProgressSink* progress_;
};

std::array<double, 3> Triple(const CsvReader& reader, std::size_t column) {
  return {reader.Number(column), reader.Number(column + 1), reader.Number(column + 2)};
}

std::array<float, 3> FloatTriple(const CsvReader& reader, std::size_t column) {
  const std::array<double, 3> v = Triple(reader, column);
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

float FloatAt(const CsvReader& reader, std::size_t column) {
  return static_cast<float>(reader.Number(column));
}

void ReadPoints(const Tables& tables, ReportPoints* out) {
  static constexpr CsvNeed kRequired = CsvNeed::kRequired;
  const std::vector<CsvColumn> columns{{"point", kRequired},
                                       {"role", kRequired},
                                       {"status", kRequired},
                                       {"looks"},
                                       {"x_m", kRequired},  // 4
                                       {"y_m", kRequired},
                                       {"z_m", kRequired},
                                       {"sigma_e_m"},  // 7
                                       {"sigma_n_m"},
                                       {"sigma_u_m"},
                                       {"cov_en_m2"},  // 10
                                       {"sigma_held_e_m"},
                                       {"sigma_held_n_m"},
                                       {"sigma_held_u_m"},
                                       {"cov_held_en_m2"},  // 14
                                       {"sigma_leberl_across_m"},
                                       {"sigma_leberl_up_m"},
                                       {"sigma_leberl_path_across_m"},
                                       {"sigma_leberl_path_up_m"},
                                       {"leberl_across_azimuth_deg"},  // 19
                                       {"intersection_deg"},
                                       {"redundancy"},
                                       {"error_e_m"},  // 22
                                       {"error_n_m"},
                                       {"error_u_m"},
                                       {"error_sigma_e_m"},  // 25
                                       {"error_sigma_n_m"},
                                       {"error_sigma_u_m"},
                                       {"chi_square_3"},  // 28
                                       {"reason"}};
  tables.ForEach("points", columns, [&](const CsvReader& row) {
    const std::uint32_t point = out->ids.Append(row.Id(0));
    const std::string_view role = row.Text(1), status = row.Text(2);
    out->role.push_back(role == "control"
                            ? ReportRole::kControl
                            : (role == "check" ? ReportRole::kCheck : ReportRole::kTie));
    const bool solved = status == "adjusted" || status == "intersected" || status == "predicted";
    out->solved.push_back(solved ? 1 : 0);
    if (!solved) {
      ++out->unsolved_count;
      if (out->unsolved.size() < ReportPoints::kMostUnsolved) {
        out->unsolved.push_back({point, std::string(status), std::string(row.Text(29))});
      }
    }
    const double looks = row.Number(3);
    out->looks.push_back(std::isnan(looks)
                             ? std::uint16_t{0}
                             : static_cast<std::uint16_t>(std::clamp(looks, 0.0, 65535.0)));
    out->position_m.push_back(Triple(row, 4));
    out->sigma_m.push_back(FloatTriple(row, 7));
    out->cov_en_m2.push_back(FloatAt(row, 10));
    out->sigma_held_m.push_back(FloatTriple(row, 11));
    out->cov_held_en_m2.push_back(FloatAt(row, 14));
    out->leberl_m.push_back(
        {FloatAt(row, 15), FloatAt(row, 16), FloatAt(row, 17), FloatAt(row, 18)});
    out->leberl_azimuth_deg.push_back(FloatAt(row, 19));
    out->intersection_deg.push_back(FloatAt(row, 20));
    out->redundancy.push_back(FloatAt(row, 21));
    if (row.Given(22) || row.Given(23) || row.Given(24)) {
      out->checks.push_back({point, Triple(row, 22), Triple(row, 25), row.Number(28)});
    }
  });
}

using ParameterIndex = std::map<std::pair<std::string, std::string>, std::uint32_t, std::less<>>;

void ReadParameters(const Tables& tables, ResultFolder* out) {
  const std::vector<CsvColumn> columns{{"pass", CsvNeed::kRequired},
                                       {"parameter", CsvNeed::kRequired},
                                       {"unit"},
                                       {"value", CsvNeed::kRequired},
                                       {"sigma"},
                                       {"prior_sigma"},
                                       {"significance"},
                                       {"kept"}};
  tables.ForEach("passes", columns, [&](const CsvReader& row) {
    ReportParameter p;
    p.pass = row.Id(0);
    p.name = row.Id(1);
    p.unit = row.Text(2);
    p.value = row.RequiredNumber(3);
    p.sigma = row.Number(4);
    p.prior_sigma = row.Number(5);
    p.significance = row.Number(6);
    p.kept = row.Text(7);
    out->parameters.push_back(std::move(p));
  });
}

void ReadCorrelations(const Tables& tables, ResultFolder* out) {
  ParameterIndex index;
  for (std::uint32_t i = 0; i < out->parameters.size(); ++i) {
    index[{out->parameters[i].pass, out->parameters[i].name}] = i;
  }
  const std::vector<CsvColumn> columns{{"pass_a", CsvNeed::kRequired},
                                       {"parameter_a", CsvNeed::kRequired},
                                       {"pass_b", CsvNeed::kRequired},
                                       {"parameter_b", CsvNeed::kRequired},
                                       {"covariance", CsvNeed::kRequired}};
  std::vector<ReportCorrelation>& list = out->correlations;
  const auto larger = [](const ReportCorrelation& a, const ReportCorrelation& b) {
    return std::abs(a.correlation_1) > std::abs(b.correlation_1);
  };
  // Rows come sorted by their first parameter: remember it rather than look it up each time.
  std::pair<std::string, std::string> key_a, key_b;
  std::uint32_t a = 0;
  bool known_a = false;
  tables.ForEach("passes_covariance", columns, [&](const CsvReader& row) {
    if (!known_a || row.Text(0) != key_a.first || row.Text(1) != key_a.second) {
      key_a = {std::string(row.Text(0)), std::string(row.Text(1))};
      const auto found = index.find(key_a);
      known_a = found != index.end();
      if (known_a) a = found->second;
    }
    key_b = {std::string(row.Text(2)), std::string(row.Text(3))};
    const auto found = index.find(key_b);
    if (!known_a || found == index.end() || found->second == a) return;
    const double scale = out->parameters[a].sigma * out->parameters[found->second].sigma;
    const double correlation = row.Number(4) / scale;
    if (!(std::abs(correlation) > kHighCorrelation_1)) return;
    ++out->correlation_count;
    list.push_back({a, found->second, correlation});
    std::push_heap(list.begin(), list.end(), larger);
    if (list.size() > kMostCorrelations) {
      std::pop_heap(list.begin(), list.end(), larger);
      list.pop_back();
    }
  });
  std::sort(list.begin(), list.end(), larger);
}

/// Keeps the looks with the largest `size`.
class LargestLooks {
 public:
  explicit LargestLooks(std::vector<ReportLook>* list) : list_(list) {}
  [[nodiscard]] bool Takes(double size) const {
    return !std::isnan(size) &&
           (heap_.size() < ReportLooks::kMostWorst || size > heap_.front().first);
  }
  void Add(double size, ReportLook look) {
    heap_.emplace_back(size, std::move(look));
    std::push_heap(heap_.begin(), heap_.end(), &Larger);
    if (heap_.size() > ReportLooks::kMostWorst) {
      std::pop_heap(heap_.begin(), heap_.end(), &Larger);
      heap_.pop_back();
    }
  }
  void Finish() {
    std::sort_heap(heap_.begin(), heap_.end(), &Larger);
    for (auto& [size, look] : heap_) list_->push_back(std::move(look));
  }

 private:
  using Entry = std::pair<double, ReportLook>;
  static bool Larger(const Entry& a, const Entry& b) { return a.first > b.first; }
  std::vector<Entry> heap_;
  std::vector<ReportLook>* list_;
};

void ReadLooks(const Tables& tables, ReportLooks* out) {
  const std::vector<CsvColumn> columns{{"pass", CsvNeed::kRequired},
                                       {"point", CsvNeed::kRequired},
                                       {"range_residual_m"},
                                       {"azimuth_residual_m"},
                                       {"range_redundancy"},
                                       {"azimuth_redundancy"},
                                       {"range_w"},
                                       {"azimuth_w"},
                                       {"range_tau"},
                                       {"azimuth_tau"},
                                       {"range_mdb_m"},
                                       {"azimuth_mdb_m"},
                                       {"range_influence_m"},
                                       {"azimuth_influence_m"},
                                       {"weight"},
                                       {"rejected"},
                                       {"reason"}};
  LargestLooks worst(&out->worst), left_out(&out->left_out);
  std::map<std::string, std::size_t> by_reason;
  tables.ForEach("residuals", columns, [&](const CsvReader& row) {
    ++out->count;
    const bool rejected = row.Text(15) == "1";
    if (rejected) {
      ++out->rejected;
      ++by_reason[row.Given(16) ? std::string(row.Text(16)) : "given"];
    }
    const auto look = [&](std::size_t k) {
      ReportLook l;
      l.pass = row.Text(0);
      l.point = row.Text(1);
      l.reason = row.Text(16);
      l.azimuth = k == 1;
      l.residual_m = row.Number(2 + k);
      l.redundancy = row.Number(4 + k);
      l.w_1 = row.Number(6 + k);
      l.tau_1 = row.Number(8 + k);
      l.mdb_m = row.Number(10 + k);
      l.influence_m = row.Number(12 + k);
      l.weight = row.Number(14);
      l.rejected = rejected;
      return l;
    };
    if (rejected) {
      const double range_m = std::abs(row.Number(2)), azimuth_m = std::abs(row.Number(3));
      const double size_m = std::fmax(range_m, azimuth_m);
      if (left_out.Takes(size_m)) left_out.Add(size_m, look(azimuth_m > range_m ? 1 : 0));
      return;
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (row.Given(2 + k)) out->residual_m[k].push_back(FloatAt(row, 2 + k));
      if (row.Given(4 + k)) out->redundancy_1[k].push_back(FloatAt(row, 4 + k));
      if (row.Given(10 + k)) out->mdb_m[k].push_back(FloatAt(row, 10 + k));
      if (row.Given(12 + k)) out->influence_m[k].push_back(FloatAt(row, 12 + k));
      if (!row.Given(6 + k)) continue;
      const double w = row.Number(6 + k);
      out->w_1[k].push_back(static_cast<float>(w));
      if (worst.Takes(std::abs(w))) worst.Add(std::abs(w), look(k));
    }
  });
  worst.Finish();
  left_out.Finish();
  out->rejected_by_reason.assign(by_reason.begin(), by_reason.end());
}

void ReadControl(const Tables& tables, std::vector<ReportControl>* out) {
  const std::vector<CsvColumn> columns{{"point", CsvNeed::kRequired},
                                       {"component", CsvNeed::kRequired},
                                       {"residual_m"},
                                       {"sigma_m"},
                                       {"redundancy"},
                                       {"w"},
                                       {"mdb_m"},
                                       {"influence_m"}};
  tables.ForEach("control_quality", columns, [&](const CsvReader& row) {
    ReportControl c;
    c.point = row.Id(0);
    c.component = row.Text(1) == "e" ? 0 : (row.Text(1) == "n" ? 1 : 2);
    c.residual_m = row.Number(2);
    c.sigma_m = row.Number(3);
    c.redundancy = row.Number(4);
    c.w_1 = row.Number(5);
    c.mdb_m = row.Number(6);
    c.influence_m = row.Number(7);
    out->push_back(std::move(c));
  });
}

void ReadStrips(const Tables& tables, std::vector<ReportStrip>* out) {
  const std::vector<CsvColumn> columns{{"pass", CsvNeed::kRequired},
                                       {"look"},
                                       {"time_s", CsvNeed::kRequired},
                                       {"strip_time", CsvNeed::kRequired},
                                       {"x_m", CsvNeed::kRequired},  // 4
                                       {"y_m", CsvNeed::kRequired},
                                       {"z_m", CsvNeed::kRequired},
                                       {"near_x_m"},  // 7
                                       {"near_y_m"},
                                       {"near_z_m"},
                                       {"far_x_m"},  // 10
                                       {"far_y_m"},
                                       {"far_z_m"},
                                       {"correction_along_m"},  // 13
                                       {"correction_across_m"},
                                       {"correction_up_m"},
                                       {"sigma_along_m"},  // 16
                                       {"sigma_across_m"},
                                       {"sigma_up_m"}};
  tables.ForEach("strips", columns, [&](const CsvReader& row) {
    if (out->empty() || out->back().pass != row.Id(0)) {
      out->emplace_back();
      out->back().pass = row.Id(0);
      out->back().left = row.Text(1) != "right";
    }
    ReportStrip& strip = out->back();
    strip.time_s.push_back(row.RequiredNumber(2));
    strip.strip_time_1.push_back(row.RequiredNumber(3));
    strip.antenna_m.push_back(Triple(row, 4));
    strip.near_m.push_back(Triple(row, 7));
    strip.far_m.push_back(Triple(row, 10));
    strip.correction_m.push_back(Triple(row, 13));
    strip.correction_sigma_m.push_back(Triple(row, 16));
  });
}

void ReadPairs(const Tables& tables, ReportPairs* out) {
  const std::vector<CsvColumn> columns{{"cov_ee_m2"},
                                       {"cov_nn_m2"},
                                       {"cov_uu_m2"},
                                       {"sigma_leberl_across_m"},
                                       {"sigma_leberl_up_m"}};
  std::array<std::vector<double>, 5> values;
  tables.ForEach("pairs", columns, [&](const CsvReader& row) {
    ++out->count;
    for (std::size_t k = 0; k < 5; ++k) {
      const double value = row.Number(k);
      values[k].push_back(k < 3 ? std::sqrt(value) : value);
    }
  });
  for (std::size_t k = 0; k < 3; ++k) {
    out->median_sigma_m[k] = SampleQuantile(std::move(values[k]), 0.5);
  }
  out->median_leberl_across_m = SampleQuantile(std::move(values[3]), 0.5);
  out->median_leberl_up_m = SampleQuantile(std::move(values[4]), 0.5);
}

void ReadSelection(const Tables& tables, ResultFolder* out) {
  const std::vector<CsvColumn> candidates{{"candidate", CsvNeed::kRequired},
                                          {"passes"},
                                          {"parameters"},
                                          {"test"},
                                          {"f"},
                                          {"p"},
                                          {"delta_bic"},
                                          {"condition"},
                                          {"verdict"},
                                          {"reason"}};
  tables.ForEach("selection", candidates, [&](const CsvReader& row) {
    ReportCandidate c;
    c.name = row.Id(0);
    c.passes = row.Text(1);
    c.parameters_1 = row.Number(2);
    c.test = row.Text(3);
    c.f_1 = row.Number(4);
    c.probability_1 = row.Number(5);
    c.delta_bic_1 = row.Number(6);
    c.condition = row.Number(7);
    c.verdict = row.Text(8);
    c.reason = row.Text(9);
    out->candidates.push_back(std::move(c));
  });
  const std::vector<CsvColumn> simplifications{
      {"simplification", CsvNeed::kRequired}, {"bound_m"}, {"sigma_m"}, {"fraction"}, {"verdict"}};
  tables.ForEach("simplifications", simplifications, [&](const CsvReader& row) {
    out->simplifications.push_back({std::string(row.Id(0)),
                                    row.Number(1),
                                    row.Number(2),
                                    row.Number(3),
                                    std::string(row.Text(4))});
  });
}

}  // namespace

ResultFolder ReadResultFolder(const std::filesystem::path& folder, ProgressSink* progress) {
  ResultFolder out;
  out.path = folder.string();
  out.summary = ReadSummary(folder / "summary.json");
  const Tables tables(folder, progress);
  ReadPoints(tables, &out.points);
  ReadParameters(tables, &out);
  ReadCorrelations(tables, &out);
  ReadLooks(tables, &out.looks);
  ReadControl(tables, &out.control);
  ReadStrips(tables, &out.strips);
  ReadPairs(tables, &out.pairs);
  ReadSelection(tables, &out);
  return out;
}

}  // namespace sarblock
