// SPDX-License-Identifier: BSD-3-Clause
#include "common/program.h"

#include <superray/core/version.h>
#include <superray/eval/input_error.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/option_text.h>
#include <unistd.h>

#include <fcntl.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <set>
#include <stdexcept>

namespace superray {
namespace {

bool isBlank(const std::string& text) {
    return text.find_first_not_of(" \t") == std::string::npos;
}

/// CLI11 takes an empty text for 0. What is not a number fails every comparison.
std::string checkNumber(const std::string& text) {
    if (isBlank(text)) return "must be a number, is empty";
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != '\0' || std::isnan(value)) return "'" + shortened(text) + "' is not a number";
    const bool hasDigits = text.find_first_of("0123456789") != std::string::npos;
    return std::isinf(value) && hasDigits ? "'" + shortened(text) + "' is out of range" : "";
}

bool isWhole(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// CLI11 takes -1 for the largest number.
std::string checkCount(const std::string& text) {
    return isWhole(text) ? "" : "'" + shortened(text) + "' must be a whole number, at least 1";
}
std::string checkMegabytes(const std::string& text) {
    return isWhole(text) ? "" : "'" + shortened(text) + "' must be a whole number, at least 0";
}

/// A shell variable that is not set must not count as an option that is not given.
std::string checkText(const std::string& text) {
    return text.find_first_not_of(" \t,") == std::string::npos ? "must not be empty" : "";
}

/// The type name of an option, as help shows it, tells what values it takes.
void checkValues(CLI::App& command) {
    const std::set<std::string> counts = {"N", "K"};
    const std::set<std::string> numbers = {"METRES",  "DEGREES", "METRES,DEGREES",
                                           "SECONDS", "HZ",      "PIXELS",
                                           "P",       "VALUE",   "LOW,HIGH"};
    for (CLI::Option* option : command.get_options({})) {
        const std::string type = option->get_type_name();
        const bool isFlag = option->get_items_expected_max() == 0;
        if (counts.count(type) > 0)
            option->check(CLI::Validator(checkCount, ""));
        else if (type == "MB")
            option->check(CLI::Validator(checkMegabytes, ""));
        else if (numbers.count(type) > 0)
            option->check(CLI::Validator(checkNumber, ""));
        else if (!isFlag)
            option->check(CLI::Validator(checkText, ""));
    }
}

/// No output may be what is read, nor another output: of the options of all commands.
void checkFiles(const CLI::App& command) {
    std::vector<std::string> inputs, outputs;
    for (const CLI::Option* option : command.get_options({})) {
        const std::string type = option->get_type_name();
        auto& files = type == "OUTPUT" ? outputs : inputs;
        if (type == "OUTPUT" || type == "FILE" || type == "DATA")
            files.insert(files.end(), option->results().begin(), option->results().end());
    }
    checkOutputsApart(inputs, outputs);
}

/// Counts are digits and numbers are numbers by now: what CLI11 cannot convert is too large.
std::string describe(const CLI::ConversionError& error) {
    const std::string prefix = "Could not convert: ";
    std::string text = error.what();
    if (text.rfind(prefix, 0) != 0) return text;
    return shortened(text.substr(prefix.size())) + ": is out of range";
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
        checkValues(*subcommand);
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {  // --help, --version
        return app.exit(help);
    } catch (const CLI::ConversionError& e) {
        throw InputError(describe(e) + " (see " + program + " --help)");
    } catch (const CLI::ParseError& e) {
        throw InputError(std::string(e.what()) + " (see " + program + " --help)");
    }
    for (const auto& [subcommand, run] : commands) {
        if (!subcommand->parsed()) continue;
        checkFiles(*subcommand);
        return run();
    }
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
