// SPDX-License-Identifier: Apache-2.0
// sarblock-mpi: the adjustment by several processes, one call of this program each:
//
//     mpirun -n 8 sarblock-mpi adjust BLOCK -o RESULT
#include <cstdio>

#include "cli/program.h"
#include "cli/session.h"
#include "ranks.h"
#include <mpi.h>

namespace {

int RunRank(int argc, char** argv) {
  using namespace sarblock;
  mpi::MpiRanks ranks;
  // Results on standard output are those of the first rank.
  if (!ranks.first() && std::freopen("/dev/null", "w", stdout) == nullptr) {
    return cli::kInternalError;
  }
  const cli::Program program{.name = "sarblock-mpi",
                             .description =
                                 "the adjustment of sarblock by several processes that "
                                 "mpirun starts. Other commands are those of sarblock.",
                             .commands = {cli::AddAdjust},
                             .ranks = &ranks,
                             .cores = ranks.cores()};
  return cli::RunProgram(program, argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  sarblock::cli::OpenStandardStreams();
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const int exit_code = RunRank(argc, argv);
  MPI_Finalize();
  return exit_code;
}
