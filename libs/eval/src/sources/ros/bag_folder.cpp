// SPDX-License-Identifier: BSD-3-Clause
// Folders of ROS 2: a recording that is split into files, which metadata.yaml lists.

#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>
#include <utility>

#include "sources/file_bytes.h"
#include "sources/folders/frame_source.h"
#include "sources/ros/ros_recording.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";
constexpr std::uint64_t kMostMetadata = 16u << 20;

/// Without blanks and quotes about it.
std::string bare(const std::string& text) {
    const char* const blanks = " \t\r";
    const auto first = text.find_first_not_of(blanks);
    if (first == std::string::npos) return {};
    std::string inner = text.substr(first, text.find_last_not_of(blanks) + 1 - first);
    const bool isQuoted = inner.size() >= 2 && inner.front() == inner.back() &&
                          (inner.front() == '"' || inner.front() == '\'');
    return isQuoted ? inner.substr(1, inner.size() - 2) : inner;
}

/// What of metadata.yaml is needed. ROS writes it in one way: a key or a list entry a line.
struct Metadata {
    std::vector<std::string> files;
    std::string compression;  ///< its mode: empty, "FILE" or "MESSAGE"
    std::optional<std::uint64_t> messages;
};

Metadata readMetadata(const fs::path& path) {
    Metadata found;
    std::istringstream lines(readFileBytes(path.string(), kMostMetadata));
    bool inFiles = false;
    std::size_t countIndent = std::string::npos;
    for (std::string line; std::getline(lines, line);) {
        const auto words = wordsOf(line);
        if (words.empty() || words[0][0] == '#') continue;
        const std::size_t indent = line.find(words[0]);
        const auto value = bare(line.substr(indent + words[0].size()));
        if (words[0] == "-") {
            if (inFiles) found.files.push_back(value);
            continue;
        }
        inFiles = words[0] == "relative_file_paths:";
        if (words[0] == "compression_mode:") found.compression = value;
        // Topics and files have counts, too, further to the right.
        if (words[0] == "message_count:" && indent < countIndent) {
            const auto count = parseNumber(value);
            if (!count || *count < 0)
                throw InputError(path.string() + ": message_count '" + value +
                                 "' must be a number");
            found.messages = static_cast<std::uint64_t>(*count);
            countIndent = indent;
        }
    }
    return found;
}

/// A recording after the other.
class BagFolder final : public RosRecording {
 public:
    BagFolder(const std::string& folder, FileState state)
        : RosRecording(folder), state_(state) {
        const fs::path path(folder);
        if (!fs::exists(path / kMetadata)) {
            for (const auto& file : listFrames(path, {".db3", ".mcap"}))
                files_.push_back(file.string());
            return;
        }
        const Metadata told = readMetadata(path / kMetadata);
        hasMetadata_ = true;
        messagesTold_ = told.messages;
        const std::string where = (path / kMetadata).string();
        if (told.files.empty())
            throw InputError(where + ": lists no files (relative_file_paths)");
        if (!told.compression.empty() && !equalIgnoringCase(told.compression, "none"))
            throw InputError(where + ": the recording is compressed (mode " + told.compression +
                             "), which is not read: 'ros2 bag convert' it, or unpack files "
                             "by 'zstd -d' and name them to superray-map");
        for (const std::string& file : told.files) {
            // Old releases wrote the folder's name, too.
            const fs::path beside = path / file, inFolder = path / fs::path(file).filename();
            files_.push_back((fs::is_regular_file(beside) ? beside : inFolder).string());
            if (!fs::is_regular_file(files_.back()))  // nor the folder itself
                throw InputError(where + ": lists '" + file + "', which is not there");
        }
    }

    std::optional<RosMessage> next() override {
        while (part_ || opened_ < files_.size()) {
            if (!part_) {
                part_ = openRosRecording(files_[opened_++], state_);
                numbers_.clear();
            }
            if (const auto message = part_->next()) {
                ++messages_;
                return RosMessage{numberOf(message->topic), message->bytes};
            }
            part_.reset();
        }
        if (!hasMetadata_)
            throw TruncatedInputError(path() + ": has no " + kMetadata +
                                      ", as its recording was not ended: 'ros2 bag reindex' "
                                      "mends that");
        if (messagesTold_ && *messagesTold_ != messages())
            throw InputError(path() + ": has " + std::to_string(messages()) +
                             " messages, its " + kMetadata + " tells " +
                             std::to_string(*messagesTold_) +
                             "; 'ros2 bag reindex' makes a new one");
        return std::nullopt;
    }

 private:
    /// Topics of the part have other numbers.
    std::size_t numberOf(std::size_t inPart) {
        for (std::size_t i = numbers_.size(); i <= inPart; ++i) {
            const RosTopic& topic = part_->topics()[i];
            numbers_.push_back(topicNumber(topic.name, topic.type, topic.encoding));
        }
        return numbers_[inPart];
    }

    FileState state_;
    std::vector<std::string> files_;
    bool hasMetadata_ = false;
    std::optional<std::uint64_t> messagesTold_;
    std::size_t opened_ = 0;
    std::unique_ptr<RosRecording> part_;
    std::vector<std::size_t> numbers_;
};

}  // namespace

bool isBagFolder(const std::string& path) {
    std::error_code error;
    if (fs::is_regular_file(fs::path(path) / kMetadata, error)) {
        const auto text = readFileBytes((fs::path(path) / kMetadata).string(), kMostMetadata);
        if (text.find("rosbag2_bagfile_information") != std::string::npos) return true;
    }
    return !listFrames(path, {".db3", ".mcap"}).empty();
}

std::unique_ptr<RosRecording> openBagFolder(const std::string& path, FileState state) {
    return std::make_unique<BagFolder>(path, state);
}

}  // namespace superray
