// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file commands.h
/// One function per subcommand.

#include "common/program.h"

namespace superray {

Command declareAccuracy(CLI::App& app);
Command declareCompare(CLI::App& app);
Command declarePaper(CLI::App& app);
Command declareRealtime(CLI::App& app);
Command declareSimulate(CLI::App& app);
Command declareSoak(CLI::App& app);

}  // namespace superray
