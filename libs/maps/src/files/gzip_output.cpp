// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/gzip_output.h>
#include <superray/storage/atomic_file.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>
#include <vector>

namespace superray {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;

}  // namespace

struct GzipOutput::State {
    explicit State(const std::string& path) : file(path), deflated(kBufferSize) {
        constexpr int kGzipWithLargestWindow = 16 + MAX_WBITS, kMemoryLevel = 8;
        if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzipWithLargestWindow,
                         kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
    }
    ~State() { deflateEnd(&stream); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    /// Compresses what is in the stream's input.
    void run(int flush) {
        do {
            stream.next_out = deflated.data();
            stream.avail_out = static_cast<uInt>(deflated.size());
            deflate(&stream, flush);
            file.write(deflated.data(), deflated.size() - stream.avail_out);
        } while (stream.avail_out == 0);
    }

    AtomicFile file;
    std::vector<Bytef> deflated;
    z_stream stream{};
    std::uint64_t position = 0;
};

GzipOutput::GzipOutput(const std::string& path) : state_(std::make_unique<State>(path)) {}

GzipOutput::~GzipOutput() = default;

std::size_t GzipOutput::Write(const void* buffer, std::size_t count) {
    constexpr std::size_t kMost = std::numeric_limits<uInt>::max();
    State& s = *state_;
    const auto* bytes = static_cast<const Bytef*>(buffer);
    for (std::size_t done = 0; done < count;) {
        const std::size_t step = std::min(count - done, kMost);
        s.stream.next_in = const_cast<Bytef*>(bytes + done);
        s.stream.avail_in = static_cast<uInt>(step);
        s.run(Z_NO_FLUSH);
        done += step;
    }
    s.position += count;
    return count;
}

void GzipOutput::commit() {
    state_->stream.avail_in = 0;
    state_->run(Z_FINISH);
    state_->file.commit();
}

std::uint64_t GzipOutput::getPosition() const {
    return state_->position;
}

void writeGzip(const mrpt::serialization::CSerializable& object, const std::string& path) {
    GzipOutput file(path);
    mrpt::serialization::archiveFrom(file) << object;
    file.commit();
}

}  // namespace superray
