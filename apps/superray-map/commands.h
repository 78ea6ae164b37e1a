// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file commands.h
/// One function per subcommand: declares its options on `app` and returns what
/// to run once they are parsed.

#include "common/program.h"

namespace superray {

Command declareBuild(CLI::App& app);
Command declareInfo(CLI::App& app);
Command declareInspect(CLI::App& app);
Command declareExport(CLI::App& app);
Command declareCompare(CLI::App& app);

}  // namespace superray
