// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file text_numbers.h
/// Lines of text files and their numbers, whatever the locale.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// The numbers of a line, separated by blanks; nothing if any word is not
/// entirely a finite number.
std::optional<std::vector<double>> parseNumbers(const std::string& line);

/// The finite number that a word is, entirely; nothing for other words.
std::optional<double> parseNumber(const std::string& word);

/// A coordinate of a point: also NaN, infinite, or so small that it is 0, with or without a
/// plus sign. Nothing for words that are not entirely a number.
std::optional<double> parseCoordinate(const std::string& word);

/// The numbers of a line of a table, separated by blanks, or by one comma (or semicolon) each;
/// they may be NaN or infinite.
/// \throws InputError naming `where` if a word is not entirely a number, or a column is empty
std::vector<double> rowOrThrow(const std::string& line, const std::string& where);

/// True if a line has words, but none that begins like a number: a heading.
bool isHeading(const std::string& line);

/// True for lines without data: empty, blank, or starting with # or %.
bool isCommentLine(const std::string& line);

/// Calls `visit(line, where)` for every line with data of a text file.
/// \throws InputError as openTextInput(); its last line must end
void forEachLine(const std::filesystem::path& path,
                 const std::function<void(const std::string&, const std::string&)>& visit);

/// \throws InputError naming `where` if a word is no number
std::vector<double> numbersOrThrow(const std::string& text, const std::string& where);

}  // namespace superray
