// SPDX-License-Identifier: BSD-3-Clause
#include "common/program.h"

#include <superray/eval/input_error.h>

#include <iostream>

namespace superray {
namespace {

int runCommand(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int argc, char** argv) {
    CLI::App app(description, program);
    app.require_subcommand(1);
    app.set_version_flag("--version", program + " " SUPERRAY_VERSION);
    app.get_formatter()->column_width(28);
    std::vector<std::pair<const CLI::App*, Command>> commands;
    for (const CommandEntry& entry : entries) {
        CLI::App* subcommand = app.add_subcommand(entry.name, entry.summary);
        commands.emplace_back(subcommand, entry.declare(*subcommand));
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {  // --help, --version
        return app.exit(help);
    } catch (const CLI::ParseError& e) {
        throw InputError(std::string(e.what()) + " (see " + program + " --help)");
    }
    for (const auto& [subcommand, run] : commands)
        if (subcommand->parsed()) return run();
    return 0;  // not reached: a subcommand is required
}

}  // namespace

CLI::Validator isNumber() {
    return CLI::Validator(
        [](std::string& text) {
            const bool blank = text.find_first_not_of(" \t") == std::string::npos;
            return std::string(blank ? "must be a number, is empty" : "");
        },
        "");
}

CLI::Validator isCount() {
    return CLI::Validator(
        [](std::string& text) {
            const bool digits = text.find_first_not_of("0123456789") == std::string::npos;
            return !text.empty() && digits
                       ? std::string()
                       : "'" + text + "' must be a whole number, at least 1";
        },
        "");
}

int runProgram(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int argc, char** argv) {
    std::string error;
    try {
        return runCommand(program, description, entries, argc, argv);
    } catch (const std::bad_alloc&) {
        error = "out of memory";
    } catch (const std::exception& e) {
        error = oneLineCause(e);
    }
    std::cerr << program << ": error: " << error << std::endl;
    return kError;
}

}  // namespace superray
