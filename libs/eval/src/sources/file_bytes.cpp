// SPDX-License-Identifier: BSD-3-Clause
#include "sources/file_bytes.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace superray {

std::string readFileBytes(const std::string& path, std::uint64_t most) {
    constexpr std::uintmax_t kLargest = std::uintmax_t{4} << 30;
    requireRegularFile(path);
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError(path + ": cannot be opened for reading");
    const auto size = std::filesystem::file_size(path);
    if (size > kLargest)
        throw InputError(path + ": has " + std::to_string(size) + " bytes; clouds of at most " +
                         std::to_string(kLargest) + " are read");
    std::string bytes(std::min<std::uint64_t>(size, most), '\0');
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (file.gcount() != static_cast<std::streamsize>(bytes.size()))
        throw InputError(path + ": cannot be read");
    return bytes;
}

std::string startOfFile(const std::string& path) {
    constexpr std::size_t kLongestMagic = 16;
    std::ifstream file(path, std::ios::binary);
    std::string start(kLongestMagic, '\0');
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(file.gcount()));
    return start;
}

bool isPadding(const std::string& bytes, std::size_t from, std::size_t end) {
    const auto at = [&](std::size_t i) {
        return bytes.begin() + static_cast<std::ptrdiff_t>(std::min(i, bytes.size()));
    };
    return std::all_of(at(from), at(std::max(from, end)), [](char c) {
        return c == '\0' || c == ' ' || c == '\t' || c == '\r' || c == '\n';
    });
}

std::vector<std::string> wordsOf(const std::string& line) {
    std::istringstream in(line);
    return {std::istream_iterator<std::string>(in), {}};
}

}  // namespace superray
