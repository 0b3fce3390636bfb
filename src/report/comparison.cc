// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "page.h"
#include "result_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

using Key = std::pair<std::string, std::string>;

double Larger(double a, double b) { return std::fmax(a, b); }

void ComparePoints(const ResultFolder& a, const ResultFolder& b, ResultDifference* out) {
  const files::ResultPoints &pa = a.file.points, &pb = b.file.points;
  std::size_t matched = 0;
  for (std::uint32_t i = 0; i < pa.size(); ++i) {
    if (!IsSolved(pa.results.status[i])) continue;
    const std::uint32_t j = pb.ids.Find(pa.ids[i]);
    if (j == IdTable::kNone || !IsSolved(pb.results.status[j])) {
      ++out->only_in_a;
      continue;
    }
    ++matched;
    ResultDifference::Point point;
    point.a = i;
    point.b = j;
    const Eigen::Vector3d& from_m = pa.results.position_m[i];
    const Eigen::Vector3d shift =
        a.file.frame.EnuFromFrame(from_m) * (pb.results.position_m[j] - from_m);
    point.shift_length_m = shift.norm();
    for (std::size_t k = 0; k < 3; ++k) {
      point.shift_m[k] = shift[static_cast<Eigen::Index>(k)];
      const double sa = SigmaOf(pa, i, k), sb = SigmaOf(pb, j, k);
      point.sigma_ratio[k] = sb / sa;
      point.shift_sigmas = Larger(point.shift_sigmas, std::abs(point.shift_m[k]) / Larger(sa, sb));
    }
    out->common.push_back(point);
  }
  out->only_in_b = pb.size() - b.unsolved.size() - matched;
}

void CompareParameters(const std::vector<ParameterResult>& a,
                       const std::vector<ParameterResult>& b,
                       ResultDifference* out) {
  std::map<Key, std::uint32_t> of_b;
  for (std::uint32_t j = 0; j < b.size(); ++j) {
    of_b[{b[j].owner, b[j].name}] = j;
  }
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const auto found = of_b.find({a[i].owner, a[i].name});
    if (found == of_b.end()) {
      ++out->parameters_only_in_a;
      continue;
    }
    ResultDifference::Parameter parameter;
    parameter.a = i;
    parameter.b = found->second;
    parameter.change = b[found->second].value - a[i].value;
    parameter.change_sigmas =
        std::abs(parameter.change) / Larger(a[i].sigma, b[found->second].sigma);
    out->parameters.push_back(parameter);
  }
  out->parameters_only_in_b = b.size() - out->parameters.size();
}

void CompareSettings(const files::ResultSummary& a,
                     const files::ResultSummary& b,
                     ResultDifference* out) {
  std::map<std::string, std::array<std::string, 2>> values;
  for (const auto& [key, value] : a.configuration) values[key][0] = value;
  for (const auto& [key, value] : b.configuration) values[key][1] = value;
  for (const auto& [key, value] : values) {
    if (value[0] != value[1]) out->settings.push_back({key, value[0], value[1]});
  }
  std::map<std::string, std::array<std::string, 2>> files;
  for (const files::InputFile& input : a.inputs) files[input.name][0] = input.sha256;
  for (const files::InputFile& input : b.inputs) files[input.name][1] = input.sha256;
  for (const auto& [name, sums] : files) {
    if (sums[0] != sums[1]) out->inputs.push_back(name);
  }
}

}  // namespace

ResultDifference CompareResults(const ResultFolder& a, const ResultFolder& b) {
  ResultDifference out;
  ComparePoints(a, b, &out);
  CompareParameters(a.file.parameters, b.file.parameters, &out);
  CompareSettings(a.file.summary, b.file.summary, &out);
  return out;
}

