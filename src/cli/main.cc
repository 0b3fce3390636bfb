// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/version.h"

#include <exception>
#include <string>

#include "commands.h"
#include "environment.h"
#include "leberl_command.h"
#include "manual.h"
#include "report_command.h"
#include "study_command.h"
#include <glog/logging.h>

namespace sarblock::cli {
namespace {

int Main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;

  Session session;
  CLI::App app(
      "sarblock: least-squares stereo block adjustment for side-looking radar, with the exact "
      "covariance of everything it solves.",
      "sarblock");
  app.set_version_flag("--version", std::string("sarblock ") + Version());
  app.require_subcommand(1);
  app.fallthrough();
  AddGlobalOptions(&app, &session);
  AddSimulate(&app, &session);
  AddImport(&app, &session);
  AddCheck(&app, &session);
  AddIntersect(&app, &session);
  AddPredict(&app, &session);
  AddAdjust(&app, &session);
  AddReport(&app, &session);
  AddExport(&app, &session);
  AddStudy(&app, &session);
  AddLeberl(&app, &session);
  AddManualOptions(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kAccepted : kWrongUsage;
  }
  InstallInterruptHandler();
  MakeProgress(&session);
  const auto fail = [&session](const char* what, int code) {
    session.progress.reset();  // clears the bar's line
    Tell(std::string("sarblock: ") + what);
    return code;
  };
  try {
    return session.run();
  } catch (const InputError& error) {
    return fail(error.what(), kBadInput);
  } catch (const UndeterminedError& error) {
    return fail(error.what(), kUndetermined);
  } catch (const Interrupted& error) {
    return fail(error.what(), kNotAccepted);
  }
}

}  // namespace
}  // namespace sarblock::cli

int main(int argc, char** argv) {
  using namespace sarblock::cli;
  OpenStandardStreams();
  try {
    return FinishOutput(Main(argc, argv));
  } catch (const std::exception& error) {
    return ExplainError(error);
  }
}
