// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file text_matrix.h

#include <superray/maps/compressed_input.h>

#include <cstddef>
#include <vector>

namespace superray {

/// Numbers in rows of equal length: what MRPT's saveToTextFile() writes.
struct TextMatrix {
    std::size_t columns = 0;
    std::vector<float> values;  ///< row by row

    std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
};

/// \throws std::runtime_error for no numbers at all, what is none, rows that differ in
///         length, and a last line without an end: part of it may be missing
TextMatrix readTextMatrix(CompressedInput& file);

}  // namespace superray
