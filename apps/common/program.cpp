// SPDX-License-Identifier: BSD-3-Clause
#include "common/program.h"

#include <superray/core/version.h>
#include <superray/eval/input_error.h>
#include <unistd.h>

#include <fcntl.h>

#include <iostream>
#include <set>
#include <stdexcept>

namespace superray {
namespace {

/// CLI11 takes an empty text for 0.
std::string checkNumber(const std::string& text) {
    const bool blank = text.find_first_not_of(" \t") == std::string::npos;
    return blank ? "must be a number, is empty" : "";
}

/// CLI11 takes -1 for the largest number.
std::string checkCount(const std::string& text) {
    const bool digits = text.find_first_not_of("0123456789") == std::string::npos;
    return !text.empty() && digits ? "" : "'" + text + "' must be a whole number, at least 1";
}

/// The type name of an option, as help shows it, tells what values it takes.
void checkNumbers(CLI::App& command) {
    const std::set<std::string> counts = {"N", "K"};
    const std::set<std::string> numbers = {"METRES",   "DEGREES", "METRES,DEGREES", "SECONDS",
                                           "HZ",       "MB",      "PIXELS",         "P",
                                           "LOW,HIGH", "VALUE"};
    for (CLI::Option* option : command.get_options({})) {
        if (counts.count(option->get_type_name()) > 0)
            option->check(CLI::Validator(checkCount, ""));
        else if (numbers.count(option->get_type_name()) > 0)
            option->check(CLI::Validator(checkNumber, ""));
    }
}

/// Keeps the line breaks of footers and descriptions, which CLI11 2.5 and later makes
/// paragraphs of.
template <class Formatter>
auto keepLines(Formatter& formatter, int)
    -> decltype(formatter.enable_footer_formatting(false), void()) {
    formatter.enable_footer_formatting(false);
    formatter.enable_description_formatting(false);
}
/// Earlier ones keep them.
template <class Formatter>
void keepLines(Formatter&, long) {}

int runCommand(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int argc, char** argv) {
    CLI::App app(description, program);
    app.require_subcommand(1);
    app.set_version_flag("--version", program + " " SUPERRAY_VERSION);
    app.get_formatter()->column_width(28);
    keepLines(*app.get_formatter(), 0);
    std::vector<std::pair<const CLI::App*, Command>> commands;
    for (const CommandEntry& entry : entries) {
        CLI::App* subcommand = app.add_subcommand(entry.name, entry.summary);
        commands.emplace_back(subcommand, entry.declare(*subcommand));
        checkNumbers(*subcommand);
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

/// Standard streams that the caller closed lead nowhere: else the next file that is
/// opened gets their numbers, and what is printed goes into it.
void openStandardStreams() {
    constexpr int kStandardStreams = 3;
    int fd = -1;
    do fd = open("/dev/null", O_RDWR);  // the lowest number that is free
    while (fd >= 0 && fd < kStandardStreams);
    if (fd >= kStandardStreams) close(fd);
}

/// \throws std::runtime_error if not all could be printed (a full disk)
void finishPrinting() {
    std::cout.flush();
    if (!std::cout) throw std::runtime_error("cannot write to the standard output");
}

}  // namespace

int runProgram(const std::string& program, const std::string& description,
               const std::vector<CommandEntry>& entries, int argc, char** argv) {
    std::string error;
    try {
        openStandardStreams();
        const int code = runCommand(program, description, entries, argc, argv);
        finishPrinting();
        return code;
    } catch (const std::bad_alloc&) {
        error = "out of memory";
    } catch (const std::exception& e) {
        error = oneLineCause(e);
    }
    std::cerr << program << ": error: " << error << std::endl;
    return kError;
}

}  // namespace superray
