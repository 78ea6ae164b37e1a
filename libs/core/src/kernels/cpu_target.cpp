// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/cpu_target.h>

#include <cstdlib>
#include <iostream>

namespace superray {
namespace {

constexpr const char* kVariable = "SUPERRAY_INSTRUCTION_SET";

}  // namespace

const char* toString(InstructionSet set) {
    switch (set) {
        case InstructionSet::avx512:
            return "avx512";
        case InstructionSet::avx2:
            return "avx2";
        case InstructionSet::portable:
            break;
    }
    return "portable";
}

std::optional<InstructionSet> instructionSetFromString(const std::string& name) {
    for (InstructionSet set :
         {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512})
        if (name == toString(set)) return set;
    return std::nullopt;
}

InstructionSet bestInstructionSet() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
            return InstructionSet::avx512;
        return InstructionSet::avx2;
    }
#endif
    return InstructionSet::portable;
}

InstructionSetChoice chooseInstructionSet(const char* asked, InstructionSet best) {
    if (asked == nullptr || *asked == '\0') return {best, ""};
    const std::string said = std::string("superray: ") + kVariable + "=" + asked;
    const std::string instead = std::string("; using ") + toString(best);
    const auto set = instructionSetFromString(asked);
    if (!set) return {best, said + " is none of portable, avx2, avx512" + instead};
    if (*set > best) return {best, said + " is more than this processor has" + instead};
    return {*set, ""};
}

InstructionSet instructionSet() {
    static const InstructionSet chosen = [] {
        const auto choice = chooseInstructionSet(std::getenv(kVariable), bestInstructionSet());
        if (!choice.warning.empty()) std::cerr << choice.warning << std::endl;
        return choice.set;
    }();
    return chosen;
}

}  // namespace superray
