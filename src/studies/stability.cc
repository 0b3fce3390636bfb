// SPDX-License-Identifier: Apache-2.0
#include "stability.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "core/threads.h"
#include "exact.h"
#include "normals/point.h"
#include "quality/point_sweep.h"
#include "quality/verdict_tests.h"
#include "study.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

double DigitsOf(double relative_error) {
  if (std::isnan(relative_error)) return 0.0;
  return std::clamp(-std::log10(relative_error), 0.0, 16.0);
}

/// The problem of a result, points and looks in use as it left them, at its solution.
void Restore(const AdjustResult& result, AdjustmentProblem* problem, BlockState* state) {
  const std::size_t points = problem->block.points.size();
  for (std::size_t point = 0; point < points; ++point) {
    if (!IsSolved(result.points.status[point])) {
      problem->LeaveOut(point, result.points.status[point], {});
    }
  }
  for (std::size_t i = 0; i < result.looks.rejected.size(); ++i) {
    if (result.looks.rejected[i] != 0) problem->look_used[i] = 0;
  }
  state->start_m = result.points.position_m;
  state->displacement_m.assign(points, Eigen::Vector3d::Zero());
  state->corrections.resize(problem->layout.size());
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    state->corrections[static_cast<Eigen::Index>(i)] = result.parameters[i].value;
  }
  UpdateWeights(*state, problem);
}

/// Words of a warning that the numbers are not to be trusted to their digits. A warning of points
/// that were left out says nothing of the others.
bool WarnsOfDigits(const std::string& warning) {
  constexpr std::array<const char*, 5> kWords = {"not converged",
                                                 "sigmas are still to go",
                                                 "nearly undetermined",
                                                 "more than half their range",
                                                 "rounding"};
  return std::any_of(kWords.begin(), kWords.end(), [&](const char* word) {
    return warning.find(word) != std::string::npos;
  });
}

/// What priors might be says nothing of the digits either, nor of anything that is wrong.
bool AdvisesOnPriors(const std::string& warning) { return warning.starts_with(kWidePriors); }

std::string JoinedTexts(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : " | ") + text;
  return out;
}

void FillComparison(const Block& block,
                    const AdjustOptions& options,
                    const AdjustResult& result,
                    ProgressSink* progress,
                    StabilityRow* row) {
  AdjustmentProblem problem(block, options.groups, {}, options.priors);
  BlockState state;
  Restore(result, &problem, &state);
  const ExactComparison exact = CompareWithExact(problem, result);
  if (!exact.failure.empty()) {
    row->message += (row->message.empty() ? "" : " | ") + ("oracle: " + exact.failure);
    return;
  }
  row->condition = exact.condition;
  row->covariance_digits = DigitsOf(exact.covariance_error);
  row->sigma_digits = DigitsOf(exact.sigma_error);
  row->position_digits = DigitsOf(exact.position_error);
  row->error_sigma = exact.error_sigma;
  const auto by_normals = [&](Precision precision) {
    return DigitsOf(
        CovarianceError(CovariancesByNormals(problem, state, precision), exact.covariance_m2));
  };
  row->normal_digits = by_normals(Precision::kDouble);
  row->single_digits = by_normals(Precision::kSingle);
  AdjustOptions ceres = options;
  ceres.engine = Engine::kCeres;
  ceres.threads = 1;  // the order of its sums, and so the last digits, follow from the number
  ceres.covariance_method = CovarianceMethod::kCeres;
  try {
    row->ceres_digits = DigitsOf(CovarianceError(
        Adjust(block, ceres, {}, progress).points.covariance_m2, exact.covariance_m2));
  } catch (const UndeterminedError&) {
    // Stays without digits.
  }
}

}  // namespace

const char* NameOf(StabilityOutcome outcome) {
  switch (outcome) {
    case StabilityOutcome::kOk:
      return "ok";
    case StabilityOutcome::kWarned:
      return "warned";
    case StabilityOutcome::kRefused:
      return "refused";
    case StabilityOutcome::kWrong:
      break;
  }
  return "wrong";
}

