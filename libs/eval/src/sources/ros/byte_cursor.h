// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file byte_cursor.h
/// Little-endian numbers and texts out of bytes that anything may be wrong with.

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

namespace superray {

/// Bytes that break the rules of their format; who knows the file adds its name.
class MalformedBytes : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Reads forward, never beyond the end.
class ByteCursor {
 public:
    explicit ByteCursor(std::string_view bytes) : bytes_(bytes) {}

    std::size_t left() const { return bytes_.size(); }

    /// The next bytes. \throws MalformedBytes if there are fewer
    std::string_view take(std::uint64_t count) {
        if (count > bytes_.size())
            throw MalformedBytes("needs " + std::to_string(count) + " bytes where " +
                                 std::to_string(bytes_.size()) + " are left");
        const auto taken = bytes_.substr(0, static_cast<std::size_t>(count));
        bytes_.remove_prefix(taken.size());
        return taken;
    }

    /// This machine is little endian. \throws MalformedBytes
    template <class T>
    T number() {
        T value;
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
        return value;
    }

    /// Bytes after their own number, which is of type Length. \throws MalformedBytes
    template <class Length>
    std::string_view counted() {
        return take(number<Length>());
    }

 private:
    std::string_view bytes_;
};

}  // namespace superray
