// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file commands.h
/// One function per subcommand.

#include "common/program.h"

namespace superray {

/// Exit codes: 1 also where exact engines do not agree.
enum ExitCode : int { kSuccess = 0, kError = 1 };

Command declareAccuracy(CLI::App& app);
Command declareCompare(CLI::App& app);
Command declarePaper(CLI::App& app);
Command declareRealtime(CLI::App& app);
Command declareSimulate(CLI::App& app);

}  // namespace superray
