// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/version.h"

#include <exception>

#include "commands.h"
#include "leberl_command.h"
#include "manual.h"
#include "report_command.h"
#include "study_command.h"
#include <fmt/format.h>
#include <glog/logging.h>

int main(int argc, char** argv) {
  using namespace sarblock;
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;

  cli::Session session;
  CLI::App app(
      "sarblock: least-squares stereo block adjustment for side-looking radar, with the exact "
      "covariance of everything it solves.",
      "sarblock");
  app.set_version_flag("--version", std::string("sarblock ") + Version());
  app.require_subcommand(1);
  app.fallthrough();
  cli::AddGlobalOptions(&app, &session);
  cli::AddSimulate(&app, &session);
  cli::AddImport(&app, &session);
  cli::AddCheck(&app, &session);
  cli::AddIntersect(&app, &session);
  cli::AddPredict(&app, &session);
  cli::AddAdjust(&app, &session);
  cli::AddReport(&app, &session);
  cli::AddExport(&app, &session);
  cli::AddStudy(&app, &session);
  cli::AddLeberl(&app, &session);
  cli::AddManualOptions(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? cli::kAccepted : cli::kWrongUsage;
  }
  cli::InstallInterruptHandler();
  cli::MakeProgress(&session);
  const auto fail = [&session](const char* what, int code) {
    session.progress.reset();  // clears the bar's line
    fmt::print(stderr, "sarblock: {}\n", what);
    return code;
  };
  try {
    return session.run();
  } catch (const InputError& error) {
    return fail(error.what(), cli::kBadInput);
  } catch (const UndeterminedError& error) {
    return fail(error.what(), cli::kUndetermined);
  } catch (const Interrupted& error) {
    return fail(error.what(), cli::kNotAccepted);
  } catch (const std::exception& error) {
    return fail((std::string("internal error: ") + error.what()).c_str(), cli::kInternalError);
  }
}
