// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scalar_field.h
/// Numbers of several types in binary files.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace superray {

enum class ScalarKind : std::uint8_t { signedInt, unsignedInt, real };
enum class ByteOrder : std::uint8_t { little, big };

/// A number at a place within a record.
struct ScalarField {
    ScalarKind kind = ScalarKind::real;
    std::size_t bytes = 4;  ///< 1, 2, 4 or 8; of reals 4 or 8
    std::size_t offset = 0;

    bool isValid() const {
        const bool known = bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
        return known && (kind != ScalarKind::real || bytes >= 4);
    }

    /// \param record of at least offset + bytes; this machine is little endian
    double read(const char* record, ByteOrder order = ByteOrder::little) const {
        std::array<char, 8> raw{};
        std::copy_n(record + offset, bytes, raw.begin());
        if (order == ByteOrder::big)
            std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(bytes));
        if (kind == ScalarKind::real)
            return bytes == 4 ? double{as<float>(raw)} : as<double>(raw);
        const bool isSigned = kind == ScalarKind::signedInt;
        switch (bytes) {
            case 1:
                return isSigned ? number<std::int8_t>(raw) : number<std::uint8_t>(raw);
            case 2:
                return isSigned ? number<std::int16_t>(raw) : number<std::uint16_t>(raw);
            case 4:
                return isSigned ? number<std::int32_t>(raw) : number<std::uint32_t>(raw);
            default:
                return isSigned ? number<std::int64_t>(raw) : number<std::uint64_t>(raw);
        }
    }

 private:
    template <class T>
    static T as(const std::array<char, 8>& raw) {
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }
    template <class T>
    static double number(const std::array<char, 8>& raw) {
        return static_cast<double>(as<T>(raw));
    }
};

}  // namespace superray
