// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 2 in SQLite: the tables `topics` and `messages`.

#include <superray/eval/input_error.h>

#include "sources/ros/byte_cursor.h"
#include "sources/ros/ros_recording.h"

#if SUPERRAY_HAVE_SQLITE
#include <sqlite3.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <map>

#include "sources/bounded_file.h"
#endif

namespace superray {

#if SUPERRAY_HAVE_SQLITE

namespace {

struct CloseDatabase {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct CloseStatement {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, CloseStatement>;

/// Steps of SQLite's machine: far more than any recording needs, but damaged files may make
/// it walk in circles.
constexpr int kStepsAtOnce = 100'000;
constexpr std::uint64_t kBaseSteps = 50'000'000, kStepsPerByte = 100;

/// SQLite's name of a file that nobody writes: it is not locked, and nothing is made beside it.
std::string immutableName(const std::string& path) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    std::string name = "file:";
    for (const char c : std::filesystem::absolute(path).string()) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalnum(byte) != 0 || c == '/' || c == '.' || c == '-' || c == '_')
            name += c;
        else
            name += {'%', kDigits[byte / 16], kDigits[byte % 16]};
    }
    return name + "?immutable=1";
}

std::uint64_t bigEndian(const std::string& bytes, std::size_t at, std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i)
        value = value * 256 + static_cast<unsigned char>(bytes[at + i]);
    return value;
}

/// How many bytes the file must have, by its header; 0 if that does not tell.
std::uint64_t sizeToldBy(const std::string& header) {
    const bool isCurrent = bigEndian(header, 24, 4) == bigEndian(header, 92, 4);
    const std::uint64_t page = bigEndian(header, 16, 2);
    return isCurrent ? (page == 1 ? 65536 : page) * bigEndian(header, 28, 4) : 0;
}

class SqliteBag final : public RosFile {
 public:
    SqliteBag(const std::string& path, FileState state) : RosFile(path) {
        BoundedFile file(path);
        size_ = file.size();
        constexpr std::uint64_t kHeader = 100;
        if (size_ < kHeader) throw TruncatedInputError(path + ": ends early, in its header");
        isTruncated_ = sizeToldBy(file.read(kHeader)) > size_;
        for (const char* rest : {"-wal", "-journal"}) requireNone(path + rest);
        open();
        if (state == FileState::unknown && !isTruncated_) checkStructure();
        readTopics();
        rows_ = prepare("SELECT topic_id, data FROM messages ORDER BY id");
    }

 protected:
    std::optional<RosMessage> read() override {
        if (!step(rows_)) {
            if (isTruncated_) failTruncated("");
            return std::nullopt;
        }
        const auto topic = sqlite3_column_int64(rows_.get(), 0);
        const auto found = topics_.find(topic);
        if (found == topics_.end())
            throw MalformedBytes("a message is of topic " + std::to_string(topic) +
                                 ", which is not told");
        const auto* data = static_cast<const char*>(sqlite3_column_blob(rows_.get(), 1));
        const auto count = static_cast<std::size_t>(sqlite3_column_bytes(rows_.get(), 1));
        bytes_ += count;
        if (bytes_ > size_) throw MalformedBytes("its messages have more bytes than the file");
        return RosMessage{found->second, {data, data == nullptr ? 0 : count}};
    }

 private:
    /// Messages may be in there that are not in the file yet.
    static void requireNone(const std::string& rest) {
        std::error_code error;
        if (std::filesystem::file_size(rest, error) > 0 && !error)
            throw InputError(rest +
                             ": is left of a recording that was not ended: 'sqlite3 FILE.db3 "
                             "vacuum' brings it in");
    }

    void open() {
        sqlite3* raw = nullptr;
        const int result = sqlite3_open_v2(
            immutableName(path()).c_str(), &raw,
            SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
        database_.reset(raw);
        if (result != SQLITE_OK) throw InputError(path() + ": cannot be opened by SQLite");
        sqlite3_limit(raw, SQLITE_LIMIT_LENGTH,
                      static_cast<int>(std::clamp<std::uint64_t>(
                          size_, 1u << 20, std::numeric_limits<int>::max())));
        stepsLeft_ = kBaseSteps + kStepsPerByte * size_;
        sqlite3_progress_handler(raw, kStepsAtOnce, &SqliteBag::countSteps, this);
        step(prepare("PRAGMA trusted_schema = OFF"));
        step(prepare("PRAGMA cell_size_check = ON"));
    }

    static int countSteps(void* bag) {
        auto& left = static_cast<SqliteBag*>(bag)->stepsLeft_;
        left -= std::min<std::uint64_t>(left, kStepsAtOnce);
        return left == 0 ? 1 : 0;
    }

    Statement prepare(const std::string& text) {
        sqlite3_stmt* raw = nullptr;
        if (sqlite3_prepare_v2(database_.get(), text.c_str(), -1, &raw, nullptr) != SQLITE_OK)
            fail();
        return Statement(raw);
    }

    /// False at the end.
    bool step(const Statement& statement) {
        const int result = sqlite3_step(statement.get());
        if (result == SQLITE_ROW) return true;
        if (result == SQLITE_DONE) return false;
        fail();
    }

    [[noreturn]] void fail() const {
        const std::string why = sqlite3_errmsg(database_.get());
        if (isTruncated_) failTruncated(" (" + why + ")");
        throw InputError(path() + ": is damaged: " + why + ", after " +
                         std::to_string(messages()) + " whole messages");
    }

    [[noreturn]] void failTruncated(const std::string& why) const {
        throw TruncatedInputError(path() + ": ends early" + why + ": it has " +
                                  std::to_string(size_) + " bytes, its header tells more");
    }

    std::string text(const Statement& statement, int column) const {
        const auto* start = sqlite3_column_text(statement.get(), column);
        return start == nullptr ? std::string() : reinterpret_cast<const char*>(start);
    }

    void checkStructure() {
        const Statement check = prepare("PRAGMA integrity_check(1)");
        if (!step(check)) return;
        const std::string found = text(check, 0);
        if (found != "ok")
            throw InputError(
                path() + ": is damaged: " +
                std::string(found.begin(), std::find(found.begin(), found.end(), '\n')));
    }

    void readTopics() {
        const Statement tables = prepare(
            "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN "
            "('topics', 'messages')");
        if (!step(tables) || sqlite3_column_int(tables.get(), 0) != 2)
            throw InputError(path() +
                             ": is SQLite, but no bag of ROS 2: it must have the tables "
                             "topics and messages");
        const Statement rows =
            prepare("SELECT id, name, type, serialization_format FROM topics");
        while (step(rows))
            topics_[sqlite3_column_int64(rows.get(), 0)] =
                topicNumber(text(rows, 1), text(rows, 2), text(rows, 3));
    }

    std::uint64_t size_ = 0, bytes_ = 0, stepsLeft_ = 0;
    bool isTruncated_ = false;
    std::unique_ptr<sqlite3, CloseDatabase> database_;
    Statement rows_;
    std::map<std::int64_t, std::size_t> topics_;
};

}  // namespace

std::unique_ptr<RosRecording> openSqliteBag(const std::string& path, FileState state) {
    return std::make_unique<SqliteBag>(path, state);
}

#else

std::unique_ptr<RosRecording> openSqliteBag(const std::string& path, FileState) {
    throw InputError(path +
                     ": is a bag of ROS 2 in SQLite, which this program was built without: "
                     "install libsqlite3-dev and build it again");
}

#endif

}  // namespace superray