namespace {

constexpr std::size_t kMaxChangedRows = 300;
constexpr std::size_t kMaxComparedDots = 3000;

struct Side {
  const ResultFolder& result;
  AccuracyFigures accuracy;
  Headline headline;
  explicit Side(const ResultFolder& folder)
      : result(folder),
        accuracy(DescribeAccuracy(folder)),
        headline(HeadlineOf(folder, accuracy)) {}
};

std::string Ratio(double a, double b) {
  const double ratio = b / a;
  return std::isfinite(ratio) ? Shown(ratio, 3) : "-";
}

PageTable FigureTable(const Side& a, const Side& b) {
  PageTable table;
  table.plain = true;
  table.columns = {{"", false}, {"A", true}, {"B", true}, {"B over A", true}};
  const auto text = [&](const std::string& name, const std::string& va, const std::string& vb) {
    if (va != vb) table.marked.push_back(table.rows.size());
    table.rows.push_back({name, va, vb, ""});
  };
  const auto number = [&](const std::string& name, double va, double vb) {
    table.rows.push_back({name, Shown(va), Shown(vb), Ratio(va, vb)});
  };
  const files::ResultSummary& sa = a.result.file.summary;
  const files::ResultSummary& sb = b.result.file.summary;
  text("verdict", a.headline.word, b.headline.word);
  text("command", sa.command, sb.command);
  text("block", sa.block, sb.block);
  text("version", sa.version, sb.version);
  const auto count = [&](const std::string& name, double va, double vb) {
    table.rows.push_back({name, ReadableCount(va), ReadableCount(vb), Ratio(va, vb)});
  };
  for (const char* key :
       {"passes", "points", "looks_used", "observations", "parameters", "redundancy"}) {
    std::string label = key;
    std::replace(label.begin(), label.end(), '_', ' ');
    count(label, sa.Count(key), sb.Count(key));
  }
  number("variance factor", sa.sigma0_squared, sb.sigma0_squared);
  number("condition", sa.condition, sb.condition);
  const std::array<const char*, 3> axes = AxisNames(a.result.file.frame);
  for (std::size_t k = 0; k < 3; ++k) {
    number(fmt::format("median sigma {} [m]", axes[k]),
           a.accuracy.median_m[k],
           b.accuracy.median_m[k]);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    number(fmt::format("largest sigma {} [m]", axes[k]),
           a.accuracy.largest_m[k],
           b.accuracy.largest_m[k]);
  }
  if (sa.checks && sb.checks) {
    number("check points, error over sigma", sa.checks->error_ratio, sb.checks->error_ratio);
  }
  const auto above = [](const files::ResultSummary& s) {
    return s.tests ? static_cast<double>(s.tests->above_all()) : kAbsent;
  };
  count("observations beyond the critical value", above(sa), above(sb));
  count("looks left out",
        static_cast<double>(a.result.looks.rejected),
        static_cast<double>(b.result.looks.rejected));
  double time_a = 0.0, time_b = 0.0;
  for (const StageCost& stage : sa.stages) time_a += stage.wall_s;
  for (const StageCost& stage : sb.stages) time_b += stage.wall_s;
  number("wall time [s]", time_a, time_b);
  return table;
}

PageSection SettingSection(const ResultDifference& difference) {
  PageSection section{"settings", "Inputs and settings that differ", {}};
  if (difference.inputs.empty()) {
    section.items.emplace_back(PageText{"No input file is known to differ.", ""});
  } else {
    std::string names;
    for (const std::string& name : difference.inputs) names += (names.empty() ? "" : ", ") + name;
    section.items.emplace_back(PageText{"Input files that differ: " + names + ".", ""});
  }
  if (difference.settings.empty()) {
    section.items.emplace_back(PageText{"The configurations are the same.", ""});
    return section;
  }
  PageTable table;
  table.columns = {{"key", false}, {"A", false}, {"B", false}};
  for (const auto& [key, va, vb] : difference.settings) table.rows.push_back({key, va, vb});
  section.items.emplace_back(std::move(table));
  return section;
}

struct Shift {
  std::vector<double> sigmas, length_m;
  std::array<std::vector<double>, 3> ratio;
};

Shift ShiftsOf(const ResultDifference& difference) {
  Shift out;
  for (const ResultDifference::Point& point : difference.common) {
    out.sigmas.push_back(point.shift_sigmas);
    out.length_m.push_back(point.shift_length_m);
    for (std::size_t k = 0; k < 3; ++k) out.ratio[k].push_back(point.sigma_ratio[k]);
  }
  return out;
}

PageFigure SigmaFigure(const ResultDifference& difference,
                       const Side& a,
                       const Side& b,
                       std::size_t k) {
  XyChart chart;
  chart.x = {"sigma in A [m]", true, kAbsent, kAbsent};
  chart.y = {"sigma in B [m]", true, kAbsent, kAbsent};
  ChartSeries dots{"points", "points", "blue", {}, {}, {}, {}, {}};
  double low = kAbsent, high = kAbsent;
  for (const std::uint32_t n : SampleIndices(difference.common.size(), kMaxComparedDots)) {
    const ResultDifference::Point& point = difference.common[n];
    const double x = SigmaOf(a.result.file.points, point.a, k);
    const double y = SigmaOf(b.result.file.points, point.b, k);
    if (!(x > 0.0) || !(y > 0.0)) continue;
    dots.x.push_back(x);
    dots.y.push_back(y);
    dots.names.emplace_back(a.result.file.points.ids[point.a]);
    low = std::fmin(low, std::fmin(x, y));
    high = std::fmax(high, std::fmax(x, y));
  }
  ChartSeries line{"equal", "line", "ink", {low, high}, {low, high}, {}, {}, {}};
  chart.series = {line, dots};
  const std::string id = fmt::format("sigma-{}", k);
  return {id,
          fmt::format("Sigma {}", AxisNames(a.result.file.frame)[k]),
          "",
          "third",
          ChartJson(id, chart)};
}

PageSection PointSection(const ResultDifference& difference, const Side& a, const Side& b) {
  PageSection section{"points", "Points", {}};
  section.items.emplace_back(
      PageText{fmt::format("{} points are solved in both, {} only in A, {} only in B.",
                           ReadableCount(static_cast<double>(difference.common.size())),
                           ReadableCount(static_cast<double>(difference.only_in_a)),
                           ReadableCount(static_cast<double>(difference.only_in_b))),
               ""});
  if (difference.common.empty()) return section;
  const Shift shift = ShiftsOf(difference);
  constexpr std::array kParts{0.5, 0.95, 1.0};
  const auto row = [&](const std::string& name, const std::vector<double>& values) {
    std::vector<std::string> cells{name};
    for (const double v : SampleQuantiles(values, kParts)) cells.push_back(Shown(v, 3));
    return cells;
  };
  PageTable table;
  table.columns = {{"", false}, {"median", true}, {"95 %", true}, {"largest", true}};
  const std::array<const char*, 3> axes = AxisNames(a.result.file.frame);
  table.rows.push_back(row("shift [m]", shift.length_m));
  table.rows.push_back(row("largest component of the shift [sigma]", shift.sigmas));
  for (std::size_t k = 0; k < 3; ++k) {
    table.rows.push_back(row(fmt::format("sigma {}, B over A", axes[k]), shift.ratio[k]));
  }
  section.items.emplace_back(std::move(table));
  if (a.accuracy.points > 0 && b.accuracy.points > 0) {
    PageFigures figures;
    for (std::size_t k = 0; k < 3; ++k) figures.figures.push_back(SigmaFigure(difference, a, b, k));
    section.items.emplace_back(std::move(figures));
  }
  std::vector<const ResultDifference::Point*> order;
  for (const auto& point : difference.common) order.push_back(&point);
  std::stable_sort(order.begin(), order.end(), [](const auto* x, const auto* y) {
    return x->shift_length_m > y->shift_length_m;
  });
  PageTable moved;
  moved.title = "Points that moved most";
  moved.columns = {{"point", false},
                   {std::string("shift ") + axes[0] + " [m]", true},
                   {std::string("shift ") + axes[1] + " [m]", true},
                   {std::string("shift ") + axes[2] + " [m]", true},
                   {"largest component [sigma]", true}};
  for (std::size_t i = 0; i < std::min(order.size(), kMaxChangedRows); ++i) {
    const ResultDifference::Point& point = *order[i];
    moved.rows.push_back({std::string(a.result.file.points.ids[point.a]),
                          Shown(point.shift_m[0], 3),
                          Shown(point.shift_m[1], 3),
                          Shown(point.shift_m[2], 3),
                          Shown(point.shift_sigmas, 3)});
  }
  section.items.emplace_back(std::move(moved));
  return section;
}

PageSection ParameterSection(const ResultDifference& difference, const Side& a) {
  PageSection section{"corrections", "Corrections", {}};
  section.items.emplace_back(
      PageText{fmt::format("{} corrections are in both, {} only in A, {} only in B.",
                           difference.parameters.size(),
                           difference.parameters_only_in_a,
                           difference.parameters_only_in_b),
               ""});
  if (difference.parameters.empty()) return section;
  std::vector<const ResultDifference::Parameter*> order;
  for (const auto& parameter : difference.parameters) order.push_back(&parameter);
  std::stable_sort(order.begin(), order.end(), [](const auto* x, const auto* y) {
    return std::isnan(y->change_sigmas) ? !std::isnan(x->change_sigmas)
                                        : x->change_sigmas > y->change_sigmas;
  });
  PageTable table;
  table.columns = {{"pass", false},
                   {"parameter", false},
                   {"in A", true},
                   {"change", true},
                   {"unit", false},
                   {"change [sigma]", true}};
  for (std::size_t i = 0; i < std::min(order.size(), kMaxChangedRows); ++i) {
    const ParameterResult& p = a.result.file.parameters[order[i]->a];
    table.rows.push_back({p.owner,
                          p.name,
                          ShownWithSigma(p.value, p.sigma),
                          Shown(order[i]->change, 3),
                          p.unit,
                          Shown(order[i]->change_sigmas, 3)});
  }
  table.note = fmt::format("The {} of {} that changed most.",
                           std::min(order.size(), kMaxChangedRows),
                           difference.parameters.size());
  section.items.emplace_back(std::move(table));
  return section;
}

void Judge(const ResultDifference& difference, const Side& a, const Side& b, Page* page) {
  Headline& headline = page->headline;
  headline.state = HeadlineState::kNeutral;
  headline.word = a.headline.word == b.headline.word
                      ? "Both: " + a.headline.word
                      : a.headline.word + ", then " + b.headline.word;
  const auto weak = static_cast<std::size_t>(b.accuracy.weakest);
  const char* axis = AxisNames(b.result.file.frame)[weak];
  if (a.accuracy.points > 0 && b.accuracy.points > 0) {
    const double ratio = b.accuracy.median_m[weak] / a.accuracy.median_m[weak];
    headline.sentences.push_back(
        fmt::format("From A to B the median sigma {} goes from {} m to {} m ({} times).",
                    axis,
                    Shown(a.accuracy.median_m[weak], 3),
                    Shown(b.accuracy.median_m[weak], 3),
                    Shown(ratio, 3)));
  }
  if (!difference.common.empty()) {
    const Shift shift = ShiftsOf(difference);
    constexpr std::array kParts{0.5, 1.0};
    const std::vector<double> sigmas = SampleQuantiles(shift.sigmas, kParts);
    const std::vector<double> length_m = SampleQuantiles(shift.length_m, kParts);
    headline.sentences.push_back(
        fmt::format("Points move by {} m in the median and at most by {} m{}.",
                    Shown(length_m[0], 3),
                    Shown(length_m[1], 3),
                    std::isnan(sigmas[1]) ? ""
                                          : fmt::format(", which is {} and {} of their sigmas",
                                                        Shown(sigmas[0], 2),
                                                        Shown(sigmas[1], 2))));
  }
  if (difference.settings.empty() && difference.inputs.empty()) {
    headline.sentences.push_back("Inputs and configuration are the same.");
  } else {
    headline.sentences.push_back(fmt::format("{} setting{} and {} input file{} differ.",
                                             difference.settings.size(),
                                             difference.settings.size() == 1 ? "" : "s",
                                             difference.inputs.size(),
                                             difference.inputs.size() == 1 ? "" : "s"));
  }
}

}  // namespace