StabilityOutcome JudgeStability(const StabilityRow& row, const std::vector<std::string>& warnings) {
  if (row.exit_code > 1) return StabilityOutcome::kRefused;
  // NaN, where nothing could be compared, fails the comparison.
  const bool right = row.error_sigma <= kMaxError && row.sigma_digits >= kMinDigits &&
                     row.covariance_digits >= kMinDigits;
  const bool said = std::any_of(warnings.begin(), warnings.end(), WarnsOfDigits);
  if (!right && !said) return StabilityOutcome::kWrong;
  const bool silent = std::all_of(warnings.begin(), warnings.end(), AdvisesOnPriors);
  return row.exit_code == 0 && silent ? StabilityOutcome::kOk : StabilityOutcome::kWarned;
}

StabilityRow RunStabilityStep(const StabilityFamily& family,
                              double value,
                              int threads,
                              ProgressSink* progress) {
  StabilityPlan plan = family.plan(value);
  StabilityRow row;
  row.family = family.name;
  row.parameter = family.parameter;
  row.value = value;
  plan.options.threads = threads;
  AdjustResult result;
  const Block block = MakeStabilityBlock(plan);
  try {
    result = Adjust(block, plan.options, {}, progress);
  } catch (const UndeterminedError& error) {
    row.exit_code = 4;
    row.message = error.what();
    return row;
  } catch (const InputError& error) {
    row.exit_code = 3;
    row.message = error.what();
    return row;
  }
  row.exit_code = result.usable() ? 0 : 1;
  std::vector<std::string> said;
  if (!result.usable()) said = result.assessment.reasons;
  said.insert(said.end(), result.warnings.begin(), result.warnings.end());
  row.message = JoinedTexts(said);
  FillComparison(block, plan.options, result, progress, &row);
  row.outcome = JudgeStability(row, said);
  return row;
}

namespace {

/// The whole whitened Jacobian, row by row: three columns a solved point, then the corrections.
struct Jacobian {
  std::size_t columns = 0;
  std::vector<double> values;

  double* AddRow() {
    values.resize(values.size() + columns, 0.0);
    return values.data() + values.size() - columns;
  }
};

void AddLooks(const AdjustmentProblem& problem,
              const BlockState& state,
              std::size_t point,
              std::size_t first_of_point,
              std::size_t first_of_corrections,
              Jacobian* j) {
  WhitenedLook look;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    if (!EvaluateWhitened(problem, state, {}, point, i, &look)) continue;
    for (std::size_t r = 0; r < 2; ++r) {
      double* row = j->AddRow();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        row[first_of_point + axis] =
            look.d_point(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(axis));
      }
      std::size_t local = 0;
      for (int b = 0; b < look.columns.block_count; ++b) {
        const ParameterBlock& block =
            problem.layout
                .blocks[static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)])];
        for (int c = 0; c < block.size; ++c) {
          row[first_of_corrections + static_cast<std::size_t>(block.offset + c)] +=
              look.row[r][local++];
        }
      }
    }
  }
}

Jacobian JacobianOf(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const std::vector<std::size_t>& solved) {
  Jacobian j;
  const std::size_t first = 3 * solved.size();
  j.columns = first + problem.layout.parameters.size();
  for (std::size_t k = 0; k < solved.size(); ++k) {
    const std::size_t point = solved[k];
    AddLooks(problem, state, point, 3 * k, first, &j);
    if (problem.control_of[point] < 0) continue;
    const ControlEquations& equations =
        problem.control[static_cast<std::size_t>(problem.control_of[point])];
    const ControlEvaluation control = EvaluateControl(
        problem.block.frame, equations, state.start_m[point], state.displacement_m[point]);
    for (int r = 0; r < equations.rows; ++r) {
      double* row = j.AddRow();
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        row[3 * k + static_cast<std::size_t>(axis)] = control.d_point(r, axis);
      }
    }
  }
  for (std::size_t b = 0; b < problem.layout.blocks.size(); ++b) {
    for (const PriorRow& prior : PriorRowsOf(problem.layout, static_cast<int>(b))) {
      double* row = j.AddRow();
      for (const PriorRow::Term& term : prior.terms) {
        row[first + static_cast<std::size_t>(term.parameter)] = term.weight;
      }
    }
  }
  return j;
}

