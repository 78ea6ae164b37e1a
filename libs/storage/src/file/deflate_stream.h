// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file deflate_stream.h
/// zlib streams and checksum with bounded memory and MapFileError for failures.

#include "file/byte_io.h"

#include <array>
#include <memory>

struct z_stream_s;

namespace superray {

/// Deflate cannot shrink data further than this (zlib's documented limit is
/// 1032 : 1); a file that claims more is refused before anything is inflated.
inline constexpr std::uint64_t kMaxDeflateRatio = 1040;

std::uint32_t crc32Of(const std::uint8_t* data, std::size_t size, std::uint32_t previous = 0);

class DeflateStream {
 public:
    DeflateStream();
    ~DeflateStream();
    void write(const std::uint8_t* data, std::size_t size);
    Bytes finish();

 private:
    void run(int flush);
    std::unique_ptr<z_stream_s> z_;
    Bytes out_;
    std::array<std::uint8_t, 1 << 16> buffer_;
};

class InflateStream {
 public:
    InflateStream(const std::uint8_t* data, std::size_t size);
    ~InflateStream();
    /// \throws MapFileError if fewer bytes are left or the data are corrupt
    void read(std::uint8_t* to, std::size_t size);
    /// \throws MapFileError unless all input was used and all output read
    void requireEnd();

 private:
    bool refill();  ///< false at the end of the stream
    std::unique_ptr<z_stream_s> z_;
    const std::uint8_t* data_;
    std::size_t left_;
    bool ended_ = false;
    std::array<std::uint8_t, 1 << 16> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // unread part of buffer_
};

}  // namespace superray
