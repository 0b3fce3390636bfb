// SPDX-License-Identifier: Apache-2.0
#include <exception>

#include "commands.h"
#include "core/threads.h"
#include "diagnose_command.h"
#include "environment.h"
#include "leberl_command.h"
#include "program.h"
#include "report_command.h"
#include "study_command.h"

int main(int argc, char** argv) {
  using namespace sarblock::cli;
  OpenStandardStreams();
  const Program program{.name = "sarblock",
                        .description =
                            "least-squares stereo block adjustment for side-looking "
                            "radar, with the exact covariance of everything it solves.",
                        .commands = {AddSimulate,
                                     AddImport,
                                     AddCheck,
                                     AddIntersect,
                                     AddPredict,
                                     AddAdjust,
                                     AddDiagnose,
                                     AddReport,
                                     AddExport,
                                     AddConvert,
                                     AddStudy,
                                     AddLeberl},
                        .cores = sarblock::AvailableCores()};
  return RunProgram(program, argc, argv);
}