/// Inverse of the normal matrix of columns of unit length, by L with L L' = N and X = L^-1;
/// empty without a factor. Lower triangle, row by row of `size`.
template <typename T>
std::vector<T> InverseNormals(const Jacobian& j, const std::vector<double>& length) {
  const std::size_t n = j.columns;
  std::vector<T> l(n * n, T(0)), row(n);
  for (std::size_t at = 0; at < j.values.size(); at += n) {
    for (std::size_t c = 0; c < n; ++c) row[c] = static_cast<T>(j.values[at + c] / length[c]);
    for (std::size_t a = 0; a < n; ++a) {
      if (row[a] == T(0)) continue;
      for (std::size_t b = 0; b <= a; ++b) l[a * n + b] += row[a] * row[b];
    }
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      T sum = l[a * n + b];
      for (std::size_t k = 0; k < b; ++k) sum -= l[a * n + k] * l[b * n + k];
      if (a == b && !(sum > T(0))) return {};
      l[a * n + b] = a == b ? std::sqrt(sum) : sum / l[b * n + b];
    }
  }
  std::vector<T> x(n * n, T(0)), inverse(n * n, T(0));
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      T sum = a == b ? T(1) : T(0);
      for (std::size_t k = b; k < a; ++k) sum -= l[a * n + k] * x[k * n + b];
      x[a * n + b] = sum / l[a * n + a];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t a = 0; a <= k; ++a) {
      for (std::size_t b = 0; b <= a; ++b) inverse[a * n + b] += x[k * n + a] * x[k * n + b];
    }
  }
  return inverse;
}

template <typename T>
std::vector<SymmetricEnu> Covariances(const AdjustmentProblem& problem,
                                      const BlockState& state,
                                      const std::vector<std::size_t>& solved) {
  const Jacobian j = JacobianOf(problem, state, solved);
  // Columns of unit length first: no digit goes to units, in single precision nothing overflows.
  std::vector<double> length(j.columns, 0.0);
  for (std::size_t i = 0; i < j.values.size(); ++i) {
    length[i % j.columns] += j.values[i] * j.values[i];
  }
  for (double& value : length) value = std::sqrt(value);
  const std::vector<T> inverse = InverseNormals<T>(j, length);
  if (inverse.empty()) return {};
  SymmetricEnu none;
  none.fill(std::numeric_limits<double>::quiet_NaN());
  std::vector<SymmetricEnu> out(problem.block.points.size(), none);
  for (std::size_t k = 0; k < solved.size(); ++k) {
    Eigen::Matrix3d c;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        const std::size_t row = 3 * k + a, column = 3 * k + b;
        const double value =
            static_cast<double>(inverse[row * j.columns + column]) / (length[row] * length[column]);
        c(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = value;
        c(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) = value;
      }
    }
    out[solved[k]] = ToEnu(problem.block.frame, state.Position(solved[k]), c);
  }
  return out;
}

}  // namespace

std::vector<SymmetricEnu> CovariancesByNormals(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               Precision precision) {
  std::vector<std::size_t> solved;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) solved.push_back(point);
  }
  return precision == Precision::kSingle ? Covariances<float>(problem, state, solved)
                                         : Covariances<double>(problem, state, solved);
}

double CovarianceError(const std::vector<SymmetricEnu>& computed,
                       const std::vector<SymmetricEnu>& exact) {
  double worst = 0.0;
  for (std::size_t point = 0; point < exact.size(); ++point) {
    if (std::isnan(exact[point][0])) continue;
    if (computed.size() != exact.size()) return std::numeric_limits<double>::infinity();
    double square = 0.0, off = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      const double count = k < 3 ? 1.0 : 2.0;
      const double difference = computed[point][k] - exact[point][k];
      square += count * exact[point][k] * exact[point][k];
      off += count * difference * difference;
    }
    const double error = std::sqrt(off / square);
    if (std::isnan(error)) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, error);
  }
  return worst;
}

