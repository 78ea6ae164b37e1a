// SPDX-License-Identifier: BSD-3-Clause
// MCAP: records of a kind, a length and contents; messages of channels, in chunks or not; then
// a summary with counts. See mcap.dev/spec.

#include <superray/eval/input_error.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "sources/bounded_file.h"
#include "sources/ros/byte_cursor.h"
#include "sources/ros/ros_recording.h"

namespace superray {
namespace {

enum Op : std::uint8_t {
    kHeader = 1,
    kFooter = 2,
    kSchema = 3,
    kChannel = 4,
    kMessage = 5,
    kChunk = 6,
    kStatistics = 11,
    kDataEnd = 15
};

/// As zlib computes it; 0 at the start.
class CheckSum {
 public:
    void add(std::string_view bytes) {
        while (!bytes.empty()) {
            const auto part = bytes.substr(0, kMost);
            sum_ = crc32(sum_, reinterpret_cast<const Bytef*>(part.data()),
                         static_cast<uInt>(part.size()));
            bytes.remove_prefix(part.size());
        }
    }
    std::uint32_t value() const { return static_cast<std::uint32_t>(sum_); }

 private:
    static constexpr std::size_t kMost = std::size_t{1} << 30;
    uLong sum_ = 0;
};

void require(std::uint32_t told, std::uint32_t has, const char* what) {
    if (told != 0 && told != has)  // 0: not told
        throw MalformedBytes("the check sum of " + std::string(what) + " is wrong");
}

const std::string kMagic("\x89MCAP0\r\n", 8);

class McapFile final : public RosFile {
 public:
    explicit McapFile(const std::string& path) : RosFile(path), file_(path) {
        const std::uint64_t least = kMagic.size();
        if (file_.size() < least || file_.read(least) != kMagic)
            throw InputError(path + ": is not MCAP, version 0: it begins otherwise");
        if (file_.size() >= 2 * least) {
            file_.seek(file_.size() - least);
            isEnded_ = file_.read(least) == kMagic;
            file_.seek(least);
        }
        all_.add(kMagic);
    }

 protected:
    std::optional<RosMessage> read() override {
        while (!isDone_) {
            if (inChunk_.left() > 0) {
                const auto op = inChunk_.number<std::uint8_t>();
                const auto contents = inChunk_.counted<std::uint64_t>();
                if (op != kSchema && op != kChannel && op != kMessage)
                    throw MalformedBytes("a chunk has a record of kind " + std::to_string(op));
                if (auto message = take(op, contents)) return message;
            } else if (auto message = readRecord()) {
                return message;
            }
        }
        return std::nullopt;
    }

 private:
    std::string readBytes(std::uint64_t count) {
        try {
            return file_.read(count);
        } catch (const TruncatedInputError& e) {
            if (isEnded_) throw MalformedBytes("a record reaches beyond its end");
            throw TruncatedInputError(std::string(e.what()) +
                                      "; its recording was not ended: 'mcap recover' mends "
                                      "that");
        }
    }

    std::optional<RosMessage> readRecord() {
        constexpr std::uint64_t kHead = 9;
        const std::string head = readBytes(kHead);
        ByteCursor in(head);
        const auto op = in.number<std::uint8_t>();
        const auto length = in.number<std::uint64_t>();
        if (op == 0) throw MalformedBytes("a record has kind 0");
        record_ = readBytes(length);
        if (op == kFooter) return finish(head);
        if (op == kDataEnd) {
            endData();
        } else {
            addToSums(head, op);
        }
        return take(op, record_);
    }

    /// Writers disagree on whether the data section begins with the file, or after its header.
    void addToSums(const std::string& head, std::uint8_t op) {
        for (const std::string_view bytes :
             {std::string_view(head), std::string_view(record_)}) {
            all_.add(bytes);
            if (op != kHeader) section_.add(bytes);
        }
    }

