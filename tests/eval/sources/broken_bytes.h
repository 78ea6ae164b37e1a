// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Bytes of a file, broken at random.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace superray::test {

/// Cuts, flips, wild bytes and numbers, repeated and exchanged parts.
inline std::string mutated(std::string bytes, std::mt19937& random) {
    const auto changes = 1 + random() % 3;
    for (auto n = changes; n > 0 && bytes.size() > 8; --n) {
        const std::size_t at = random() % (bytes.size() - 8);
        switch (random() % 7) {
            case 0:
                bytes.resize(at);
                break;
            case 1:
            case 2:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
                break;
            case 3:
                bytes[at] = static_cast<char>(random());
                break;
            case 4: {  // a wild count
                const std::uint32_t wild[] = {0xFFFFFFFFu, 0x7FFFFFFFu, 0x10000000u,
                                              1u << random() % 32, 0};
                std::memcpy(&bytes[at], &wild[random() % 5], 4);
                break;
            }
            case 5:
                bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 64));
                break;
            default:
                bytes.erase(at, 1 + random() % 16);
        }
    }
    return bytes;
}

/// How many files to break, and with which seed. By hand, more of them:
/// SUPERRAY_TEST_MUTATIONS and SUPERRAY_TEST_SEED.
struct Mutations {
    int count = 0;
    unsigned seed = 0;
};
inline Mutations orOfEnvironment(Mutations mutations) {
    if (const char* count = std::getenv("SUPERRAY_TEST_MUTATIONS"))
        mutations.count = std::atoi(count);
    if (const char* seed = std::getenv("SUPERRAY_TEST_SEED"))
        mutations.seed = static_cast<unsigned>(std::atoi(seed));
    return mutations;
}

/// Keeps a file that a test fails with. \return its path
inline std::string keepBroken(const std::string& name, const std::string& bytes) {
    const auto path = std::filesystem::temp_directory_path() / ("superray-broken-" + name);
    std::ofstream(path, std::ios::binary) << bytes;
    return path.string();
}

}  // namespace superray::test
