// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file byte_io.h
/// Numbers as little-endian bytes, whatever the machine.

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace superray {

using Bytes = std::vector<std::uint8_t>;

namespace detail {
template <std::size_t Size>
using UintOfSize = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;
}

/// Appends an integer or a floating-point number.
template <typename T>
void put(Bytes& out, T value) {
    static_assert(std::is_arithmetic_v<T>);
    detail::UintOfSize<sizeof(T)> bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (std::size_t i = 0; i < sizeof(T); ++i)
        out.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
}

/// Reads the number at `data`. \pre sizeof(T) bytes are there
template <typename T>
T get(const std::uint8_t* data) {
    static_assert(std::is_arithmetic_v<T>);
    using Uint = detail::UintOfSize<sizeof(T)>;
    Uint bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bits = static_cast<Uint>(bits | static_cast<Uint>(Uint{data[i]} << (8 * i)));
    T value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

}  // namespace superray