namespace {

constexpr std::array kOutcomes = {StabilityOutcome::kOk,
                                  StabilityOutcome::kWarned,
                                  StabilityOutcome::kRefused,
                                  StabilityOutcome::kWrong};
using OutcomeCounts = std::array<std::size_t, kOutcomes.size()>;

StudyRow RowOf(const StabilityRow& row) {
  StudyRowMaker cells(StabilityColumns());
  cells.Set("family", row.family)
      .Set("parameter", row.parameter)
      .Set("value", row.value)
      .Set("condition", row.condition)
      .Set("outcome", NameOf(row.outcome))
      .Set("covariance_digits", row.covariance_digits)
      .Set("position_digits", row.position_digits)
      .Message(row.message)
      .Set("exit_code", static_cast<std::int64_t>(row.exit_code))
      .Set("sigma_digits", row.sigma_digits)
      .Set("error_sigma", row.error_sigma)
      .Set("normal_digits", row.normal_digits)
      .Set("single_digits", row.single_digits)
      .Set("ceres_digits", row.ceres_digits);
  return cells.row();
}

std::string Number(double value, const char* format = "%.3g") {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

/// "5 ok, 3 warned, 0 refused, 0 wrong".
std::string CountsPhrase(const OutcomeCounts& counts) {
  std::string text;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    text += (k == 0 ? "" : ", ") + std::to_string(counts[k]) + " " + NameOf(kOutcomes[k]);
  }
  return text;
}

/// "9.0 / 14.4": fewest and median.
std::string FewestAndMedian(std::vector<double> digits) {
  if (digits.empty()) return "-";
  std::sort(digits.begin(), digits.end());
  const std::size_t half = digits.size() / 2;
  const double median =
      digits.size() % 2 == 1 ? digits[half] : 0.5 * (digits[half - 1] + digits[half]);
  return Number(digits.front(), "%.1f") + " / " + Number(median, "%.1f");
}

/// Digits of each method by the decade of the condition, warned rows among them.
std::vector<std::string> DigitsByCondition(const StudyTable& table) {
  struct Method {
    const char* column;
    const char* name;
  };
  constexpr std::array kMethods = {Method{"covariance_digits", "production"},
                                   Method{"normal_digits", "all normal equations"},
                                   Method{"ceres_digits", "Ceres"},
                                   Method{"single_digits", "all normal equations, single"}};
  std::map<int, std::vector<std::size_t>> decades;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double condition = table.Number(row, "condition");
    // Left out where nothing was compared or the program accepted nothing.
    if (condition >= 1.0 && table.Number(row, "exit_code") == 0.0) {
      decades[static_cast<int>(std::floor(std::log10(condition)))].push_back(row);
    }
  }
  std::vector<std::string> words;
  for (const auto& [decade, rows] : decades) {
    std::string line = "condition 1e" + std::to_string(decade) + " to 1e" +
                       std::to_string(decade + 1) + " (" + std::to_string(rows.size()) +
                       " accepted), fewest / median digits: ";
    for (const Method& method : kMethods) {
      std::vector<double> digits;
      for (const std::size_t row : rows) {
        const double value = table.Number(row, method.column);
        if (!std::isnan(value)) digits.push_back(value);
      }
      if (method.column != kMethods.front().column) line += ", ";
      line += std::string(method.name) + " " + FewestAndMedian(std::move(digits));
    }
    words.push_back(std::move(line));
  }
  return words;
}

}  // namespace

const std::vector<StudyColumn>& StabilityColumns() {
  using Kind = StudyCellKind;
  static const std::vector<StudyColumn> columns = {{"family", Kind::kText, InReport::kNeeded},
                                                   {"parameter", Kind::kText},
                                                   {"value"},
                                                   {"condition"},
                                                   {"outcome", Kind::kText, InReport::kNeeded},
                                                   {"covariance_digits"},
                                                   {"position_digits"},
                                                   {"message", Kind::kText},
                                                   {"exit_code", Kind::kInteger, InReport::kNo},
                                                   {"sigma_digits", Kind::kNumber, InReport::kNo},
                                                   {"error_sigma", Kind::kNumber, InReport::kNo},
                                                   {"normal_digits", Kind::kNumber, InReport::kNo},
                                                   {"single_digits", Kind::kNumber, InReport::kNo},
                                                   {"ceres_digits", Kind::kNumber, InReport::kNo}};
  return columns;
}

StudyPlan PlanStability(const StabilityStudy& study) {
  StudyPlan plan;
  plan.columns = StabilityColumns();
  for (const StabilityFamily& family : study.families) {
    for (const double value : family.values) {
      plan.tasks.push_back(
          {family.name + " " + Number(value), [family, value](ProgressSink* progress) {
             // All cores: a limit would apply to the steps that run at the same time too.
             return std::vector<StudyRow>{
                 RowOf(RunStabilityStep(family, value, AvailableCores(), progress))};
           }});
    }
  }
  return plan;
}

