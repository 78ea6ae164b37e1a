// SPDX-License-Identifier: BSD-3-Clause
#include "sources/read_guard.h"

#include <fcntl.h>
#include <superray/core/detail/sanitizers.h>
#include <superray/eval/input_error.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#include "sources/object_reader.h"

namespace superray {
namespace {

// What the child writes: a byte per step, then one of these, then a message.
constexpr char kStep = 's', kEnd = 'e', kError = 'x', kTruncated = 't', kMemory = 'm';

constexpr std::uint64_t kMegabyte = std::uint64_t{1} << 20;
constexpr std::uint64_t kBaseMemory = 256 * kMegabyte;
constexpr std::uint64_t kMemoryPerByte = 256;  // of a compressed file
constexpr std::uint64_t kBaseSeconds = 5;
constexpr std::uint64_t kBytesPerSecond = 500000;

std::uint64_t sizeOf(const std::string& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    return error ? 0 : size;
}

std::uint64_t memoryLimit(std::uint64_t fileSize) {
    const auto machine = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t most = std::max(machine / 2, kBaseMemory);
    return fileSize > most / kMemoryPerByte
               ? most
               : std::min(most, kBaseMemory + kMemoryPerByte * fileSize);
}

std::uint64_t secondsLimit(std::uint64_t fileSize) {
    return (kBaseSeconds + fileSize / kBytesPerSecond) * (kSanitized ? 10 : 1);
}

/// Addresses in use [bytes].
std::uint64_t addressSpace() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::uint64_t value) {
    struct rlimit limits {};
    ::getrlimit(static_cast<__rlimit_resource_t>(resource), &limits);
    limits.rlim_cur = std::min<rlim_t>(limits.rlim_max, value);
    ::setrlimit(static_cast<__rlimit_resource_t>(resource), &limits);
}

void enterChild(pid_t parent, std::uint64_t fileSize) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGPIPE})
        ::signal(signal, SIG_DFL);
    // What MRPT prints is printed by the parent, too.
    const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, fd);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, secondsLimit(fileSize));
    if (!kSanitized) limit(RLIMIT_AS, addressSpace() + memoryLimit(fileSize));
}

void tell(int pipe, char kind, const char* message = "") {
    const std::size_t length = std::strlen(message);
    if (::write(pipe, &kind, 1) != 1) ::_exit(1);
    for (std::size_t done = 0; done < length;) {
        const ssize_t n = ::write(pipe, message + done, length - done);
        if (n <= 0) ::_exit(1);
        done += static_cast<std::size_t>(n);
    }
}

/// All of the child's life after its limits are set.
void readAhead(int pipe, const std::function<ReadGuard::Step()>& makeStep) {
    try {
        const ReadGuard::Step step = makeStep();
        while (step()) tell(pipe, kStep);
        tell(pipe, kEnd);
    } catch (const std::bad_alloc&) {
        tell(pipe, kMemory);
    } catch (const TruncatedInputError& e) {
        tell(pipe, kTruncated, e.what());
    } catch (const std::exception& e) {
        tell(pipe, kError, e.what());
    }
}

}  // namespace

ReadGuard::ReadGuard(std::string path, const std::function<Step()>& makeStep,
                     std::optional<std::uint64_t> bytes)
    : path_(std::move(path)), bytes_(bytes ? *bytes : sizeOf(path_)) {
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw InputError(path_ + ": cannot be read: " + std::strerror(errno));
    const pid_t parent = ::getpid();
    child_ = ::fork();
    if (child_ == 0) {
        enterChild(parent, bytes_);
        readAhead(ends[1], makeStep);
        ::_exit(0);  // nothing of the parent's is flushed or destroyed
    }
    ::close(ends[1]);
    pipe_ = ends[0];
    if (child_ < 0) {
        ::close(pipe_);
        throw InputError(path_ + ": cannot be read: no process can be started (" +
                         std::strerror(errno) + ")");
    }
}

ReadGuard::~ReadGuard() {
    if (child_ > 0) {
        ::kill(child_, SIGKILL);
        while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) continue;
    }
    ::close(pipe_);
}

bool ReadGuard::next() {
    char kind = 0;
    ssize_t n = 0;
    do n = ::read(pipe_, &kind, 1);
    while (n < 0 && errno == EINTR);
    if (n != 1) failAsDead();
    if (kind == kStep) ++steps_;
    if (kind == kStep || kind == kEnd) return kind == kStep;
    failAsChild(kind);
}

void ReadGuard::failAsChild(char kind) {
    std::string message;
    char part[512];
    for (;;) {
        const ssize_t n = ::read(pipe_, part, sizeof part);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        message.append(part, static_cast<std::size_t>(n));
    }
    if (kind == kTruncated) throw TruncatedInputError(message);
    if (kind == kMemory)
        throw InputError(path_ + ": is damaged: it asks for more than " +
                         std::to_string(memoryLimit(bytes_) / kMegabyte) +
                         " MiB of memory, after " + std::to_string(steps_) + " whole objects");
    throw InputError(message);
}

void ReadGuard::failAsDead() {
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) continue;
    child_ = -1;
    const bool tooLong = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
    const std::string why =
        tooLong
            ? "reading on takes more than " + std::to_string(secondsLimit(bytes_)) +
                  " s of processor time"
            : "reading on crashes the library that reads it" +
                  (WIFSIGNALED(status) ? " (" + std::string(::strsignal(WTERMSIG(status))) + ")"
                                       : std::string());
    throw InputError(path_ + ": is damaged: " + why + ", after " + std::to_string(steps_) +
                     " whole objects");
}

}  // namespace superray
