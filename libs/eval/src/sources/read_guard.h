// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file read_guard.h
/// Recordings are first read in a child process, which may fail.

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace superray {

/// Reads a file ahead of the caller, in a child process of limited memory and time.
///
/// MRPT believes the counts and indices in a stream: a few changed bytes make it take
/// all memory or crash. Other libraries may. The child does the same reading first, step by
/// step, and lets the caller follow; where it dies, the caller gets an error instead. Since
/// equal bytes make equal objects, the caller's own reading takes no more than the child's.
///
/// Limits: memory (address space) 256 MiB, plus 256 times the size of the file, at
/// most half of the machine's memory; processor time 5 s, plus 1 s for each 500 kB of
/// the file (tenfold in builds with sanitizers, which have no limit of memory).
class ReadGuard {
 public:
    /// Reads one step further; false at the end. Errors: InputError.
    using Step = std::function<bool()>;

    /// Starts the child. \param makeStep is called there
    /// \param bytes the size of what is read, where `path` is a folder; else the file's
    /// \throws InputError if no process can be started
    ReadGuard(std::string path, const std::function<Step()>& makeStep,
              std::optional<std::uint64_t> bytes = std::nullopt);
    ~ReadGuard();
    ReadGuard(const ReadGuard&) = delete;
    ReadGuard& operator=(const ReadGuard&) = delete;

    /// Waits until the child has read one step more than at the last call.
    /// \return false if it came to the end
    /// \throws InputError the child's own one, or that it did not survive the step
    bool next();

 private:
    [[noreturn]] void failAsChild(char kind);
    [[noreturn]] void failAsDead();

    std::string path_;
    std::uint64_t bytes_ = 0;
    pid_t child_ = -1;
    int pipe_ = -1;
    std::uint64_t steps_ = 0;
};

}  // namespace superray
