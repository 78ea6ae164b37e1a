// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace superray {
namespace {

constexpr std::size_t kLongest = 10000;  // two long paths and a sentence

}  // namespace

void requireRegularFile(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw InputError(path + ": no such file");
    if (!std::filesystem::is_regular_file(status))
        throw InputError(path + ": is not a regular file");
}

std::string oneLineCause(const std::exception& error) {
    std::string text = error.what();
    const std::string marker = "Message:";
    if (const auto at = text.rfind(marker); at != std::string::npos) {
        text.erase(0, text.find_first_not_of(' ', at + marker.size()));
    }
    // Before the text of another library's exception, MRPT puts a line of its own.
    while (text.rfind("====", 0) == 0)
        text.erase(0, std::min(text.find('\n'), text.size() - 1) + 1);
    text.erase(std::min(text.find('\n'), text.size()));
    if (text.size() > kLongest) text.replace(kLongest / 2, text.size() - kLongest, " [...] ");
    return text.empty() ? "unknown error" : text;
}

}  // namespace superray
