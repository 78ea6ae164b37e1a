// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file compressed_input.h
/// A gzip, zstd or plain file as an MRPT stream.

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <memory>
#include <string>

namespace superray {

/// How the bytes of a file are packed.
enum class Compression : std::uint8_t { none, gzip, zstd };

/// Reads gzip, zstd and plain files, recognised by their first bytes (never by
/// their names), whichever of them the installed MRPT knows: MRPT writes gzip
/// before 2.15.7, and zstd from then on.
///
/// Tells a whole file from a broken one (MRPT's own streams take a truncated
/// file for a shorter one). Gzip members and zstd frames may follow each other.
/// Memory: two buffers and the window of the compression, whatever the size of
/// the file.
///
/// What is noticed: truncation, always. Changed bytes: in gzip by the CRC-32 at the
/// end of each member, in zstd by the checksum at the end of each frame *if it has
/// one*. MRPT 2.15 writes zstd without checksums: of a changed byte there is
/// noticed what breaks the format of zstd or that of MRPT's objects, but not, say,
/// another value in a table of coordinates. `zstd --check` adds checksums.
class CompressedInput final : public mrpt::io::CStream {
 public:
    /// \throws std::runtime_error if the file cannot be opened: names file and cause
    explicit CompressedInput(const std::string& path);
    ~CompressedInput() override;
    CompressedInput(const CompressedInput&) = delete;
    CompressedInput& operator=(const CompressedInput&) = delete;

    Compression compression() const;
    /// True if no byte is left, or none can be read: see error().
    bool atEnd();
    /// What is wrong with the compressed data so far, and what to do about it;
    /// empty if nothing.
    std::string error() const;
    /// True if error() is: the file ends before the compressed data do.
    bool truncated() const;
    /// Bytes of the file consumed so far (compressed), and its size.
    std::uint64_t fileOffset() const;
    std::uint64_t fileSize() const;

    /// Fewer bytes than `count` only at the end, or before an error.
    std::size_t Read(void* buffer, std::size_t count) override;
    /// Puts bytes that were read back before those that come next.
    void unread(const std::string& bytes);
    std::size_t Write(const void*, std::size_t) override { return 0; }
    std::uint64_t Seek(std::int64_t, CStream::TSeekOrigin) override { return getPosition(); }
    std::uint64_t getTotalBytesCount() const override { return fileSize(); }
    /// Bytes read so far (decompressed).
    std::uint64_t getPosition() const override;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace superray