Page MakeComparisonPage(const ResultFolder& first, const ResultFolder& second) {
  const Side a(first), b(second);
  const ResultDifference difference = CompareResults(first, second);
  Page page;
  page.title = first.file.summary.block == second.file.summary.block
                   ? first.file.summary.block
                   : first.file.summary.block + " and " + second.file.summary.block;
  page.kind = "Comparison of two results";
  page.subtitle = "A: " + first.path + "   B: " + second.path;
  Judge(difference, a, b, &page);
  if (b.accuracy.points > 0) {
    const auto weak = static_cast<std::size_t>(b.accuracy.weakest);
    page.facts.push_back(
        {"Weakest point of B",
         fmt::format(
             "{} m {}", Shown(b.accuracy.largest_m[weak], 3), AxisNames(second.file.frame)[weak]),
         "at " + b.accuracy.largest_point[weak]});
  }
  if (!b.headline.would_help.empty()) {
    page.facts.push_back({"Would help most in B", b.headline.would_help, ""});
  }
  PageSection figures{"figures", "Side by side", {}};
  figures.items.emplace_back(FigureTable(a, b));
  page.sections = {figures,
                   SettingSection(difference),
                   PointSection(difference, a, b),
                   ParameterSection(difference, a)};
  return page;
}

}  // namespace sarblock
