// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file input_error.h
/// What is wrong with an input, in one readable line.

#include <stdexcept>
#include <string>

namespace superray {

/// An input that cannot be used: names the file, the place and the rule.
class InputError : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Refuses folders, and what may never end: devices, FIFOs, sockets.
/// \throws InputError also if there is nothing
void requireRegularFile(const std::string& path);

/// The cause of an exception in one line. MRPT's exceptions carry several
/// nested messages and call stacks: the innermost message is the cause.
std::string oneLineCause(const std::exception& error);

}  // namespace superray
