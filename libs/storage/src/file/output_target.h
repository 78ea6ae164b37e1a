// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file output_target.h
/// What an output path leads to, and whether it may be written.

#include <sys/stat.h>

#include <string>

namespace superray {

struct OutputTarget {
    enum class Kind {
        newFile,  ///< nothing is there
        file,     ///< a regular file, to be replaced
        stream    ///< a FIFO, a device or an open file under /proc: written directly
    };
    Kind kind = Kind::newFile;
    std::string path;     ///< of newFile and file: no symbolic link
    struct stat info {};  ///< of file

    /// The folder that holds it.
    std::string folder() const;
    /// The last part of its path.
    std::string name() const;
};

/// Follows links (also those that lead nowhere yet) and applies the rules of
/// AtomicFile. \throws MapFileError
OutputTarget findOutputTarget(const std::string& path);

}  // namespace superray
