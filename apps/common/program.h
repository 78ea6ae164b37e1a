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
    /// once they are parsed.
    Command (*declare)(CLI::App&);
};

/// main() of a program with subcommands.
/// \param errorCode its exit code for errors, which become one line on stderr
int runProgram(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int errorCode, int argc, char** argv);

}  // namespace superray
