// SPDX-License-Identifier: BSD-3-Clause
#include "file/output_target.h"

#include <superray/storage/atomic_file.h>

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/vfs.h>

#include <cerrno>
#include <filesystem>

#include "file/file_descriptor.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // as the kernel's own limit

std::string folderOf(const std::string& path) {
    const fs::path parent = fs::path(path).parent_path();
    return parent.empty() ? "." : parent.string();
}

/// Links under /proc stand for open files, which have no path to replace.
bool isInProc(const std::string& folder) {
    struct statfs info {};
    return ::statfs(folder.c_str(), &info) == 0 && info.f_type == PROC_SUPER_MAGIC;
}

/// Nobody may write it, or we may not.
bool isReadOnly(const OutputTarget& target) {
    constexpr mode_t kAnyWriter = S_IWUSR | S_IWGRP | S_IWOTH;
    return (target.info.st_mode & kAnyWriter) == 0 ||
           ::faccessat(AT_FDCWD, target.path.c_str(), W_OK, AT_EACCESS) != 0;
}

}  // namespace

std::string OutputTarget::folder() const {
    return folderOf(path);
}

std::string OutputTarget::name() const {
    return fs::path(path).filename().string();
}

std::string pathBehindLinks(const std::string& path) {
    std::string behind = path;
    std::error_code error;
    for (int links = 0; links < kMostLinks && fs::is_symlink(behind, error); ++links) {
        const std::string folder = folderOf(behind);
        if (isInProc(folder)) break;
        const fs::path next = fs::read_symlink(behind, error);
        if (error) break;
        behind = (fs::path(folder) / next).string();
    }
    return behind;
}

OutputTarget findOutputTarget(const std::string& path) {
    if (path.empty()) throw MapFileError("cannot write a file: its name is empty");
    OutputTarget target;
    target.path = pathBehindLinks(path);
    if (::lstat(target.path.c_str(), &target.info) != 0) {
        if (errno != ENOENT) failOnFile("write", path, errno);
        if (target.name().empty()) failOnFile("write", path, EISDIR);
        return target;
    }
    if (S_ISLNK(target.info.st_mode)) {
        if (!isInProc(target.folder())) failOnFile("write", path, ELOOP);
        target.kind = OutputTarget::Kind::stream;
        return target;
    }
    if (S_ISDIR(target.info.st_mode)) failOnFile("write", path, EISDIR);
    target.kind =
        S_ISREG(target.info.st_mode) ? OutputTarget::Kind::file : OutputTarget::Kind::stream;
    if (target.kind == OutputTarget::Kind::file && isReadOnly(target))
        throw MapFileError("cannot write " + path + ": the file is read-only");
    return target;
}

}  // namespace superray
