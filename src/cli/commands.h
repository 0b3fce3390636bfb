// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session.h"

namespace sarblock::cli {

/// Each adds one command; when it is chosen, session->run is set to its work.
void AddSimulate(CLI::App* app, Session* session);
void AddImport(CLI::App* app, Session* session);
void AddCheck(CLI::App* app, Session* session);
void AddIntersect(CLI::App* app, Session* session);
void AddPredict(CLI::App* app, Session* session);
void AddAdjust(CLI::App* app, Session* session);
void AddExport(CLI::App* app, Session* session);
void AddConvert(CLI::App* app, Session* session);

}  // namespace sarblock::cli
