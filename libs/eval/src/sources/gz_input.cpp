#include "sources/gz_input.h"

#include <superray/eval/input_error.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>

namespace superray {

GzInput::GzInput(const std::string& path) : file_(nullptr) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(path + ": no such file");
    if (!std::filesystem::is_regular_file(path, error))
        throw InputError(path + ": is not a file");
    fileSize_ = std::filesystem::file_size(path, error);
    file_ = gzopen(path.c_str(), "rb");
    if (file_ == nullptr) throw InputError(path + ": cannot be opened for reading");
    gzbuffer(file_, 1u << 18);
}

GzInput::~GzInput() {
    if (file_ != nullptr) gzclose(file_);
}

bool GzInput::atEnd() {
    const int byte = gzgetc(file_);
    if (byte < 0) return true;
    gzungetc(byte, file_);
    return false;
}

std::string GzInput::error() const {
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (code == Z_OK || code == Z_STREAM_END) return {};
    if (code == Z_BUF_ERROR) return "the compressed data is truncated";
    return std::string("the compressed data is damaged (") + text + ")";
}

std::uint64_t GzInput::fileOffset() const {
    return static_cast<std::uint64_t>(std::max<z_off_t>(0, gzoffset(file_)));
}

std::uint64_t GzInput::getPosition() const {
    return static_cast<std::uint64_t>(std::max<z_off_t>(0, gztell(file_)));
}

std::size_t GzInput::Read(void* buffer, std::size_t count) {
    // gzread takes an unsigned int; objects may be larger.
    constexpr std::size_t kChunk = std::size_t{1} << 30;
    auto* bytes = static_cast<unsigned char*>(buffer);
    std::size_t done = 0;
    while (done < count) {
        const auto wanted = static_cast<unsigned>(std::min(count - done, kChunk));
        const int got = gzread(file_, bytes + done, wanted);
        if (got <= 0) break;
        done += static_cast<std::size_t>(got);
    }
    return done;
}

}  // namespace superray
