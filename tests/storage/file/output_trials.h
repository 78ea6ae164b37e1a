// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file output_trials.h
/// What every kind of output must stand: failing system calls, full disks, kills.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "storage/file/faulty_disk.h"

namespace superray::test {

/// Writes one of two contents (0 or 1) to a path; throws if it cannot.
using WriteOutput = std::function<void(const std::string& path, int which)>;

inline std::string bytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline int entriesOf(const std::string& folder) {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

/// The trials of one kind of output, in a folder that holds nothing else.
class OutputTrials {
 public:
    /// \param files that a write makes, usually one
    OutputTrials(std::string folder, std::string name, WriteOutput write,
                 std::vector<std::string> files = {})
        : folder_(std::move(folder)),
          path_(folder_ + "/" + name),
          write_(std::move(write)),
          files_(std::move(files)) {
        if (files_.empty()) files_ = {name};
        for (int which = 1; which >= 0; --which) {  // 0 is there in the end
            write_(path_, which);
            contents_[which] = now();
        }
    }

    /// Both contents are there, and differ.
    void expectUsable() const {
        for (std::size_t i = 0; i < files_.size(); ++i) {
            EXPECT_FALSE(contents_[0][i].empty()) << files_[i];
            EXPECT_NE(contents_[0][i], contents_[1][i]) << files_[i];
        }
        expectOnlyFiles();
    }

    /// Every system call fails once; and from each on, all.
    void failEachCall() const {
        using Failure = FaultyDisk::Failure;
        int needed = 0;
        {
            const FaultyDisk counting(1 << 30, Failure::once);
            write_(path_, 0);
            needed = FaultyDisk::calls();
        }
        ASSERT_GE(needed, 4) << "make, write, sync, rename";
        for (const Failure failure : {Failure::once, Failure::forEver})
            for (int succeeding = 0; succeeding < needed; ++succeeding) {
                SCOPED_TRACE("call " + std::to_string(succeeding));
                const bool threw = failing(succeeding, failure);
                EXPECT_TRUE(threw);
                EXPECT_GE(FaultyDisk::failed(), 1);
                expectWhole();
                expectOnlyFiles();
                write_(path_, 0);
            }
    }

    /// A full disk, as far as this process can tell, at several lengths.
    void fillDisk() const {
        std::size_t most = 0;
        for (const auto& c : contents_[1]) most = std::max(most, c.size());
        ASSERT_GT(most, 1u);
        for (const std::size_t room : {std::size_t{0}, std::size_t{1}, most / 2, most - 1}) {
            SCOPED_TRACE("room for " + std::to_string(room));
            struct rlimit before {};
            ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
            const auto handler = std::signal(SIGXFSZ, SIG_IGN);
            const struct rlimit limit = {room, before.rlim_max};
            ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
            bool threw = false;
            try {
                write_(path_, 1);
            } catch (const std::exception&) {
                threw = true;
            }
            ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
            std::signal(SIGXFSZ, handler);
            EXPECT_TRUE(threw);
            expectWhole();
            expectOnlyFiles();
            write_(path_, 0);
        }
    }

    /// Kills writers at seeded instants. SUPERRAY_TEST_KILLS: how many (default 6).
    void killWriters(unsigned seed) const {
        const char* wanted = std::getenv("SUPERRAY_TEST_KILLS");
        const int kills = wanted ? std::atoi(wanted) : 6;
        const auto start = std::chrono::steady_clock::now();
        write_(path_, 0);
        const auto one = std::chrono::duration_cast<std::chrono::microseconds>(
            std::chrono::steady_clock::now() - start);
        std::mt19937 random(seed);
        for (int k = 0; k < kills; ++k) {
            const pid_t child = ::fork();
            ASSERT_GE(child, 0);
            if (child == 0) {
                for (int which = 1;; which = 1 - which) write_(path_, which);
            }
            ::usleep(static_cast<useconds_t>(random() %
                                             static_cast<unsigned>(3 * one.count() + 2000)));
            ASSERT_EQ(::kill(child, SIGKILL), 0);
            int status = 0;
            ASSERT_EQ(::waitpid(child, &status, 0), child);
            ASSERT_TRUE(WIFSIGNALED(status)) << "the writer stopped by itself";
            expectWhole();
            const auto most = static_cast<int>(2 * files_.size());
            EXPECT_LE(entriesOf(folder_), most) << "leftovers pile up";
        }
        write_(path_, 0);
        expectOnlyFiles();
    }

 private:
    std::vector<std::string> now() const {
        std::vector<std::string> contents;
        for (const auto& file : files_) contents.push_back(bytesOf(folder_ + "/" + file));
        return contents;
    }
    bool failing(int succeeding, FaultyDisk::Failure failure) const {
        const FaultyDisk faulty(succeeding, failure);
        try {
            write_(path_, 1);
        } catch (const std::exception&) {
            return true;
        }
        return false;
    }
    void expectWhole() const {
        const auto files = now();
        for (std::size_t i = 0; i < files.size(); ++i)
            EXPECT_TRUE(files[i] == contents_[0][i] || files[i] == contents_[1][i])
                << files_[i] << " of " << files[i].size() << " bytes";
    }
    void expectOnlyFiles() const {
        EXPECT_EQ(entriesOf(folder_), static_cast<int>(files_.size())) << "a file is left";
    }

    std::string folder_, path_;
    WriteOutput write_;
    std::vector<std::string> files_;
    std::vector<std::string> contents_[2];
};

}  // namespace superray::test
