// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>

#include <filesystem>
#include <system_error>

namespace superray {

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
    text.erase(std::min(text.find('\n'), text.size()));
    return text.empty() ? "unknown error" : text;
}

}  // namespace superray
