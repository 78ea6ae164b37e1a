// SPDX-License-Identifier: BSD-3-Clause
#include "sources/text_numbers.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "text/text_input.h"

namespace superray {
namespace {
constexpr char kBlanks[] = " \t\r";
constexpr char kSeparators[] = " \t\r,;";

/// Calls visit(first, last) for each word, until it returns false.
template <class Visit>
bool forEachWord(const std::string& line, const char* separators, const Visit& visit) {
    auto begin = line.find_first_not_of(separators);
    while (begin != std::string::npos) {
        const auto end = std::min(line.find_first_of(separators, begin), line.size());
        if (!visit(&line[begin], line.data() + end)) return false;
        begin = line.find_first_not_of(separators, end);
    }
    return true;
}

std::optional<std::vector<double>> parseWords(const std::string& line, const char* separators) {
    std::vector<double> numbers;
    const bool good = forEachWord(line, separators, [&](const char* first, const char* last) {
        double value = 0;
        const auto [rest, error] = std::from_chars(first, last, value);
        numbers.push_back(value);
        return error == std::errc{} && rest == last;
    });
    if (!good) return std::nullopt;
    return numbers;
}

}  // namespace

std::optional<std::vector<double>> parseNumbers(const std::string& line) {
    auto numbers = parseWords(line, kBlanks);
    if (!numbers || !std::all_of(numbers->begin(), numbers->end(),
                                 [](double v) { return std::isfinite(v); }))
        return std::nullopt;
    return numbers;
}

std::optional<double> parseNumber(const std::string& word) {
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc{} || rest != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::optional<std::vector<double>> parseRow(const std::string& line) {
    return parseWords(line, kSeparators);
}

bool isHeading(const std::string& line) {
    return forEachWord(line, kSeparators, [](const char* first, const char* last) {
        double value = 0;
        return std::from_chars(first, last, value).ec == std::errc::invalid_argument;
    });
}

bool isCommentLine(const std::string& line) {
    const auto first = line.find_first_not_of(kBlanks);
    return first == std::string::npos || line[first] == '#' || line[first] == '%';
}

void forEachLine(const std::filesystem::path& path,
                 const std::function<void(const std::string&, const std::string&)>& visit) {
    std::istringstream file = openTextInput(path.string(), LastLine::mustEnd);
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number)
        if (!isCommentLine(line)) visit(line, path.string() + ":" + std::to_string(number));
}

std::vector<double> numbersOrThrow(const std::string& text, const std::string& where) {
    auto numbers = parseNumbers(text);
    if (!numbers)
        throw InputError(where + ": every column must be a finite number, separated by blanks");
    return *numbers;
}

}  // namespace superray
