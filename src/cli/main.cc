// SPDX-License-Identifier: Apache-2.0
#include <exception>

#include "core/threads.h"
#include "leberl.h"
#include "program.h"
#include "session.h"

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
                                     AddPlan,
                                     AddStudy,
                                     AddLeberl},
                        .cores = sarblock::AvailableCores()};
  return RunProgram(program, argc, argv);
}
