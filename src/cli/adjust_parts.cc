// SPDX-License-Identifier: Apache-2.0
#include "adjust_parts.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"
#include "sarblock/tables/output.h"

#include "files/montecarlo_part.h"
#include <fmt/core.h>

namespace sarblock::cli {

void AddAdjustParts(CLI::App* command, CLI::Option* report, AdjustParts* parts) {
  CLI::Option* const part = AddPart(
      command,
      &parts->part,
      "Only the runs I modulo N of covariance = montecarlo, for --join; I from 0 or from 1");
  part->excludes(report);
  command
      ->add_option(
          "--join", parts->join, "Folders of all parts that --part wrote: their runs, none anew")
      ->excludes(part);
}

void SetParts(const AdjustParts& parts, const std::string& out, AdjustOptions* options) {
  if (parts.part.empty() && parts.join.empty()) return;
  if (options->covariance != CovarianceLevel::kMonteCarlo) {
    throw InputError("adjust.covariance",
                     "only the runs of \"montecarlo\" have parts; --set covariance=montecarlo is "
                     "allowed");
  }
  RequireNoneOf(parts.join, out);
  if (!parts.part.empty() && NamesContainer(out)) {
    throw InputError(FilePlace{out, 0, ""}, "is the name of a file, a part is a folder");
  }
  options->montecarlo_part = parts.part.empty() ? TaskPart::None() : TaskPartOf(parts.part);
}

void WritePart(const std::string& out,
               const Block& block,
               const AdjustOptions& options,
               const AdjustResult& result,
               const std::vector<InputFile>& inputs,
               Compression compression,
               const Session& session) {
  const MonteCarloDraws& draws = *result.montecarlo_draws;
  const std::string text = WriteMonteCarloPart(out, block, options, draws, inputs, compression);
  if (!result.accepted()) {
    for (const std::string& reason : result.assessment.reasons) {
      session.Say("sarblock: the adjustment is not accepted: " + reason);
    }
  }
  if (session.json) {
    fmt::print("{}", text);
    return;
  }
  session.Show(
      fmt::format("{}: {} of {} runs written to {}; \"sarblock adjust --join\" makes the result of "
                  "all parts\n",
                  NameOf(*options.montecarlo_part),
                  draws.runs.size(),
                  options.montecarlo_runs,
                  out));
}

}  // namespace sarblock::cli
