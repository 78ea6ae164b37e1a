// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cpu_target.h
/// The instruction set of this processor that vector code uses: one choice for
/// all of it. Every set gives the same bits; only the time differs.

#include <optional>
#include <string>

namespace superray {

/// Ascending: a processor that has one of them has those before it.
enum class InstructionSet {
    portable,  ///< what the compiler assumes anyway: SSE2 on x86-64, NEON on
               ///< aarch64
    avx2,      ///< AVX2
    avx512     ///< AVX-512 F, VL, DQ and BW (servers since 2017, Zen 4)
};
const char* toString(InstructionSet set);
/// Nothing for other names than those of the enumeration.
std::optional<InstructionSet> instructionSetFromString(const std::string& name);

/// The best one that this processor has.
InstructionSet bestInstructionSet();

/// What to use, and what to tell the user ("" for nothing).
struct InstructionSetChoice {
    InstructionSet set;
    std::string warning;
};
/// \param asked value of the environment variable, or nullptr if it is not set.
/// A better set than `best` and a name that is none are warned of; then it is
/// `best`.
InstructionSetChoice chooseInstructionSet(const char* asked, InstructionSet best);

/// The set that walks and folds use: the best one, unless the environment
/// variable SUPERRAY_INSTRUCTION_SET = portable | avx2 | avx512 asks for a
/// lesser one. Read once in a process; a warning goes to stderr.
InstructionSet instructionSet();

}  // namespace superray
