#pragma once
/// \file gz_input.h
/// A gzip or plain file as an MRPT stream that tells a whole file from a
/// broken one (CFileGZInputStream takes a truncated file for a shorter one).

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <string>

struct gzFile_s;

namespace superray {

class GzInput final : public mrpt::io::CStream {
 public:
    /// \throws InputError if the file cannot be opened
    explicit GzInput(const std::string& path);
    ~GzInput() override;
    GzInput(const GzInput&) = delete;
    GzInput& operator=(const GzInput&) = delete;

    /// True if no byte is left, or none can be read: see error().
    bool atEnd();
    /// What is wrong with the file so far (truncated, damaged); empty if nothing.
    std::string error() const;
    /// Bytes of the file consumed so far (compressed), and its size.
    std::uint64_t fileOffset() const;
    std::uint64_t fileSize() const { return fileSize_; }

    std::size_t Read(void* buffer, std::size_t count) override;
    std::size_t Write(const void*, std::size_t) override { return 0; }
    std::uint64_t Seek(std::int64_t, CStream::TSeekOrigin) override { return getPosition(); }
    std::uint64_t getTotalBytesCount() const override { return fileSize_; }
    std::uint64_t getPosition() const override;

 private:
    gzFile_s* file_;
    std::uint64_t fileSize_ = 0;
};

}  // namespace superray
