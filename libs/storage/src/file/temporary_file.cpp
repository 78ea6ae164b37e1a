// SPDX-License-Identifier: BSD-3-Clause
#include "file/temporary_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdint>
#include <random>

namespace superray {
namespace {

const std::string kSuffix = ".superray-tmp";
constexpr std::size_t kRandomDigits = 16;

/// What names of temporary files of a target begin with. Long names are cut: the
/// whole must be a name of a file, too.
std::string prefixOf(const OutputTarget& target) {
    const std::size_t most = NAME_MAX - kRandomDigits - kSuffix.size() - 1;
    return target.name().substr(0, most) + ".";
}

std::string randomDigits() {
    std::random_device random;  // the system's generator: nobody can foresee it
    std::string digits;
    while (digits.size() < kRandomDigits) {
        constexpr char kHex[] = "0123456789abcdef";
        digits += kHex[random() % 16];
    }
    return digits;
}

/// Whether a name is one that create() makes for `prefix`.
bool isTemporaryName(const std::string& name, const std::string& prefix) {
    if (name.size() != prefix.size() + kRandomDigits + kSuffix.size()) return false;
    if (name.compare(0, prefix.size(), prefix) != 0) return false;
    if (name.compare(name.size() - kSuffix.size(), kSuffix.size(), kSuffix) != 0) return false;
    const auto digits = name.substr(prefix.size(), kRandomDigits);
    return digits.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Writers hold the lock of their file: what can be locked has no writer.
void removeIfAbandoned(int folder, const char* name) {
    const FileDescriptor file(
        ::openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    struct stat opened {
    }, named{};
    if (!file.isOpen() || ::fstat(file.get(), &opened) != 0) return;
    if (!S_ISREG(opened.st_mode) || opened.st_uid != ::geteuid()) return;
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) return;
    if (::fstatat(folder, name, &named, AT_SYMLINK_NOFOLLOW) != 0) return;
    if (named.st_dev != opened.st_dev || named.st_ino != opened.st_ino) return;
    ::unlinkat(folder, name, 0);
}

void removeAbandoned(int folder, const std::string& prefix) {
    const int fd = ::fcntl(folder, F_DUPFD_CLOEXEC, 0);
    DIR* const entries = fd < 0 ? nullptr : ::fdopendir(fd);
    if (entries == nullptr) {
        if (fd >= 0) ::close(fd);
        return;
    }
    while (const dirent* entry = ::readdir(entries))
        if (isTemporaryName(entry->d_name, prefix)) removeIfAbandoned(folder, entry->d_name);
    ::closedir(entries);
}

}  // namespace

TemporaryFile::TemporaryFile(const OutputTarget& target) : target_(target) {
    folder_ =
        FileDescriptor(::open(target.folder().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    // A folder may be writable without being readable.
    if (!folder_.isOpen() && errno != EACCES) failOnFile("open", target.folder(), errno);
    if (folder_.isOpen()) removeAbandoned(folder_.get(), prefixOf(target));
    create();
}

TemporaryFile::~TemporaryFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

void TemporaryFile::create() {
    // Nobody else may read a file whose mode is not yet that of the target.
    const mode_t mode = target_.kind == OutputTarget::Kind::file ? 0600 : 0666;
    for (;;) {
        const std::string path =
            target_.folder() + "/" + prefixOf(target_) + randomDigits() + kSuffix;
        file_ =
            FileDescriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
        if (!file_.isOpen() && errno == EEXIST) continue;
        if (!file_.isOpen()) failOnFile("create", path, errno);
        // Another writer may take the file for an abandoned one before it is locked.
        // File systems without locks say so otherwise: then nothing is ever removed.
        const bool taken = ::flock(file_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        struct stat info {};
        if (taken || (::fstat(file_.get(), &info) == 0 && info.st_nlink == 0)) continue;
        path_ = path;
        return;
    }
}

void TemporaryFile::copyOwnerAndMode() const {
    const struct stat& old = target_.info;
    struct stat now {};
    if (::fstat(fd(), &now) != 0) failOnFile("examine", path_, errno);
    mode_t mode = old.st_mode & 07777;
    const bool sameOwner =
        now.st_uid == old.st_uid || ::fchown(fd(), old.st_uid, static_cast<gid_t>(-1)) == 0;
    const bool sameGroup =
        now.st_gid == old.st_gid || ::fchown(fd(), static_cast<uid_t>(-1), old.st_gid) == 0;
    if (!sameOwner || !sameGroup) mode &= 0777;
    // Another group must not get more rights than everybody has.
    if (!sameGroup) mode = (mode & ~mode_t{S_IRWXG}) | (mode & (mode << 3) & S_IRWXG);
    if (::fchmod(fd(), mode) != 0) failOnFile("set the mode of", path_, errno);
}

void TemporaryFile::replaceTarget() {
    if (target_.kind == OutputTarget::Kind::file) copyOwnerAndMode();
    if (::fsync(fd()) != 0) failOnFile("sync", path_, errno);
    // Closing may tell of lost data, but it ends the lock: rename first would do no
    // better, so the lock is kept by a second descriptor.
    const FileDescriptor lock(::fcntl(fd(), F_DUPFD_CLOEXEC, 0));
    if (!file_.close()) failOnFile("close", path_, errno);
    if (::rename(path_.c_str(), target_.path.c_str()) != 0)
        failOnFile("replace", target_.path, errno);
    path_.clear();
    // Some file systems cannot sync folders and say EINVAL.
    if (folder_.isOpen() && ::fsync(folder_.get()) != 0 && errno != EINVAL)
        failOnFile("sync", target_.folder(), errno);
}

}  // namespace superray
