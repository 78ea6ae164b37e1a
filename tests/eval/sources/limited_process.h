// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Runs what may do harm in processes of their own.

#include <gtest/gtest.h>
#include <superray/core/detail/sanitizers.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace superray::test {

/// What became of a run.
struct LimitedRun {
    int result = -1;   ///< of the action; -1 if it did not end
    std::string harm;  ///< a signal (also that of a limit), or too much memory; else empty
};

/// Results that a child leaves to its parent.
class SharedResults {
 public:
    static constexpr int kNone = -1;

    explicit SharedResults(std::size_t count) : bytes_(count * sizeof(int)) {
        values_ = static_cast<int*>(
            ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
        if (values_ == MAP_FAILED) throw std::runtime_error("mmap failed");
        for (std::size_t i = 0; i < count; ++i) values_[i] = kNone;
    }
    ~SharedResults() { ::munmap(values_, bytes_); }
    SharedResults(const SharedResults&) = delete;
    SharedResults& operator=(const SharedResults&) = delete;

    volatile int& operator[](std::size_t i) { return values_[i]; }

 private:
    std::size_t bytes_;
    int* values_ = nullptr;
};

/// Runs action(0) to action(count - 1) in a child, with at most 10 s of processor time and a
/// gigabyte of memory for all of them; after one that does harm the others in another child.
/// \param action returns its result, at least 0
template <class Action>
std::vector<LimitedRun> runLimited(std::size_t count, const Action& action) {
    std::vector<LimitedRun> runs(count);
    SharedResults results(count);
    for (std::size_t next = 0; next < count;) {
        const pid_t child = ::fork();
        if (child == 0) {
            constexpr rlim_t kSeconds = 10;
            constexpr unsigned kHangs = 600;  // [s], on a machine that is busy otherwise
            const struct rlimit most = {kSeconds, kSeconds};
            ::setrlimit(RLIMIT_CPU, &most);
            ::alarm(kHangs);
            for (std::size_t i = next; i < count; ++i) results[i] = action(i);
            ::_exit(0);
        }
        int status = 0;
        struct rusage usage {};
        EXPECT_EQ(::wait4(child, &status, 0, &usage), child);
        while (next < count && results[next] != SharedResults::kNone) {
            runs[next].result = results[next];
            ++next;
        }
        constexpr long kMostKilobytes =
            kSanitized ? std::numeric_limits<long>::max() : 1 << 20;  // a gigabyte
        if (usage.ru_maxrss > kMostKilobytes)
            runs[std::min(next, count - 1)].harm =
                std::to_string(usage.ru_maxrss) + " kB, in this run or one before it";
        if (next == count) break;
        runs[next++].harm =
            WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : "the process ended";
    }
    return runs;
}

}  // namespace superray::test
