// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file commands.h
/// One function per subcommand.

#include "common/program.h"

namespace superray {

Command declareBuild(CLI::App& app);
Command declareEvaluate(CLI::App& app);
Command declareOptions(CLI::App& app);

}  // namespace superray
