// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1, version 2.0: records of named fields and data. Messages are in chunks, each
// followed by its index; connections and a list of the chunks end the file.

#include <superray/eval/input_error.h>

#include <algorithm>
#include <map>
#include <utility>

#include "sources/bounded_file.h"
#include "sources/ros/byte_cursor.h"
#include "sources/ros/ros_recording.h"

namespace superray {
namespace {

enum Op : std::uint8_t {
    kMessage = 2,
    kBagHeader = 3,
    kIndex = 4,
    kChunk = 5,
    kChunkInfo = 6,
    kConnection = 7
};

/// The fields of a header: name=value, each after its length.
class Fields {
 public:
    explicit Fields(std::string_view header) {
        ByteCursor in(header);
        while (in.left() > 0) {
            const auto field = in.counted<std::uint32_t>();
            const auto equals = field.find('=');
            if (equals == std::string_view::npos)
                throw MalformedBytes("a header field has no '='");
            fields_[field.substr(0, equals)] = field.substr(equals + 1);
        }
    }
    bool has(std::string_view name) const { return fields_.count(name) > 0; }
    std::string_view text(std::string_view name) const {
        const auto found = fields_.find(name);
        if (found == fields_.end())
            throw MalformedBytes("a record has no field '" + std::string(name) + "'");
        return found->second;
    }
    template <class T>
    T number(std::string_view name) const {
        const auto bytes = text(name);
        if (bytes.size() != sizeof(T))
            throw MalformedBytes("field '" + std::string(name) + "' has " +
                                 std::to_string(bytes.size()) + " bytes");
        return ByteCursor(bytes).number<T>();
    }

 private:
    std::map<std::string_view, std::string_view> fields_;
};

class Ros1Bag final : public RosFile {
 public:
    explicit Ros1Bag(const std::string& path) : RosFile(path), file_(path) {
        const std::string magic = "#ROSBAG V2.0\n";
        const auto start = file_.read(std::min<std::uint64_t>(magic.size(), file_.size()));
        if (start != magic)
            throw InputError(path + ": is not a bag of ROS 1, version 2.0" +
                             (start.rfind("#ROSBAG V", 0) == 0
                                  ? "; older ones are converted by 'rosbag fix'"
                                  : ": it must begin with '#ROSBAG V2.0'"));
        try {
            readBagHeader();
        } catch (const MalformedBytes& e) {
            throw InputError(path + ": its bag header is damaged: " + e.what());
        }
    }

 protected:
    std::optional<RosMessage> read() override {
        for (;;) {
            if (inChunk_.left() > 0) {
                if (auto message = readInChunk()) return message;
            } else if (file_.left() == 0) {
                finish();
                return std::nullopt;
            } else if (auto message = readRecord()) {
                return message;
            }
        }
    }

 private:
    void readBagHeader() {
        const auto header = readCounted();
        const Fields fields(header);
        if (fields.number<std::uint8_t>("op") != kBagHeader)
            throw MalformedBytes("it has another kind");
        indexAt_ = fields.number<std::uint64_t>("index_pos");
        connectionsTold_ = fields.number<std::uint32_t>("conn_count");
        chunksTold_ = fields.number<std::uint32_t>("chunk_count");
        if (fields.has("encryptor") && !fields.text("encryptor").empty())
            throw InputError(path() + ": is encrypted; 'rosbag decrypt' it first");
        readCounted();  // blanks
        if (indexAt_ > 0 && indexAt_ < file_.position())
            throw MalformedBytes("index_pos " + std::to_string(indexAt_) + " is within it");
    }

    /// Data after their length. \throws TruncatedInputError, or MalformedBytes within the
    /// part that the bag's own header says is there
    std::string readCounted() {
        const std::string length = checked(sizeof(std::uint32_t));
        return checked(ByteCursor(length).number<std::uint32_t>());
    }
    std::string checked(std::uint64_t count) {
        const bool isBeforeIndex = file_.position() < indexAt_ && indexAt_ <= file_.size();
        if (isBeforeIndex && count > indexAt_ - file_.position())
            throw MalformedBytes("the record at byte " + std::to_string(file_.position()) +
                                 " reaches into the index");
        try {
            return file_.read(count);
        } catch (const TruncatedInputError& e) {
            throw TruncatedInputError(e.what() + mending());
        }
    }
    std::string mending() const {
        return indexAt_ == 0 ? "; the bag has no index, as its recording was not ended: "
                               "'rosbag reindex' mends that"
                             : std::string();
    }

    std::optional<RosMessage> readRecord() {
        const auto header = readCounted();
        const Fields fields(header);
        const auto op = fields.number<std::uint8_t>("op");
        data_ = readCounted();
        switch (op) {
            case kMessage:
                return messageOf(fields, data_);
            case kChunk:
                beginChunk(fields);
                break;
            case kIndex:
                checkIndex(fields);
                break;
            case kConnection:
                addConnection(fields, data_);
                break;
            case kChunkInfo:
                ++chunkInfos_;
                break;
            default:
                throw MalformedBytes("a record of the unknown kind " + std::to_string(op));
        }
        return std::nullopt;
    }

