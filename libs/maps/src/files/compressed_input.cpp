// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/compressed_input.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "files/decoder.h"

namespace superray {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

}  // namespace

struct CompressedInput::State {
    explicit State(const std::string& path) : raw(kBufferSize), decoded(kBufferSize) {
        std::error_code code;
        if (!std::filesystem::exists(path, code))
            throw std::runtime_error(path + ": no such file");
        if (!std::filesystem::is_regular_file(path, code))
            throw std::runtime_error(path + ": is not a file");
        size = std::filesystem::file_size(path, code);
        file.open(path, std::ios::binary);
        if (!file) throw std::runtime_error(path + ": cannot be opened for reading");
        fetch();
        compression = recognise(input.next, input.count);
        decoder = makeDecoder(compression);
    }

    /// Reads on in the file; there is no input left.
    void fetch() {
        file.read(reinterpret_cast<char*>(raw.data()),
                  static_cast<std::streamsize>(raw.size()));
        input = {raw.data(), static_cast<std::size_t>(file.gcount())};
        fetched += input.count;
        fileEnds = !file;
        if (file.bad()) error = "the file cannot be read (input error)";
    }

    /// Decodes on; nothing decoded is left. False at the end, or after an error.
    bool decodeMore() {
        begin = end = 0;
        while (end == 0 && error.empty()) {
            if (input.count == 0 && !fileEnds) fetch();
            end = decoder->decode(input, decoded.data(), decoded.size());
            error = error.empty() ? decoder->error() : error;
            if (end > 0 || !error.empty() || input.count > 0 || !fileEnds) continue;
            if (!decoder->atBorder() && fetched > 0) {
                truncated = true;
                error = std::string("the ") +
                        (compression == Compression::zstd ? "zstd" : "gzip") +
                        " data are truncated";
            }
            break;
        }
        return end > 0;
    }

    std::ifstream file;
    std::uint64_t size = 0;     ///< of the file [bytes]
    std::uint64_t fetched = 0;  ///< bytes read from the file
    bool fileEnds = false;
    std::vector<unsigned char> raw;  ///< of the file
    InputBytes input;                ///< what of `raw` is not yet decoded
    std::vector<unsigned char> decoded;
    std::size_t begin = 0, end = 0;  ///< what of `decoded` is not yet read
    std::string unread;              ///< to be read again, before all others
    std::uint64_t position = 0;      ///< bytes read from the stream
    Compression compression = Compression::none;
    std::unique_ptr<Decoder> decoder;
    std::string error;
    bool truncated = false;
};

CompressedInput::CompressedInput(const std::string& path)
    : state_(std::make_unique<State>(path)) {}

CompressedInput::~CompressedInput() = default;

Compression CompressedInput::compression() const {
    return state_->compression;
}

bool CompressedInput::atEnd() {
    return state_->begin == state_->end && !state_->decodeMore();
}

// An error is told once all bytes before it were read.
std::string CompressedInput::error() const {
    return state_->begin == state_->end ? state_->error : std::string();
}

bool CompressedInput::truncated() const {
    return state_->truncated && !error().empty();
}

std::uint64_t CompressedInput::fileOffset() const {
    return state_->fetched - state_->input.count;
}

std::uint64_t CompressedInput::fileSize() const {
    return state_->size;
}

std::uint64_t CompressedInput::getPosition() const {
    return state_->position;
}

void CompressedInput::unread(const std::string& bytes) {
    state_->unread.insert(0, bytes);
    state_->position -= bytes.size();
}

std::size_t CompressedInput::Read(void* buffer, std::size_t count) {
    auto* out = static_cast<unsigned char*>(buffer);
    std::size_t done = std::min(count, state_->unread.size());
    std::memcpy(out, state_->unread.data(), done);
    state_->unread.erase(0, done);
    while (done < count && !atEnd()) {
        const std::size_t some = std::min(count - done, state_->end - state_->begin);
        std::memcpy(out + done, state_->decoded.data() + state_->begin, some);
        state_->begin += some;
        done += some;
    }
    state_->position += done;
    return done;
}

}  // namespace superray
