// SPDX-License-Identifier: BSD-3-Clause
#include "sources/text_numbers.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
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

std::optional<std::vector<double>> parseWords(const std::string& line) {
    std::vector<double> numbers;
    const bool good = forEachWord(line, kBlanks, [&](const char* first, const char* last) {
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
    auto numbers = parseWords(line);
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

std::optional<double> parseCoordinate(const std::string& word) {
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    const char* const begin = word.data() + (plus ? 1 : 0);
    const char* const end = word.data() + word.size();
    double value = 0;
    const auto [rest, error] = std::from_chars(begin, end, value);
    if (rest != end || error == std::errc::invalid_argument) return std::nullopt;
    if (error != std::errc::result_out_of_range) return value;
    const bool tiny = word.find_first_of("eE") != std::string::npos &&
                      word[word.find_first_of("eE") + 1] == '-';
    return tiny ? 0
                : std::copysign(std::numeric_limits<double>::infinity(),
                                word[0] == '-' ? -1.0 : 1.0);
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

std::vector<double> rowOrThrow(const std::string& line, const std::string& where) {
    const auto fail = [&](const std::string& why) {
        throw InputError(where + ": " + why +
                         "every column must be a finite number, separated by blanks or commas");
    };
    // Where there are semicolons, a comma may be that of a decimal.
    const char comma = line.find(';') != std::string::npos ? ';' : ',';
    if (line.find(comma) == std::string::npos) {
        const auto row = parseWords(line);
        if (!row) fail("");
        return *row;
    }
    std::vector<double> row;
    for (std::size_t begin = 0; begin <= line.size();) {
        const auto end = std::min(line.find(comma, begin), line.size());
        const auto field = parseWords(line.substr(begin, end - begin));
        if (field && field->empty())
            fail("column " + std::to_string(row.size() + 1) + " is empty: ");
        if (!field || field->size() != 1) fail("");
        row.push_back(field->front());
        begin = end + 1;
    }
    return row;
}

std::vector<double> numbersOrThrow(const std::string& text, const std::string& where) {
    auto numbers = parseNumbers(text);
    if (!numbers)
        throw InputError(where + ": every column must be a finite number, separated by blanks");
    return *numbers;
}

}  // namespace superray
