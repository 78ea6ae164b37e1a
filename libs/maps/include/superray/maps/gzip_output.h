// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file gzip_output.h
/// MRPT objects in files that every MRPT opens, whole or not at all.

#include <mrpt/io/CStream.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <memory>
#include <string>

namespace superray {

/// A gzip file to write MRPT objects to; it replaces the old file at commit(), by the
/// rules of AtomicFile. The `saveToFile` of MRPT's classes writes zstd from 2.15.7 on,
/// which no earlier MRPT opens, and leaves a cut file on a full disk.
class GzipOutput final : public mrpt::io::CStream {
 public:
    /// \throws MapFileError
    explicit GzipOutput(const std::string& path);
    ~GzipOutput() override;
    GzipOutput(const GzipOutput&) = delete;
    GzipOutput& operator=(const GzipOutput&) = delete;

    /// Always writes all. \throws MapFileError
    std::size_t Write(const void* buffer, std::size_t count) override;
    /// Nothing can be written after it. \throws MapFileError
    void commit();

    std::size_t Read(void*, std::size_t) override { return 0; }
    std::uint64_t Seek(std::int64_t, CStream::TSeekOrigin) override { return getPosition(); }
    std::uint64_t getTotalBytesCount() const override { return getPosition(); }
    /// Bytes written so far (before compression).
    std::uint64_t getPosition() const override;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes one object (a scene, a simplemap). \throws MapFileError
void writeGzip(const mrpt::serialization::CSerializable& object, const std::string& path);

}  // namespace superray
