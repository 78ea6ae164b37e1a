// SPDX-License-Identifier: BSD-3-Clause
#include <superray/storage/atomic_file.h>

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <vector>

#include "file/temporary_file.h"

namespace superray {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

void writeAll(int fd, const char* data, std::size_t size, const std::string& path) {
    while (size > 0) {
        const ssize_t n = ::write(fd, data, size);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) failOnFile("write", path, n < 0 ? errno : EIO);
        data += n;
        size -= static_cast<std::size_t>(n);
    }
}

}  // namespace

struct AtomicFile::State {
    explicit State(const std::string& p) : path(p) {
        buffer.reserve(kBufferSize);
        const OutputTarget target = findOutputTarget(path);
        if (target.kind != OutputTarget::Kind::stream) {
            temporary.emplace(target);
            return;
        }
        stream = FileDescriptor(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
        if (!stream.isOpen()) failOnFile("write", path, errno);
    }

    void put(const char* data, std::size_t size) {
        if (failed) throw MapFileError("cannot write " + path + ": an earlier write failed");
        failed = true;  // until all went well
        writeAll(temporary ? temporary->fd() : stream.get(), data, size, path);
        failed = false;
    }

    void flush() {
        put(buffer.data(), buffer.size());
        buffer.clear();
    }

    std::string path;
    std::vector<char> buffer;
    std::optional<TemporaryFile> temporary;
    FileDescriptor stream;
    bool failed = false;
};

AtomicFile::AtomicFile(const std::string& path) : state_(std::make_unique<State>(path)) {}

AtomicFile::~AtomicFile() = default;

void AtomicFile::write(const void* data, std::size_t size) {
    State& s = *state_;
    const char* bytes = static_cast<const char*>(data);
    if (s.buffer.size() + size > kBufferSize) s.flush();
    if (size >= kBufferSize) return s.put(bytes, size);
    s.buffer.insert(s.buffer.end(), bytes, bytes + size);
}

void AtomicFile::commit() {
    State& s = *state_;
    s.flush();
    s.failed = true;  // nothing can be written after it
    if (s.temporary)
        s.temporary->replaceTarget();
    else if (!s.stream.close())
        failOnFile("close", s.path, errno);
}

class AtomicStream::Buffer : public std::streambuf {
 public:
    explicit Buffer(const std::string& path) : file(path) {}

    AtomicFile file;
    std::exception_ptr error;  ///< the first one

 protected:
    std::streamsize xsputn(const char* data, std::streamsize size) override {
        try {
            if (error) return 0;
            file.write(data, static_cast<std::size_t>(size));
            return size;
        } catch (...) {
            error = std::current_exception();
            return 0;
        }
    }
    int_type overflow(int_type c) override {
        if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
        const char byte = traits_type::to_char_type(c);
        return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
    }
};

AtomicStream::AtomicStream(const std::string& path)
    : std::ostream(nullptr), buffer_(std::make_unique<Buffer>(path)) {
    rdbuf(buffer_.get());
}

AtomicStream::~AtomicStream() = default;

void AtomicStream::commit() {
    if (buffer_->error) std::rethrow_exception(buffer_->error);
    if (!*this) throw MapFileError("cannot write a file: its contents could not be made");
    buffer_->file.commit();
}

void writeFileAtomically(const std::string& path, std::string_view contents) {
    AtomicFile file(path);
    file.write(contents.data(), contents.size());
    file.commit();
}

void checkOutputFile(const std::string& path) {
    const OutputTarget target = findOutputTarget(path);
    const auto& checked =
        target.kind == OutputTarget::Kind::stream ? target.path : target.folder();
    if (::faccessat(AT_FDCWD, checked.c_str(), W_OK, AT_EACCESS) != 0)
        failOnFile("write", path + " (in " + checked + ")", errno);
}

}  // namespace superray
