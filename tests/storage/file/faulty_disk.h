// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file faulty_disk.h
/// System calls of outputs that fail on demand. Include it in one source file of a
/// test: it replaces the C library's functions in the whole program.

#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fcntl.h>
#include <atomic>
#include <cerrno>
#include <cstdarg>

namespace superray::test {

/// Makes calls fail while it lives: making a file, write, fsync, fchmod, rename.
class FaultyDisk {
 public:
    enum class Failure { once, forEver };

    /// \param succeeding so many calls succeed, the next one fails with ENOSPC
    explicit FaultyDisk(int succeeding, Failure failure) {
        failure_ = failure;
        calls_ = 0;
        failed_ = 0;
        left_ = succeeding;
        on_ = true;
    }
    ~FaultyDisk() { on_ = false; }
    FaultyDisk(const FaultyDisk&) = delete;
    FaultyDisk& operator=(const FaultyDisk&) = delete;

    static int calls() { return calls_; }
    static int failed() { return failed_; }

    /// Called by each of the replaced functions; true: fail.
    static bool fails() {
        if (!on_) return false;
        ++calls_;
        const int left = left_--;
        if (left > 0 || (left < 0 && failure_ == Failure::once)) return false;
        ++failed_;
        errno = ENOSPC;
        return true;
    }

 private:
    static inline std::atomic<bool> on_{false};
    static inline std::atomic<int> left_{0}, calls_{0}, failed_{0};
    static inline std::atomic<Failure> failure_{Failure::once};
};

/// Not what the test itself prints.
inline bool isOutputOfTest(int fd) {
    return fd > STDERR_FILENO;
}

}  // namespace superray::test

extern "C" {
ssize_t write(int fd, const void* data, size_t size) {
    using namespace superray::test;
    if (isOutputOfTest(fd) && FaultyDisk::fails()) return -1;
    return syscall(SYS_write, fd, data, size);
}
int fsync(int fd) {
    return superray::test::FaultyDisk::fails() ? -1 : static_cast<int>(syscall(SYS_fsync, fd));
}
int fchmod(int fd, mode_t mode) noexcept {
    return superray::test::FaultyDisk::fails()
               ? -1
               : static_cast<int>(syscall(SYS_fchmod, fd, mode));
}
int rename(const char* from, const char* to) noexcept {
    return superray::test::FaultyDisk::fails()
               ? -1
               : static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int open(const char* path, int flags, ...) {
    mode_t mode = 0;
    if ((flags & O_CREAT) != 0) {
        va_list arguments;
        va_start(arguments, flags);
        mode = va_arg(arguments, mode_t);
        va_end(arguments);
        if (superray::test::FaultyDisk::fails()) return -1;
    }
    return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}
}  // extern "C"