    void endData() {
        ByteCursor in(record_);
        const auto told = in.number<std::uint32_t>();
        if (told != all_.value()) require(told, section_.value(), "its data");
        section_ = {};
        inSummary_ = true;
    }

    std::optional<RosMessage> take(std::uint8_t op, std::string_view contents) {
        ByteCursor in(contents);
        switch (op) {
            case kSchema:
                addSchema(in);
                break;
            case kChannel:
                addChannel(in);
                break;
            case kChunk:
                beginChunk(in);
                break;
            case kStatistics:
                messagesTold_ = in.number<std::uint64_t>();
                break;
            case kMessage: {
                const auto number = in.number<std::uint16_t>();
                const auto found = channels_.find(number);
                if (found == channels_.end())
                    throw MalformedBytes("a message is of channel " + std::to_string(number) +
                                         ", which is not told");
                in.take(20);  // sequence number, time of the log, time of publishing
                return RosMessage{found->second, in.take(in.left())};
            }
            default:
                break;  // indices, attachments, metadata, and what later versions add
        }
        return std::nullopt;
    }

    void addSchema(ByteCursor in) {
        const auto number = in.number<std::uint16_t>();
        schemas_[number] = in.counted<std::uint32_t>();
    }

    void addChannel(ByteCursor in) {
        const auto number = in.number<std::uint16_t>();
        const auto schema = in.number<std::uint16_t>();
        const std::string topic(in.counted<std::uint32_t>());
        const std::string encoding(in.counted<std::uint32_t>());
        const auto type = schemas_.find(schema);
        if (schema != 0 && type == schemas_.end())
            throw MalformedBytes("channel " + std::to_string(number) + " is of schema " +
                                 std::to_string(schema) + ", which is not told");
        const auto topicIs =
            topicNumber(topic, type == schemas_.end() ? std::string() : type->second, encoding);
        const auto [known, isNew] = channels_.emplace(number, topicIs);
        if (!isNew && known->second != topicIs)
            throw MalformedBytes("channel " + std::to_string(number) +
                                 " is told twice, differently");
    }

    void beginChunk(ByteCursor in) {
        in.take(16);  // first and last time
        const auto size = in.number<std::uint64_t>();
        const auto sum = in.number<std::uint32_t>();
        const auto codec = in.counted<std::uint32_t>();
        const auto records = in.counted<std::uint64_t>();
        if (codec.empty() && records.size() != size)
            throw MalformedBytes("a chunk has " + std::to_string(records.size()) + " bytes, " +
                                 std::to_string(size) + " are told");
        chunk_ = codec.empty() ? std::string(records) : unpacked(codec, records, size);
        CheckSum has;
        has.add(chunk_);
        require(sum, has.value(), "a chunk");
        inChunk_ = ByteCursor(chunk_);
    }

    std::optional<RosMessage> finish(const std::string& head) {
        if (!inSummary_) throw MalformedBytes("its data have no end");
        ByteCursor in(record_);
        const auto summary = in.take(16);
        const auto told = in.number<std::uint32_t>();
        section_.add(head);
        section_.add(summary);
        require(told, section_.value(), "its summary");
        if (readBytes(kMagic.size()) != kMagic || file_.left() > 0)
            throw MalformedBytes("other data follow its footer");
        if (messagesTold_ && *messagesTold_ != messages())
            throw MalformedBytes("it has " + std::to_string(messages()) + " messages, " +
                                 std::to_string(*messagesTold_) + " are told");
        isDone_ = true;
        return std::nullopt;
    }

    BoundedFile file_;
    bool isEnded_ = false, inSummary_ = false, isDone_ = false;
    CheckSum all_, section_;
    std::optional<std::uint64_t> messagesTold_;
    std::map<std::uint16_t, std::string> schemas_;
    std::map<std::uint16_t, std::size_t> channels_;
    std::string record_, chunk_;
    ByteCursor inChunk_{{}};
};

}  // namespace

std::unique_ptr<RosRecording> openMcap(const std::string& path) {
    return std::make_unique<McapFile>(path);
}

}  // namespace superray
