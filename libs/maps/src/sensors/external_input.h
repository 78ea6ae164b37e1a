// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file external_input.h
/// Reading files beside a recording, of which nothing is believed.

#include <superray/maps/compressed_input.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace superray {

/// Reads to the end, where the check sum is. \return bytes (decompressed) that were left
inline std::uint64_t drain(CompressedInput& file) {
    const std::uint64_t start = file.getPosition();
    char rest[4096];
    while (!file.atEnd()) file.Read(rest, sizeof rest);
    return file.getPosition() - start;
}

/// Calls `read(file)`, which must read all; says which file is broken, and how.
template <class Reader>
void readWholeExternalFile(const std::string& path, const Reader& read) {
    CompressedInput file(path);
    std::string why;
    try {
        read(file);
        if (const auto left = drain(file); left > 0)
            why = std::to_string(left) + " bytes follow the data";
        if (!file.error().empty()) why = file.error();
    } catch (const std::exception& e) {
        why = file.error().empty() ? e.what() : file.error();
    }
    if (!why.empty())
        throw std::runtime_error(path + ": external file of a scan cannot be read: " + why +
                                 ", at byte " + std::to_string(file.fileOffset()) + " of " +
                                 std::to_string(file.fileSize()));
}

/// Grows as the file does: a damaged count must not ask for gigabytes. Little endian.
template <class Number>
std::vector<Number> readExternalNumbers(CompressedInput& file, std::size_t count) {
    constexpr std::size_t kAtOnce = 65536;
    std::vector<Number> numbers;
    while (numbers.size() < count) {
        const std::size_t before = numbers.size();
        const std::size_t wanted = std::min(kAtOnce, count - before);
        numbers.resize(before + wanted);
        const std::size_t read = file.Read(numbers.data() + before, wanted * sizeof(Number));
        if (read < wanted * sizeof(Number))
            throw std::runtime_error("it ends after " +
                                     std::to_string(before + read / sizeof(Number)) + " of " +
                                     std::to_string(count) + " values");
    }
    return numbers;
}

inline std::uint32_t readExternalCount(CompressedInput& file) {
    return readExternalNumbers<std::uint32_t>(file, 1).front();
}

}  // namespace superray
