// SPDX-License-Identifier: Apache-2.0
#include "adjust_priors.h"

#include <array>
#include <functional>

#include "adjust_corrections.h"
#include "core/text.h"
#include "model/priors.h"

namespace sarblock {
namespace {

// clang-format off
constexpr std::array kPriorOptions = std::to_array<AdjustOption>({
  {"prior.NAME.passes", "list", "pass ids", "all that have the parameters",
   "Passes that have the prior, each its own draw."},
  {"prior.NAME.parameters", "list", "names of passes.csv, of one pass, no splines", "required",
   "Corrections whose joint prior this is; they have no standard deviation of their own."},
  {"prior.NAME.axes", "text", "correction, track, frame, ric, ric-inertial", "correction",
   "Axes of the position parameters; in ric radial, in-track, cross-track. Others than those of "
   "the correction are turned into them at the middle of the strip."},
  {"prior.NAME.covariance", "list", "rows of a symmetric, positive definite matrix",
   "sigma is needed", "Covariance in the units of passes.csv."},
  {"prior.NAME.sigma", "list", "one number above 0 a parameter", "covariance is needed",
   "Standard deviations in the units of passes.csv."},
  {"prior.NAME.correlation", "list", "rows of a symmetric, positive definite matrix",
   "none are correlated", "With sigma: correlations, 1 on the diagonal."},
});
// clang-format on

const std::vector<std::string> kAxes{"correction", "track", "frame", "ric", "ric-inertial"};

std::vector<std::string> ReadNames(const TomlValue& value) {
  std::vector<std::string> out;
  for (const TomlValue& entry : value.Entries()) out.push_back(entry.Text());
  if (out.empty()) value.Fail("is empty, at least one entry is needed");
  return out;
}

Eigen::MatrixXd ReadMatrix(const TomlValue& value) {
  const std::vector<TomlValue> rows = value.Entries();
  const auto size = static_cast<Eigen::Index>(rows.size());
  if (rows.empty()) value.Fail("is empty, one row a parameter is needed");
  Eigen::MatrixXd out(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const TomlValue& row = rows[static_cast<std::size_t>(i)];
    const std::vector<TomlValue> entries = row.Entries();
    if (entries.size() != rows.size()) {
      row.Fail("the row has " + std::to_string(entries.size()) + " entries, as many as rows are " +
               "needed: " + std::to_string(rows.size()));
    }
    for (Eigen::Index j = 0; j < size; ++j) {
      out(i, j) = entries[static_cast<std::size_t>(j)].Number();
    }
  }
  return out;
}

JointPrior ReadPrior(const std::string& name, const TomlTable& table) {
  table.RefuseOthers(KeysWithin(kPriorOptions, "prior.NAME."));
  JointPrior prior;
  prior.name = name;
  if (const auto passes = table.Find("passes")) prior.passes = ReadNames(*passes);
  if (const auto parameters = table.Find("parameters")) prior.parameters = ReadNames(*parameters);
  if (const auto axes = table.Find("axes")) {
    prior.axes = static_cast<JointPrior::Axes>(axes->OneOf(kAxes));
  }
  if (const auto covariance = table.Find("covariance")) prior.covariance = ReadMatrix(*covariance);
  if (const auto correlation = table.Find("correlation")) {
    prior.correlation = ReadMatrix(*correlation);
  }
  if (const auto sigma = table.Find("sigma")) {
    const std::vector<TomlValue> entries = sigma->Entries();
    prior.sigma.resize(static_cast<Eigen::Index>(entries.size()));
    for (std::size_t i = 0; i < entries.size(); ++i) {
      prior.sigma[static_cast<Eigen::Index>(i)] = entries[i].Positive();
    }
    if (entries.empty()) sigma->Fail("is empty, one number a parameter is needed");
  }
  static_cast<void>(table.Require("parameters", "a list of names as in passes.csv"));
  return prior;
}

std::string TextsText(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : ", ") + TomlText(text);
  return "[" + out + "]";
}

std::string NumbersText(const Eigen::Ref<const Eigen::VectorXd>& numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + NumberText(number);
  return "[" + out + "]";
}

std::string MatrixText(const Eigen::MatrixXd& matrix) {
  std::string out;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    out += (i > 0 ? ", " : "") + NumbersText(matrix.row(i).transpose());
  }
  return "[" + out + "]";
}

}  // namespace

std::span<const AdjustOption> PriorOptions() { return kPriorOptions; }

std::vector<JointPrior> ReadPriors(const TomlTable& priors) {
  std::vector<JointPrior> out;
  for (const auto& [key, node] : priors.table()) {
    const std::string name(key.str());
    out.push_back(ReadPrior(name, TomlTable(*priors.Find(name))));
  }
  return out;
}

void RequireFitting(const TomlTable& table,
                    const std::vector<std::string>& pass_ids,
                    const std::vector<CorrectionGroup>& groups,
                    const std::vector<JointPrior>& priors) {
  const JointPriorBindings bindings = BindJointPriors(pass_ids, groups, priors);
  if (!bindings.problem) return;
  const JointPriorProblem& problem = *bindings.problem;
  const TomlTable prior(*table.Find(priors[problem.prior].name));
  const auto field = prior.Find(problem.field);
  if (!field) throw InputError(prior.PlaceOf(problem.field), problem.problem);
  if (problem.entry >= 0) {
    field->Entries().at(static_cast<std::size_t>(problem.entry)).Fail(problem.problem);
  }
  field->Fail(problem.problem);
}

std::string DumpPriors(const std::vector<JointPrior>& priors) {
  std::string text;
  for (const JointPrior& prior : priors) {
    const auto line = [&text](const char* key, const std::string& value) {
      text.append(key).append(" = ").append(value).append("\n");
    };
    text += "[adjust.prior." + TomlKey(prior.name) + "]\n";
    if (!prior.passes.empty()) line("passes", TextsText(prior.passes));
    line("parameters", TextsText(prior.parameters));
    if (prior.axes != JointPrior::Axes::kCorrection) {
      line("axes", TomlText(kAxes[static_cast<std::size_t>(prior.axes)]));
    }
    if (prior.covariance.size() > 0) line("covariance", MatrixText(prior.covariance));
    if (prior.sigma.size() > 0) line("sigma", NumbersText(prior.sigma));
    if (prior.correlation.size() > 0) line("correlation", MatrixText(prior.correlation));
  }
  return text;
}

}  // namespace sarblock
