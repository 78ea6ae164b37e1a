// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file run_program.h
/// Runs one of our programs as a shell does.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "eval/temp_folder.h"

namespace superray::test {

struct ProgramResult {
    int code;
    std::string out, error;
};

/// \param arguments as a shell splits them
inline ProgramResult runProgram(const TempFolder& folder, const std::string& program,
                                const std::string& arguments) {
    const auto out = folder / "stdout", error = folder / "stderr";
    const int status = std::system(
        ("'" + program + "' " + arguments + " >'" + out + "' 2>'" + error + "' </dev/null")
            .c_str());
    EXPECT_TRUE(WIFEXITED(status)) << arguments;
    return {WEXITSTATUS(status), readWholeFile(out), readWholeFile(error)};
}

}  // namespace superray::test
