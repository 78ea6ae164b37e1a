// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file message_cursor.h
/// The fields of ROS messages one after the other, in either serialisation.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "sources/clouds/scalar_field.h"
#include "sources/ros/byte_cursor.h"

namespace superray {

/// How ROS messages are put into bytes.
enum class Serialisation : std::uint8_t {
    ros1,  ///< little endian, packed
    cdr    ///< ROS 2: either byte order, numbers aligned to their size
};

class MessageCursor {
 public:
    /// \throws MalformedBytes if CDR data do not begin with a known encapsulation
    MessageCursor(std::string_view bytes, Serialisation kind);

    Serialisation kind() const { return kind_; }

    /// \throws MalformedBytes
    template <class T>
    T number() {
        align(sizeof(T));
        std::array<char, sizeof(T)> raw{};
        std::copy_n(take(sizeof(T)).data(), sizeof(T), raw.data());
        if (order_ == ByteOrder::big) std::reverse(raw.begin(), raw.end());
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }

    template <class T, std::size_t N>
    std::array<T, N> numbers() {
        std::array<T, N> all{};
        for (T& value : all) value = number<T>();
        return all;
    }

    /// Elements of a sequence. \throws MalformedBytes before it takes memory
    template <class T>
    std::vector<T> sequence() {
        std::vector<T> all(count(sizeof(T)));
        for (T& value : all) value = number<T>();
        return all;
    }

    std::string text();
    /// A sequence of bytes.
    std::string_view bytes();
    /// The number of elements that follow. \param least bytes that each of them has
    std::size_t count(std::size_t least);

    /// \throws MalformedBytes if more follows than CDR's padding
    void expectEnd() const;

 private:
    void align(std::size_t size);
    std::string_view take(std::uint64_t count);

    Serialisation kind_;
    ByteOrder order_ = ByteOrder::little;
    ByteCursor in_;
    std::size_t at_ = 0;  // behind CDR's encapsulation
};

}  // namespace superray
