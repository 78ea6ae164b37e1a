// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file text_numbers.h
/// Numbers of a line of text, whatever the locale.

#include <optional>
#include <string>
#include <vector>

namespace superray {

/// The numbers of a line, separated by blanks; nothing if any word is not
/// entirely a finite number.
std::optional<std::vector<double>> parseNumbers(const std::string& line);

/// The numbers of a line of a table, separated by blanks or commas; they may be NaN or
/// infinite. Nothing if any word is not entirely a number.
std::optional<std::vector<double>> parseRow(const std::string& line);

/// True if a line has words, but none that begins like a number: a heading.
bool isHeading(const std::string& line);

/// True for lines without data: empty, blank, or starting with # or %.
bool isCommentLine(const std::string& line);

}  // namespace superray
