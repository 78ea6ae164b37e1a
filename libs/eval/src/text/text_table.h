// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file text_table.h

#include <cstdio>
#include <string>
#include <vector>

namespace superray {

/// Rows of text, the first one the heading; first column to the left, the
/// others to the right.
class TextTable {
 public:
    using Row = std::vector<std::string>;
    explicit TextTable(Row heading) { add(std::move(heading)); }
    /// \pre as many columns as the heading
    void add(Row row) { rows_.push_back(std::move(row)); }

    std::string text() const {
        std::vector<std::size_t> width(rows_.front().size(), 0);
        for (const Row& row : rows_)
            for (std::size_t c = 0; c < row.size(); ++c)
                width[c] = std::max(width[c], row[c].size());
        std::string out;
        for (const Row& row : rows_) {
            for (std::size_t c = 0; c < row.size(); ++c) {
                const std::string space(width[c] - row[c].size(), ' ');
                out += c == 0 ? row[c] + space : "  " + space + row[c];
            }
            out.erase(out.find_last_not_of(' ') + 1);
            out += "\n";
        }
        return out;
    }

 private:
    std::vector<Row> rows_;
};

/// A number with so many digits after the point.
inline std::string formatFixed(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

/// Three significant digits, never as 1e+03.
inline std::string formatShort(double value) {
    return formatFixed(value, value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2);
}

}  // namespace superray
