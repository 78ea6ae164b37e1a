// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_file_tools.h
/// The file format a second time, for tests that break it on purpose.

#include "storage/storage_test_tools.h"

#include <superray/storage/map_file.h>

#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace superray::test {

using Bytes = std::vector<std::uint8_t>;

/// A map with uniform, dense and sparse blocks; returns its cells.
template <int Dim>
Cells<Dim> fillRandomly(OccupancyMap<Dim>& map, unsigned seed) {
    std::mt19937 random{seed};
    const SensorModel model;
    for (int s = 0; s < 4; ++s)
        map.apply(randomBatch<Dim>(random, 8), model, UpdatePolicy::everyRay);
    return cellsOf<Dim>(map);
}

struct TemporaryFolder {
    std::string path;
    TemporaryFolder() {
        std::string name = std::filesystem::temp_directory_path() / "superray-XXXXXX";
        path = ::mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    int entries() const {
        int n = 0;
        for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(path)) ++n;
        return n;
    }
};

inline Bytes contentsOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
}

inline void putNumber(Bytes& out, std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
inline std::uint64_t numberAt(const Bytes& in, std::size_t at, int bytes) {
    std::uint64_t v = 0;
    for (int i = bytes - 1; i >= 0; --i) v = v << 8 | in.at(at + static_cast<std::size_t>(i));
    return v;
}
inline std::uint32_t crcOf(const Bytes& b, std::size_t begin, std::size_t end) {
    return static_cast<std::uint32_t>(crc32_z(0, b.data() + begin, end - begin));
}

using Sections = std::vector<std::pair<std::string, Bytes>>;

/// A container of format version 1 with these sections and right checksums.
inline Bytes containerOf(const Sections& sections) {
    Bytes out = {0x89, 'S', 'R', 'M', 'A', 'P', '\r', '\n'};
    putNumber(out, 1, 4);
    putNumber(out, sections.size(), 4);
    std::uint64_t size = 28;
    for (const auto& s : sections) size += 16 + s.second.size();
    putNumber(out, size, 8);
    putNumber(out, crcOf(out, 0, out.size()), 4);
    for (const auto& [tag, data] : sections) {
        Bytes checked(tag.begin(), tag.end());
        putNumber(checked, data.size(), 8);
        out.insert(out.end(), checked.begin(), checked.end());
        checked.insert(checked.end(), data.begin(), data.end());
        putNumber(out, crcOf(checked, 0, checked.size()), 4);
        out.insert(out.end(), data.begin(), data.end());
    }
    return out;
}

inline Sections sectionsOf(const Bytes& file) {
    Sections sections;
    for (std::size_t at = 28; at < file.size();) {
        const auto size = static_cast<std::ptrdiff_t>(numberAt(file, at + 4, 8));
        const auto begin = file.begin() + static_cast<std::ptrdiff_t>(at) + 16;
        sections.emplace_back(std::string(file.begin() + static_cast<std::ptrdiff_t>(at),
                                          file.begin() + static_cast<std::ptrdiff_t>(at) + 4),
                              Bytes(begin, begin + size));
        at += 16 + static_cast<std::size_t>(size);
    }
    return sections;
}

/// Encoded cells taken apart, to be changed and put together again.
struct OpenCells {
    Bytes header;  // 48 bytes before the checksum
    Bytes raw;     // inflated blocks

    explicit OpenCells(const Bytes& cells) : header(cells.begin(), cells.begin() + 48) {
        raw.resize(numberAt(cells, 32, 8));
        uLongf size = raw.size();
        EXPECT_EQ(uncompress(raw.data(), &size, cells.data() + 52, cells.size() - 52), Z_OK);
        EXPECT_EQ(size, raw.size());
    }
    /// With right lengths and checksum, whatever header and raw say.
    Bytes close() const {
        uLongf size = compressBound(raw.size());
        Bytes deflated(size);
        EXPECT_EQ(compress2(deflated.data(), &size, raw.data(), raw.size(), 1), Z_OK);
        deflated.resize(size);
        Bytes out(header.begin(), header.begin() + 32);
        putNumber(out, raw.size(), 8);
        putNumber(out, deflated.size(), 8);
        Bytes checked = out;
        checked.insert(checked.end(), deflated.begin(), deflated.end());
        putNumber(out, crcOf(checked, 0, checked.size()), 4);
        out.insert(out.end(), deflated.begin(), deflated.end());
        return out;
    }
    void setHeaderNumber(std::size_t at, std::uint64_t value, int bytes) {
        Bytes number;
        putNumber(number, value, bytes);
        std::copy(number.begin(), number.end(),
                  header.begin() + static_cast<std::ptrdiff_t>(at));
    }
};

}  // namespace superray::test
