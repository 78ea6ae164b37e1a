#pragma once
/// \file commands.h
/// One function per subcommand: declares its options on `app` and returns what
/// to run once they are parsed.

#include <CLI/CLI.hpp>
#include <functional>

namespace superray {

/// Exit codes; `compare` uses all three.
enum ExitCode : int { kSuccess = 0, kDifferent = 1, kError = 2 };

/// Runs a parsed subcommand. \return its exit code
using Command = std::function<int()>;

Command declareBuild(CLI::App& app);
Command declareInfo(CLI::App& app);
Command declareExport(CLI::App& app);
Command declareCompare(CLI::App& app);

}  // namespace superray
