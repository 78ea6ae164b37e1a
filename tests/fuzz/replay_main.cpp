// SPDX-License-Identifier: BSD-3-Clause
// Drives a fuzz target without libFuzzer: replay [--write-seeds DIR]
// [--mutations N] [--seed S] [FILE or DIR ...]. Replays the files and the target's
// seeds, then N mutations of them. An input that takes too much time or memory is a
// finding like one that crashes.

#include <superray/core/detail/sanitizers.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <random>

#include "fuzz/target.h"

namespace {

namespace fs = std::filesystem;
using Inputs = std::vector<std::string>;

constexpr rlim_t kMostBytes = rlim_t{4} << 30;  // of address space, thread stacks included
constexpr unsigned kMostSeconds = 120;          // for one input, also on a busy machine

/// The input of now, written out if it crashes.
std::string current;

void keepInput(int signal) {
    std::FILE* file = std::fopen("fuzz-finding.bin", "wb");
    if (file != nullptr) {
        std::fwrite(current.data(), 1, current.size(), file);
        std::fclose(file);
    }
    std::fprintf(stderr, "signal %d; the input is in fuzz-finding.bin\n", signal);
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

/// Keeps the machine from swapping. A target takes std::bad_alloc for an orderly refusal,
/// and so running out of memory aborts instead.
void limitMemory() {
    const rlimit limit{kMostBytes, kMostBytes};
    if (!superray::kSanitized) setrlimit(RLIMIT_AS, &limit);
    std::set_new_handler([] {
        std::fputs("out of memory: ", stderr);
        std::abort();
    });
}

void runTimed(const std::string& input) {
    alarm(kMostSeconds);
    superray::fuzz::run(current = input);
    alarm(0);
}

std::string contentsOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void addFiles(const fs::path& path, Inputs& inputs) {
    if (!fs::is_directory(path)) {
        inputs.push_back(contentsOf(path));
        return;
    }
    for (const auto& entry : fs::recursive_directory_iterator(path))
        if (entry.is_regular_file()) inputs.push_back(contentsOf(entry.path()));
}

/// One to four changes: bits, bytes, numbers, cuts, repeated and exchanged parts.
std::string mutated(std::string bytes, const Inputs& others, std::mt19937_64& random) {
    for (auto changes = 1 + random() % 4; changes > 0 && bytes.size() > 9; --changes) {
        const std::size_t at = random() % (bytes.size() - 8);
        switch (random() % 8) {
            case 0:
                bytes.resize(at);
                break;
            case 1:
                bytes[at] = static_cast<char>(random());
                break;
            case 2: {
                const std::array<std::uint64_t, 6> wild = {
                    0, ~0ull, 0x7FFFFFFF7FFFFFFFull, 0x7FF0000000000000ull, 1, random()};
                std::memcpy(&bytes[at], &wild[random() % wild.size()], 1ull << random() % 4);
                break;
            }
            case 3:
                bytes.erase(at, 1 + random() % 16);
                break;
            case 4:
                bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 64));
                break;
            case 5: {
                const std::string& other = others[random() % others.size()];
                if (!other.empty()) bytes.replace(at, 8, other, random() % other.size(), 32);
                break;
            }
            default:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
        }
    }
    return bytes;
}

void writeSeeds(const fs::path& folder) {
    fs::create_directories(folder);
    int number = 0;
    for (const auto& seed : superray::fuzz::seeds())
        std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
}

}  // namespace

int main(int argc, char** argv) {
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGALRM})
        std::signal(signal, keepInput);
    limitMemory();
    Inputs inputs = superray::fuzz::seeds();
    unsigned long mutations = 0, seed = 1;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        const bool hasValue = i + 1 < argc;
        if (argument == "--write-seeds" && hasValue) {
            writeSeeds(argv[++i]);
            return 0;
        }
        if (argument == "--mutations" && hasValue)
            mutations = std::strtoul(argv[++i], nullptr, 10);
        else if (argument == "--seed" && hasValue)
            seed = std::strtoul(argv[++i], nullptr, 10);
        else
            addFiles(argument, inputs);
    }
    for (const auto& input : inputs) runTimed(input);
    std::mt19937_64 random(seed);
    for (unsigned long m = 0; m < mutations; ++m)
        runTimed(mutated(inputs[random() % inputs.size()], inputs, random));
    std::printf("%zu inputs and %lu mutations of them\n", inputs.size(), mutations);
    return inputs.empty() ? 1 : 0;
}
