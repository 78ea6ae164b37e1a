// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/text_matrix.h"

#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

namespace superray {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 24;

/// False at the end of the file.
bool readLine(CompressedInput& file, std::string& line) {
    line.clear();
    for (char c = 0; file.Read(&c, 1) == 1;) {
        if (c == '\n') return true;
        line += c;
        if (line.size() > kLongestLine)
            throw std::runtime_error("a line is longer than " + std::to_string(kLongestLine) +
                                     " bytes");
    }
    if (!line.empty())
        throw std::runtime_error("the last line has no end: part of it may be missing");
    return false;
}

bool isComment(const std::string& line) {
    const auto first = line.find_first_not_of(" \t\r");
    return first == std::string::npos || line[first] == '#' || line[first] == '%';
}

const char* skipBlanks(const char* text) {
    return text + std::strspn(text, " \t\r,;");
}

}  // namespace

TextMatrix readTextMatrix(CompressedInput& file) {
    TextMatrix matrix;
    std::string line;
    for (std::size_t number = 1; readLine(file, line); ++number) {
        if (isComment(line)) continue;
        const std::size_t before = matrix.values.size();
        const char* next = line.c_str();
        while (*(next = skipBlanks(next)) != '\0') {
            char* end = nullptr;
            matrix.values.push_back(std::strtof(next, &end));
            if (end == next) break;
            next = end;
        }
        if (next != line.c_str() + line.size())
            throw std::runtime_error("line " + std::to_string(number) +
                                     " holds what is no number");
        const std::size_t columns = matrix.values.size() - before;
        if (matrix.columns == 0) matrix.columns = columns;
        if (columns != matrix.columns)
            throw std::runtime_error("line " + std::to_string(number) + " has " +
                                     std::to_string(columns) + " numbers, those before have " +
                                     std::to_string(matrix.columns));
    }
    if (matrix.columns == 0) throw std::runtime_error("it holds no numbers");
    return matrix;
}

}  // namespace superray
