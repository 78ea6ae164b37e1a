// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file decoder.h
/// Decompression step by step, the same for every format.

#include <superray/maps/compressed_input.h>

#include <cstddef>
#include <memory>
#include <string>

namespace superray {

/// Bytes of the file that are in memory and not yet consumed.
struct InputBytes {
    const unsigned char* next = nullptr;
    std::size_t count = 0;
};

class Decoder {
 public:
    virtual ~Decoder() = default;

    /// Decompresses from `input` (consuming it) to `out`; returns the bytes written.
    /// Returns less than `capacity` if it needs more input, or after an error.
    virtual std::size_t decode(InputBytes& input, unsigned char* out, std::size_t capacity) = 0;
    /// True if the data may end here: after a whole member or frame.
    virtual bool atBorder() const = 0;
    /// What is wrong with the data; empty if nothing.
    const std::string& error() const { return error_; }

 protected:
    std::string error_;
};

/// The format whose magic number the bytes start with. A file of fewer bytes than the
/// magic number has counts as a (truncated) file of that format.
Compression recognise(const unsigned char* bytes, std::size_t count);

std::unique_ptr<Decoder> makeDecoder(Compression compression);

}  // namespace superray
