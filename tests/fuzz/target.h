// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file target.h
/// What a fuzz target provides: one source file each. With clang, libFuzzer drives it
/// (fuzzer_main.cpp); with any compiler, replay_main.cpp feeds it stored and seeded
/// mutated inputs.

#include <string>
#include <vector>

namespace superray::fuzz {

/// Well-formed inputs to start from.
std::vector<std::string> seeds();

/// Reads one input. Must return: the project's own errors are caught here, all others
/// (crashes, sanitizers, other exceptions) are findings.
void run(const std::string& input);

/// A file with these contents for readers of paths; the same one for all inputs.
std::string asFile(const std::string& input, const std::string& name);

/// The contents of a file of the test data.
std::string testData(const std::string& name);

}  // namespace superray::fuzz
