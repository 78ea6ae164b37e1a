// SPDX-License-Identifier: BSD-3-Clause
#include "sources/bounded_file.h"

#include <superray/eval/input_error.h>

#include <filesystem>

#include "sources/object_reader.h"

namespace superray {

BoundedFile::BoundedFile(const std::string& path) : path_(path) {
    requireRegularFile(path);
    file_.open(path, std::ios::binary);
    std::error_code error;
    size_ = std::filesystem::file_size(path, error);
    if (!file_ || error) throw InputError(path + ": cannot be opened for reading");
}

void BoundedFile::require(std::uint64_t count) const {
    if (count > left())
        throw TruncatedInputError(
            path_ + ": ends early: a record at byte " + std::to_string(position_) + " needs " +
            std::to_string(count) + " bytes, " + std::to_string(left()) + " are left");
}

std::string BoundedFile::read(std::uint64_t count) {
    require(count);
    std::string bytes(static_cast<std::size_t>(count), '\0');
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    if (file_.gcount() != static_cast<std::streamsize>(count))
        throw InputError(path_ + ": cannot be read at byte " + std::to_string(position_));
    position_ += count;
    return bytes;
}

void BoundedFile::skip(std::uint64_t count) {
    require(count);
    seek(position_ + count);
}

void BoundedFile::seek(std::uint64_t position) {
    file_.seekg(static_cast<std::streamoff>(position));
    position_ = position;
}

}  // namespace superray
