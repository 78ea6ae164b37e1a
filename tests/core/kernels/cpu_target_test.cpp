// SPDX-License-Identifier: BSD-3-Clause
// The choice of an instruction set: what the user asks for, what the processor has.

#include <superray/core/detail/cpu_target.h>

#include <gtest/gtest.h>

#include <cstdlib>

namespace superray {
namespace {

constexpr InstructionSet kAll[] = {InstructionSet::portable, InstructionSet::avx2,
                                   InstructionSet::avx512};

TEST(CpuTarget, NamesRoundTrip) {
    for (InstructionSet set : kAll) EXPECT_EQ(instructionSetFromString(toString(set)), set);
    EXPECT_FALSE(instructionSetFromString("AVX2"));
    EXPECT_FALSE(instructionSetFromString(""));
}

TEST(CpuTarget, BestIfNothingIsAsked) {
    for (InstructionSet best : kAll)
        for (const char* asked : {static_cast<const char*>(nullptr), ""}) {
            const InstructionSetChoice choice = chooseInstructionSet(asked, best);
            EXPECT_EQ(choice.set, best);
            EXPECT_EQ(choice.warning, "");
        }
}

TEST(CpuTarget, LesserOnesAreUsedAsAsked) {
    for (InstructionSet best : kAll)
        for (InstructionSet asked : kAll) {
            const InstructionSetChoice choice = chooseInstructionSet(toString(asked), best);
            EXPECT_EQ(choice.set, asked <= best ? asked : best);
            EXPECT_EQ(choice.warning.empty(), asked <= best);
        }
}

TEST(CpuTarget, WarningsNameTheVariableTheValueAndTheRule) {
    EXPECT_EQ(chooseInstructionSet("sse9", InstructionSet::avx2).warning,
              "superray: SUPERRAY_INSTRUCTION_SET=sse9 is none of portable, avx2, avx512; "
              "using avx2");
    EXPECT_EQ(chooseInstructionSet("avx512", InstructionSet::avx2).warning,
              "superray: SUPERRAY_INSTRUCTION_SET=avx512 is more than this processor has; "
              "using avx2");
}

TEST(CpuTarget, WarnsOnceInAProcess) {
    const auto askTwice = [] {
        setenv("SUPERRAY_INSTRUCTION_SET", "fastest", 1);
        const bool same = instructionSet() == bestInstructionSet() &&
                          instructionSet() == bestInstructionSet();
        std::exit(same ? 0 : 1);
    };
    ::testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(askTwice(), ::testing::ExitedWithCode(0),
                "^superray: SUPERRAY_INSTRUCTION_SET=fastest is none of [^\n]*\n$");
}

}  // namespace
}  // namespace superray
