// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file atomic_file.h
/// Output files that are whole or not there; see doc/reliability.md, "Outputs".

#include <superray/storage/map_file_error.h>

#include <cstddef>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>

namespace superray {

/// An output file that replaces the old one when it is whole.
///
/// The bytes go to a file of an unpredictable name beside the target
/// (`NAME.<16 hex digits>.superray-tmp`). commit() writes them out, syncs, renames
/// and syncs the folder. Whatever happens before (an error, a full disk, a kill,
/// a power cut), the target holds the old contents; after, the new ones. Two
/// writers of one target do not mix: the last one to commit wins.
///
/// What the path may be:
/// - a new name: the mode is 0666 without the bits of the umask;
/// - a regular file: its mode is kept, and its owner and group if the process may
///   set them (else the group's rights shrink to those of others). Other hard links
///   to it keep the old contents. Access control lists are not copied;
/// - a file without write permission: refused, also for root;
/// - a symbolic link: its target is replaced (or made), the link stays;
/// - a FIFO or a device, directly or by a link (/dev/stdout): written as the bytes
///   come, since there is nothing to replace;
/// - a folder: refused.
///
/// A kill leaves the temporary file. The next writer of the same target removes
/// those whose writers are gone (they hold a lock while they live), and no others.
///
/// Not thread-safe; two objects are independent.
class AtomicFile {
 public:
    /// Makes the temporary file. \throws MapFileError naming path and cause
    explicit AtomicFile(const std::string& path);
    /// Removes the temporary file unless commit() succeeded.
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Buffered. \throws MapFileError, now and at each later call
    void write(const void* data, std::size_t size);
    /// Puts the file in place of the old one. \throws MapFileError; then the old
    /// one is still there (unless only the sync of the folder failed)
    void commit();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// An AtomicFile for what writes to streams. Errors set badbit; commit() throws the
/// first one.
class AtomicStream : public std::ostream {
 public:
    /// \throws MapFileError
    explicit AtomicStream(const std::string& path);
    ~AtomicStream() override;
    /// As of AtomicFile; also throws if the stream failed before.
    void commit();

 private:
    class Buffer;
    std::unique_ptr<Buffer> buffer_;
};

/// Whole file from memory. \throws MapFileError
void writeFileAtomically(const std::string& path, std::string_view contents);

/// Where a path leads: what it names behind symbolic links, also links to what is not there
/// yet. Links under /proc (open files) and links in a circle are left as they are.
std::string pathBehindLinks(const std::string& path);

/// Checks, before long work, what can be known of an output: the rules of
/// AtomicFile, and that its folder is there and can be written to.
/// \throws MapFileError
void checkOutputFile(const std::string& path);

}  // namespace superray
