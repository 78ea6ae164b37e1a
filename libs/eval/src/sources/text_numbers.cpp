// SPDX-License-Identifier: BSD-3-Clause
#include "sources/text_numbers.h"

#include <charconv>
#include <cmath>

namespace superray {
namespace {
constexpr char kBlanks[] = " \t\r";
}

std::optional<std::vector<double>> parseNumbers(const std::string& line) {
    std::vector<double> numbers;
    auto begin = line.find_first_not_of(kBlanks);
    while (begin != std::string::npos) {
        const auto end = std::min(line.find_first_of(kBlanks, begin), line.size());
        double value = 0;
        const auto [rest, error] = std::from_chars(&line[begin], line.data() + end, value);
        if (error != std::errc{} || rest != line.data() + end || !std::isfinite(value))
            return std::nullopt;
        numbers.push_back(value);
        begin = line.find_first_not_of(kBlanks, end);
    }
    return numbers;
}

bool isCommentLine(const std::string& line) {
    const auto first = line.find_first_not_of(kBlanks);
    return first == std::string::npos || line[first] == '#' || line[first] == '%';
}

}  // namespace superray
