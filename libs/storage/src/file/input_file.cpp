// SPDX-License-Identifier: BSD-3-Clause
#include "file/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

#include "file/file_descriptor.h"

namespace superray {

namespace {

/// Reads `count` more bytes behind those in `contents`.
void append(int fd, std::size_t count, Bytes& contents, const std::string& path) {
    std::size_t at = contents.size();
    contents.resize(at + count);
    while (at < contents.size()) {
        const ssize_t n = ::read(fd, contents.data() + at, contents.size() - at);
        if (n < 0 && errno != EINTR) failOnFile("read", path, errno);
        if (n == 0) throw MapFileError("cannot read " + path + ": it became shorter meanwhile");
        if (n > 0) at += static_cast<std::size_t>(n);
    }
}

}  // namespace

Bytes readWholeFile(const std::string& path, std::size_t startSize, std::uint64_t most,
                    const CheckStart& check) {
    // O_NONBLOCK: do not wait for the writer of a FIFO, refuse it.
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file.isOpen()) failOnFile("open", path, errno);
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) failOnFile("examine", path, errno);
    if (!S_ISREG(info.st_mode))
        throw MapFileError("cannot read " + path + ": not a regular file");
    const auto size = static_cast<std::uint64_t>(info.st_size);
    Bytes contents;
    append(file.get(), static_cast<std::size_t>(std::min<std::uint64_t>(startSize, size)),
           contents, path);
    check(contents, size);
    if (size > most)
        throw MapFileError("cannot read " + path + ": it has " + std::to_string(size) +
                           " bytes, the limit is " + std::to_string(most) +
                           " (SUPERRAY_MAP_MEGABYTES)");
    append(file.get(), static_cast<std::size_t>(size) - contents.size(), contents, path);
    return contents;
}

}  // namespace superray
