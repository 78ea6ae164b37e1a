// SPDX-License-Identifier: BSD-3-Clause
#include "engines/peak_memory.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <string>

namespace superray {
namespace {

/// A field of /proc/self/status, in bytes; 0 if absent.
std::uint64_t statusBytes(const std::string& field) {
    std::ifstream status("/proc/self/status");
    std::string name;
    while (status >> name) {
        std::uint64_t kilobytes = 0;
        if (name == field + ":" && status >> kilobytes) return 1024 * kilobytes;
        status.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    return 0;
}

}  // namespace

std::uint64_t residentBytes() {
    return statusBytes("VmRSS");
}

std::optional<std::uint64_t> peakGrowth(const std::function<void()>& work) {
    int pipeEnds[2];
    if (pipe(pipeEnds) != 0) return std::nullopt;
    malloc_trim(0);  // free memory would be used first, and not be seen
    const pid_t child = fork();
    if (child == 0) {
        std::uint64_t growth = 0;
        try {
            const std::uint64_t before = statusBytes("VmRSS");
            work();
            const std::uint64_t peak = statusBytes("VmHWM");
            growth = before > 0 && peak > before ? peak - before : 0;
        } catch (...) {
            growth = 0;
        }
        const bool told = write(pipeEnds[1], &growth, sizeof growth) == sizeof growth;
        _exit(told ? 0 : 1);
    }
    close(pipeEnds[1]);
    std::uint64_t growth = 0;
    const bool told = child > 0 && read(pipeEnds[0], &growth, sizeof growth) == sizeof growth;
    close(pipeEnds[0]);
    if (child > 0) waitpid(child, nullptr, 0);
    if (!told || growth == 0) return std::nullopt;
    return growth;
}

}  // namespace superray
