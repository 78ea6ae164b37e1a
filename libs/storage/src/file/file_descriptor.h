// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file file_descriptor.h
/// An open file, closed at the end of its scope; errors as MapFileError.

#include <superray/storage/map_file_error.h>

#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

namespace superray {

/// \param what e.g. "write" \param error an errno
[[noreturn]] inline void failOnFile(const std::string& what, const std::string& path,
                                    int error) {
    throw MapFileError("cannot " + what + " " + path + ": " +
                       std::generic_category().message(error));
}

class FileDescriptor {
 public:
    /// \param fd negative: none
    explicit FileDescriptor(int fd = -1) : fd_(fd) {}
    ~FileDescriptor() { close(); }
    FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    int get() const { return fd_; }
    bool isOpen() const { return fd_ >= 0; }
    /// \return false on failure (data may be lost: errors surface here, too)
    bool close() { return fd_ < 0 || ::close(std::exchange(fd_, -1)) == 0; }

 private:
    int fd_;
};

}  // namespace superray
