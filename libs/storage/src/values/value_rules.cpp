// SPDX-License-Identifier: BSD-3-Clause
#include "values/value_rules.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace superray {
namespace {

template <std::size_t N>
std::string text(const std::array<std::int32_t, N>& index) {
    std::string s = "(";
    for (std::size_t a = 0; a < N; ++a) s += (a ? ", " : "") + std::to_string(index[a]);
    return s + ")";
}

template <std::size_t N>
void require(const std::array<std::int32_t, N>& index, std::int32_t limit, const char* what) {
    if (isAddressable(index, limit)) return;
    throw std::out_of_range(std::string(what) + " " + text(index) +
                            " is outside the addressable range [-" + std::to_string(limit) +
                            ", " + std::to_string(limit) + ") per axis");
}

}  // namespace

template <int Dim>
void requireAddressableCell(const Cell<Dim>& cell) {
    require(cell, kCellLimit, "cell");
}

template <int Dim>
void requireAddressableBlock(const BlockKey<Dim>& key) {
    require(key, kBlockLimit, "block");
}

template <int Dim>
void requireAddressableBlocks(const UpdateBatch<Dim>& batch) {
    for (std::size_t b = 0; b < batch.blockCount(); ++b)
        require(batch.key(b), kBlockLimit, "block");
}

float storedValue(float value) {
    if (!std::isfinite(value))
        throw std::invalid_argument("log-odds of a cell must be finite, got " +
                                    std::to_string(value));
    return value + 0.0f;  // -0 + 0 = +0; any other value is unchanged
}

template void requireAddressableCell<2>(const Cell<2>&);
template void requireAddressableCell<3>(const Cell<3>&);
template void requireAddressableBlock<2>(const BlockKey<2>&);
template void requireAddressableBlock<3>(const BlockKey<3>&);
template void requireAddressableBlocks<2>(const UpdateBatch<2>&);
template void requireAddressableBlocks<3>(const UpdateBatch<3>&);

}  // namespace superray
