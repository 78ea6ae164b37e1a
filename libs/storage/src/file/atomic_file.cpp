// SPDX-License-Identifier: BSD-3-Clause
#include "file/atomic_file.h"

#include <superray/storage/map_file_error.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

namespace superray {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what, const std::string& path, int error) {
    throw MapFileError("cannot " + what + " " + path + ": " +
                       std::generic_category().message(error));
}

/// An open file descriptor.
class Descriptor {
 public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }
    /// \return false on failure (data may be lost: errors surface here, too)
    bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
    int fd_;
};

/// A file that goes away unless it is renamed.
class TemporaryFile {
 public:
    explicit TemporaryFile(const std::string& target) {
        static std::atomic<unsigned> counter{0};
        do {
            path_ =
                target + ".tmp" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
            fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (fd_ < 0 && errno == EEXIST);
        if (fd_ < 0) fail("create", path_, errno);
    }
    ~TemporaryFile() {
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    int fd() const { return fd_; }
    const std::string& path() const { return path_; }
    void renameTo(const std::string& target) {
        if (::rename(path_.c_str(), target.c_str()) != 0) fail("replace", target, errno);
        path_.clear();
    }

 private:
    std::string path_;
    int fd_ = -1;
};

void writeAll(int fd, const Bytes& contents, const std::string& path) {
    for (std::size_t at = 0; at < contents.size();) {
        const ssize_t n = ::write(fd, contents.data() + at, contents.size() - at);
        if (n < 0 && errno != EINTR) fail("write", path, errno);
        if (n > 0) at += static_cast<std::size_t>(n);
    }
}

/// Makes a rename in `directory` last.
void syncDirectory(const fs::path& directory) {
    const Descriptor d(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (d.get() < 0) fail("open", directory, errno);
    // Some file systems cannot sync directories and say EINVAL.
    if (::fsync(d.get()) != 0 && errno != EINVAL) fail("sync", directory, errno);
}

/// The file to replace: links resolved; no devices or directories.
fs::path replaceable(const std::string& path) {
    std::error_code error;
    fs::path target = path;
    if (fs::is_symlink(target, error)) {
        target = fs::canonical(target, error);
        if (error) fail("follow the link", path, error.value());
    }
    if (fs::exists(target, error) && !fs::is_regular_file(target, error))
        throw MapFileError("cannot write " + path + ": it exists and is not a regular file");
    return target;
}

}  // namespace

void writeFileAtomically(const std::string& path, const Bytes& contents) {
    const fs::path target = replaceable(path);
    TemporaryFile temporary(target);
    {
        Descriptor file(temporary.fd());
        writeAll(file.get(), contents, temporary.path());
        if (::fsync(file.get()) != 0) fail("sync", temporary.path(), errno);
        if (!file.close()) fail("close", temporary.path(), errno);
    }
    temporary.renameTo(target);
    syncDirectory(target.has_parent_path() ? target.parent_path() : fs::path("."));
}

Bytes readWholeFile(const std::string& path) {
    // O_NONBLOCK: do not wait for the writer of a FIFO, refuse it.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.get() < 0) fail("open", path, errno);
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) fail("examine", path, errno);
    if (!S_ISREG(info.st_mode))
        throw MapFileError("cannot read " + path + ": not a regular file");
    Bytes contents(static_cast<std::size_t>(info.st_size));
    for (std::size_t at = 0; at < contents.size();) {
        const ssize_t n = ::read(file.get(), contents.data() + at, contents.size() - at);
        if (n < 0 && errno != EINTR) fail("read", path, errno);
        if (n == 0) throw MapFileError("cannot read " + path + ": it became shorter meanwhile");
        if (n > 0) at += static_cast<std::size_t>(n);
    }
    return contents;
}

}  // namespace superray
