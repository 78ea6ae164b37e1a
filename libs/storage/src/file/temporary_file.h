// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file temporary_file.h
/// The file beside a target that takes its place.

#include <string>

#include "file/file_descriptor.h"
#include "file/output_target.h"

namespace superray {

/// A locked file beside a target; goes away unless it is put in the target's place.
class TemporaryFile {
 public:
    /// Removes, too, what killed writers of the same target left.
    /// \throws MapFileError
    explicit TemporaryFile(const OutputTarget& target);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    int fd() const { return file_.get(); }
    const std::string& path() const { return path_; }
    /// Syncs, takes over mode and owner, renames, syncs the folder. Once only.
    /// \throws MapFileError
    void replaceTarget();

 private:
    void create();
    void copyOwnerAndMode() const;

    const OutputTarget target_;
    FileDescriptor folder_;  ///< none if it cannot be read (it can be written then)
    std::string path_;       ///< empty: nothing to remove
    FileDescriptor file_;
};

}  // namespace superray
