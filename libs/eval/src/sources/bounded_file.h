// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file bounded_file.h
/// A file read forward, record by record.

#include <cstdint>
#include <fstream>
#include <string>

namespace superray {

class BoundedFile {
 public:
    /// \throws InputError if it cannot be opened, or is no regular file
    explicit BoundedFile(const std::string& path);

    std::uint64_t size() const { return size_; }
    std::uint64_t position() const { return position_; }
    std::uint64_t left() const { return size_ - position_; }

    /// The next bytes. \throws TruncatedInputError before it takes memory, if the file has
    /// fewer; InputError if it cannot be read
    std::string read(std::uint64_t count);

    /// Leaves bytes out. \throws TruncatedInputError
    void skip(std::uint64_t count);

    /// \pre position <= size()
    void seek(std::uint64_t position);

 private:
    void require(std::uint64_t count) const;

    std::string path_;
    std::ifstream file_;
    std::uint64_t size_ = 0, position_ = 0;
};

}  // namespace superray
