// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/message_cursor.h"

namespace superray {

MessageCursor::MessageCursor(std::string_view bytes, Serialisation kind)
    : kind_(kind), in_(bytes) {
    if (kind_ == Serialisation::ros1) return;
    const auto encapsulation = in_.take(4);
    if (encapsulation[0] == '\x28' && encapsulation[1] == '\xb5')
        throw MalformedBytes(
            "it is compressed by itself (compression mode 'message'), which is not read: "
            "'ros2 bag convert' the recording without");
    if (encapsulation[0] != 0 || (encapsulation[1] != 0 && encapsulation[1] != 1))
        throw MalformedBytes(
            "its encapsulation is neither plain CDR of little nor of big "
            "endian numbers");
    order_ = encapsulation[1] == 0 ? ByteOrder::big : ByteOrder::little;
}

std::string_view MessageCursor::take(std::uint64_t count) {
    at_ += static_cast<std::size_t>(std::min<std::uint64_t>(count, in_.left()));
    return in_.take(count);
}

void MessageCursor::align(std::size_t size) {
    if (kind_ == Serialisation::cdr) take((size - at_ % size) % size);
}

std::size_t MessageCursor::count(std::size_t least) {
    const auto told = number<std::uint32_t>();
    if (told > in_.left() / least)
        throw MalformedBytes("tells " + std::to_string(told) + " elements where " +
                             std::to_string(in_.left()) + " bytes are left");
    return told;
}

std::string MessageCursor::text() {
    std::string text(take(count(1)));
    if (kind_ == Serialisation::cdr && !text.empty()) {
        if (text.back() != '\0') throw MalformedBytes("a text is not ended");
        text.pop_back();
    }
    return text;
}

std::string_view MessageCursor::bytes() {
    return take(count(1));
}

void MessageCursor::expectEnd() const {
    constexpr std::size_t kPadding = 7;  // up to the largest alignment
    if (in_.left() > (kind_ == Serialisation::cdr ? kPadding : 0))
        throw MalformedBytes(std::to_string(in_.left()) + " bytes follow its last field");
}

}  // namespace superray