std::vector<std::string> DescribeStability(const StabilityStudy& study, const StudyTable& table) {
  OutcomeCounts all{};
  std::map<std::string, OutcomeCounts> by_family;
  std::vector<std::string> wrong;
  double most_error = 0.0, fewest_digits = std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string outcome = table.Text(row, "outcome"), family = table.Text(row, "family");
    const double digits = table.Number(row, "sigma_digits"),
                 error = table.Number(row, "error_sigma");
    for (std::size_t k = 0; k < kOutcomes.size(); ++k) {
      if (outcome != NameOf(kOutcomes[k])) continue;
      ++all[k];
      ++by_family[family][k];
    }
    if (outcome == NameOf(StabilityOutcome::kOk)) {
      most_error = std::max(most_error, error);
      fewest_digits = std::min(fewest_digits, digits);
    } else if (outcome == NameOf(StabilityOutcome::kWrong)) {
      wrong.push_back("wrong: " + family + " at " + Number(table.Number(row, "value")) + ": " +
                      Number(table.Number(row, "covariance_digits"), "%.1f") +
                      " digits of a covariance, " + Number(digits, "%.1f") + " of a sigma, " +
                      Number(error) + " sigmas off");
    }
  }
  std::vector<std::string> words;
  words.push_back(std::to_string(table.size()) + " steps of " +
                  std::to_string(study.families.size()) + " families: " + CountsPhrase(all));
  if (all[0] > 0) {
    words.push_back("of those that are ok: largest error " + Number(most_error) +
                    " sigmas, fewest digits of a sigma " + Number(fewest_digits, "%.1f"));
  }
  for (std::string& line : DigitsByCondition(table)) words.push_back(std::move(line));
  for (const StabilityFamily& family : study.families) {
    words.push_back(family.name + ": " + CountsPhrase(by_family[family.name]) + " (" +
                    family.about + ")");
  }
  words.insert(words.end(), wrong.begin(), wrong.end());
  return words;
}

namespace {

/// The values of a [[family]] table instead of the family's own.
void ReadValues(const TomlValue& values, StabilityFamily* family) {
  const auto [least, most] = std::minmax_element(family->values.begin(), family->values.end());
  std::vector<double> read;
  for (const TomlValue& entry : values.Entries()) {
    const double value = entry.Number();
    // The defaults are powers, rounded in their last digits.
    if (!(value >= *least * (1.0 - 1e-12) && value <= *most * (1.0 + 1e-12))) {
      std::ostringstream range;
      range << "must lie between " << *least << " and " << *most << ", where " << family->name
            << " is a block";
      entry.Fail(range.str());
    }
    if (family->whole && value != std::floor(value)) entry.Fail("must be a whole number");
    read.push_back(value);
  }
  if (read.empty()) values.Fail("must not be empty");
  family->values = std::move(read);
}

}  // namespace

StabilityStudy ParseStability(std::string_view text,
                              const std::string& file,
                              const std::vector<std::string>& overrides) {
  const toml::table parsed = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(parsed, "")};
  StabilityStudy study;
  study.heading = TakeStudyHeading("stability", &table);
  if (const auto seed = table.Take("seed")) {
    seed->Fail("is not used here: every family has its own noise");
  }
  const std::vector<StabilityFamily>& all = StabilityFamilies();
  std::vector<std::string> names;
  for (const StabilityFamily& family : all) names.push_back(family.name);
  std::set<std::string> taken;
  const auto named = [&](const TomlValue& name) {
    const StabilityFamily& family = all[name.OneOf(names)];
    if (!taken.insert(family.name).second) name.Fail("is given twice");
    return family;
  };
  if (const auto listed = table.Take("families")) {
    for (const TomlValue& entry : listed->Entries()) study.families.push_back(named(entry));
  }
  static_cast<void>(table.Table("block"));  // read with the families that are made of it
  const auto own =
      std::make_shared<const FamilyText>(FamilyText{std::string(text), file, overrides});
  std::vector<SceneTable> given = table.Tables("family");
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto name = given[i].Take("name");
    if (!name) throw InputError(given[i].PlaceOf("name"), "must be given");
    if (given[i].Has("block")) {
      if (!taken.insert(name->Text()).second) name->Fail("is given twice");
      study.families.push_back(FamilyOfStudy(&given[i], i, own));
      continue;
    }
    StabilityFamily family = named(*name);
    if (const auto values = given[i].Take("values")) ReadValues(*values, &family);
    given[i].Finish();
    study.families.push_back(std::move(family));
  }
  table.Finish();
  if (study.families.empty()) study.families = all;
  return study;
}

StabilityStudy ReadStability(const std::filesystem::path& path,
                             const std::vector<std::string>& overrides) {
  return ParseStability(ReadTomlText(path, "a study"), path.string(), overrides);
}

std::vector<std::string> StabilityKeys() { return {"name", "purpose", "families"}; }

}  // namespace sarblock
