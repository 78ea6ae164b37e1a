// SPDX-License-Identifier: BSD-3-Clause
#include "file/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>

#include "file/file_descriptor.h"

namespace superray {

Bytes readWholeFile(const std::string& path) {
    // O_NONBLOCK: do not wait for the writer of a FIFO, refuse it.
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file.isOpen()) failOnFile("open", path, errno);
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) failOnFile("examine", path, errno);
    if (!S_ISREG(info.st_mode))
        throw MapFileError("cannot read " + path + ": not a regular file");
    Bytes contents(static_cast<std::size_t>(info.st_size));
    for (std::size_t at = 0; at < contents.size();) {
        const ssize_t n = ::read(file.get(), contents.data() + at, contents.size() - at);
        if (n < 0 && errno != EINTR) failOnFile("read", path, errno);
        if (n == 0) throw MapFileError("cannot read " + path + ": it became shorter meanwhile");
        if (n > 0) at += static_cast<std::size_t>(n);
    }
    return contents;
}

}  // namespace superray
