// SPDX-License-Identifier: BSD-3-Clause
#include "text/text_input.h"

#include <superray/eval/input_error.h>

#include <filesystem>
#include <fstream>

namespace superray {

std::istringstream openTextInput(const std::string& path, LastLine lastLine) {
    constexpr std::uintmax_t kMost = std::uintmax_t{256} << 20;
    requireRegularFile(path);
    std::ifstream file(path, std::ios::binary);
    const auto size = std::filesystem::file_size(path);
    if (!file) throw InputError(path + ": cannot be opened for reading");
    if (size > kMost)
        throw InputError(path + ": has " + std::to_string(size) +
                         " bytes; text files of at most " + std::to_string(kMost) +
                         " are read");
    std::string text(size, '\0');
    file.read(text.data(), static_cast<std::streamsize>(size));
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (file.bad()) throw InputError(path + ": cannot be read");
    if (lastLine == LastLine::mustEnd && !text.empty() && text.back() != '\n')
        throw InputError(path +
                         ": its last line has no end: the file may be truncated (if it is "
                         "whole, add a line feed)");
    return std::istringstream(std::move(text));
}

}  // namespace superray
