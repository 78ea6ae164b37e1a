// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Runs something that may do harm in a process of its own.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <string>

namespace superray::test {

/// Runs `action` in a child, with at most 10 s of processor time and a minute in all.
/// \param harm becomes what was wrong: killed by a signal (also that of a limit), or more
///        than a gigabyte of memory; else empty
/// \return what the action returned; -1 if a signal ended it
template <class Action>
int runLimited(const Action& action, std::string& harm) {
    const pid_t child = ::fork();
    if (child == 0) {
        constexpr rlim_t kSeconds = 10;
        constexpr unsigned kHangs = 60;
        const struct rlimit most = {kSeconds, kSeconds};
        ::setrlimit(RLIMIT_CPU, &most);
        ::alarm(kHangs);
        ::_exit(action());
    }
    int status = 0;
    struct rusage usage {};
    EXPECT_EQ(::wait4(child, &status, 0, &usage), child);
    constexpr long kGigabyteInKilobytes = 1 << 20;
    harm.clear();
    if (usage.ru_maxrss > kGigabyteInKilobytes) harm = std::to_string(usage.ru_maxrss) + " kB";
    if (WIFSIGNALED(status)) harm = ::strsignal(WTERMSIG(status));
    return WIFSIGNALED(status) ? -1 : WEXITSTATUS(status);
}

}  // namespace superray::test
