// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file temp_folder.h
/// A folder of a test's own, gone when the test ends.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace superray::test {

class TempFolder {
 public:
    TempFolder() {
        std::string name =
            (std::filesystem::temp_directory_path() / "superray-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
        path_ = name;
    }
    ~TempFolder() {
        std::error_code error;
        std::filesystem::remove_all(path_, error);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    /// Path of a file in the folder.
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

    /// Writes a file (and the folders that it needs); returns its path.
    std::string write(const std::string& name, const std::string& contents) const {
        const auto path = path_ / name;
        std::filesystem::create_directories(path.parent_path());
        std::ofstream file(path, std::ios::binary);
        file << contents;
        if (!file) throw std::runtime_error("cannot write " + path.string());
        return path.string();
    }

 private:
    std::filesystem::path path_;
};

inline std::string readWholeFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot read " + path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The message of the exception of type Error that `action` throws.
template <class Error, class Action>
std::string messageOf(const Action& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "no exception";
}

inline void expectPart(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text << " must have: " << part;
}

}  // namespace superray::test
