// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file program.h
/// What our programs share: subcommands, --version, and errors in one line.
/// program.cpp and linked_knowingly.cpp are compiled into each of them.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace superray {

/// Runs a parsed subcommand. \return the program's exit code
using Command = std::function<int()>;

struct CommandEntry {
    std::string name, summary;
    /// Declares the options on the subcommand's parser and returns what to run
    /// once they are parsed. The type name of an option tells what is checked: N is a
    /// count, METRES, DEGREES, SECONDS and so on are numbers, FILE and DATA are read, OUTPUT
    /// is a file to write.
    Command (*declare)(CLI::App&);
};

/// Exit codes, the same in all programs. kDifferent: what was compared (maps, engines that
/// must agree) differs.
enum ExitCode : int { kSuccess = 0, kDifferent = 1, kError = 2 };

/// main() of a program with subcommands. Errors become one line on stderr, and kError.
int runProgram(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int argc, char** argv);

}  // namespace superray
