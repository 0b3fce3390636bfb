// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session.h"

namespace sarblock::cli {

/// Adds `report`; when it is chosen, session->run is set to its work.
void AddReport(CLI::App* app, Session* session);

/// Writes report.html into a result's folder and says so (`--report` of the solving commands).
void ReportResult(const std::string& folder, const Session& session);

}  // namespace sarblock::cli
