// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_recording.h"

#include <superray/eval/input_error.h>

#include "sources/ros/byte_cursor.h"
#include "sources/ros/chunk_codec.h"

namespace superray {

std::optional<RosMessage> RosFile::next() {
    const auto after = [&] {
        return ", after " + std::to_string(messages()) + " whole messages";
    };
    try {
        auto message = read();
        messages_ += message.has_value();
        return message;
    } catch (const MalformedBytes& e) {
        throw InputError(path() + ": is damaged: " + e.what() + after());
    } catch (const TruncatedInputError& e) {
        throw TruncatedInputError(e.what() + after());
    }
}

std::string RosFile::unpacked(std::string_view codec, std::string_view packed,
                              std::uint64_t size) const {
    try {
        return decompressChunk(codec, packed, size);
    } catch (const InputError& e) {
        throw InputError(path() + ": " + e.what());
    }
}

std::size_t RosRecording::topicNumber(std::string name, std::string type,
                                      std::string encoding) {
    const std::string middle = "/msg/";
    const auto at = type.find(middle);
    if (at != std::string::npos) type.replace(at, middle.size(), "/");
    const RosTopic topic{std::move(name), std::move(type), std::move(encoding)};
    const auto [known, isNew] = numbers_.emplace(topic, topics_.size());
    if (isNew) topics_.push_back(topic);
    return known->second;
}

}  // namespace superray