    void beginChunk(const Fields& fields) {
        requireIndexOfChunk();
        ++chunks_;
        const auto compression = fields.text("compression");
        const auto size = fields.number<std::uint32_t>("size");
        if (compression == "none") {
            if (size != data_.size())
                throw MalformedBytes("a chunk has " + std::to_string(data_.size()) +
                                     " bytes, " + std::to_string(size) + " are told");
            chunk_ = std::move(data_);
        } else {
            chunk_ = unpacked(compression, data_, size);
        }
        inChunk_ = ByteCursor(chunk_);
    }

    std::optional<RosMessage> readInChunk() {
        const Fields fields(inChunk_.counted<std::uint32_t>());
        const auto data = inChunk_.counted<std::uint32_t>();
        const auto op = fields.number<std::uint8_t>("op");
        if (op == kMessage) {
            ++inIndex_[fields.number<std::uint32_t>("conn")];
            return messageOf(fields, data);
        }
        if (op != kConnection)
            throw MalformedBytes("a chunk has a record of kind " + std::to_string(op));
        addConnection(fields, data);
        return std::nullopt;
    }

    RosMessage messageOf(const Fields& fields, std::string_view data) const {
        const auto number = fields.number<std::uint32_t>("conn");
        const auto found = connections_.find(number);
        if (found == connections_.end())
            throw MalformedBytes("a message is of connection " + std::to_string(number) +
                                 ", which is not told");
        return {found->second, data};
    }

    void addConnection(const Fields& fields, std::string_view data) {
        const Fields about(data);
        const auto number = fields.number<std::uint32_t>("conn");
        const auto topic = topicNumber(std::string(fields.text("topic")),
                                       std::string(about.text("type")), "ros1");
        const auto [known, isNew] = connections_.emplace(number, topic);
        if (!isNew && known->second != topic)
            throw MalformedBytes("connection " + std::to_string(number) +
                                 " is told twice, of different topics");
    }

    /// How many messages of a connection the chunk before has.
    void checkIndex(const Fields& fields) {
        const auto connection = fields.number<std::uint32_t>("conn");
        const auto told = fields.number<std::uint32_t>("count");
        const auto found = inIndex_.find(connection);
        const auto has = found == inIndex_.end() ? 0 : found->second;
        if (told != has)
            throw MalformedBytes("chunk " + std::to_string(chunks_) + " has " +
                                 std::to_string(has) + " messages of connection " +
                                 std::to_string(connection) + ", its index " +
                                 std::to_string(told));
        inIndex_.erase(connection);
    }

    void requireIndexOfChunk() const {
        if (inIndex_.empty()) return;
        const std::string why =
            "chunk " + std::to_string(chunks_) + " has no index of its messages";
        if (file_.left() > 0) throw MalformedBytes(why);
        throw TruncatedInputError(path() + ": ends early: " + why + mending());
    }

    void finish() const {
        requireIndexOfChunk();
        if (indexAt_ == 0) throw TruncatedInputError(path() + ": ends early" + mending());
        if (indexAt_ > file_.size())
            throw TruncatedInputError(
                path() + ": ends early: its index is said to be at byte " +
                std::to_string(indexAt_) + ", it has " + std::to_string(file_.size()));
        const auto require = [&](std::uint64_t told, std::uint64_t has, const char* what) {
            if (has < told)
                throw TruncatedInputError(path() + ": ends early: it has " +
                                          std::to_string(has) + " of " + std::to_string(told) +
                                          what);
            if (has > told)
                throw MalformedBytes("it has " + std::to_string(has) + what + ", " +
                                     std::to_string(told) + " are told");
        };
        if (chunks_ != chunksTold_)
            throw MalformedBytes("it has " + std::to_string(chunks_) + " chunks, " +
                                 std::to_string(chunksTold_) + " are told");
        require(connectionsTold_, connections_.size(), " connections");
        require(chunksTold_, chunkInfos_, " entries of chunks in its index");
    }

    BoundedFile file_;
    std::uint64_t indexAt_ = 0, chunks_ = 0, chunkInfos_ = 0;
    std::uint32_t connectionsTold_ = 0, chunksTold_ = 0;
    std::map<std::uint32_t, std::size_t> connections_;  // to topics
    std::map<std::uint32_t, std::uint32_t> inIndex_;    // of the chunk, not yet confirmed
    std::string data_, chunk_;
    ByteCursor inChunk_{{}};
};

}  // namespace

std::unique_ptr<RosRecording> openRos1Bag(const std::string& path) {
    return std::make_unique<Ros1Bag>(path);
}

}  // namespace superray
