// SPDX-License-Identifier: BSD-3-Clause
#include "files/decoder.h"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>

namespace superray {
namespace {

constexpr std::array<unsigned char, 2> kGzipMagic = {0x1f, 0x8b};
constexpr std::array<unsigned char, 4> kZstdMagic = {0x28, 0xb5, 0x2f, 0xfd};

template <std::size_t N>
bool startsWith(const unsigned char* bytes, std::size_t count,
                const std::array<unsigned char, N>& magic) {
    return count > 0 && std::memcmp(bytes, magic.data(), std::min(count, N)) == 0;
}

/// What is not compressed passes through.
class PlainDecoder final : public Decoder {
 public:
    std::size_t decode(InputBytes& input, unsigned char* out, std::size_t capacity) override {
        const std::size_t count = std::min(input.count, capacity);
        if (count > 0) std::memcpy(out, input.next, count);
        input = {input.next + count, input.count - count};
        return count;
    }
    bool atBorder() const override { return true; }
};

/// Members of gzip, one after the other; zeros may follow the last one (as on
/// tapes, and as gzip itself lets pass).
class GzipDecoder final : public Decoder {
 public:
    GzipDecoder() {
        constexpr int kGzipWithLargestWindow = 16 + MAX_WBITS;
        if (inflateInit2(&stream_, kGzipWithLargestWindow) != Z_OK) throw std::bad_alloc();
    }
    ~GzipDecoder() override { inflateEnd(&stream_); }
    GzipDecoder(const GzipDecoder&) = delete;
    GzipDecoder& operator=(const GzipDecoder&) = delete;

    std::size_t decode(InputBytes& input, unsigned char* out, std::size_t capacity) override {
        std::size_t done = 0;
        while (error_.empty() && done < capacity && (input.count > 0 || pendingOutput_)) {
            if (betweenMembers_ && !startMember(input)) continue;
            done += inflateSome(input, out + done, capacity - done);
        }
        return done;
    }
    bool atBorder() const override { return betweenMembers_; }

 private:
    /// False if there is no member to start here.
    bool startMember(InputBytes& input) {
        if (members_ > 0 && *input.next == 0) {
            padded_ = true;
            ++input.next, --input.count;
            return false;
        }
        if (padded_ || (members_ > 0 && *input.next != kGzipMagic[0])) {
            error_ = "after the end of the gzip data there are bytes that are none";
            return false;
        }
        inflateReset(&stream_);
        betweenMembers_ = false;
        return true;
    }

    std::size_t inflateSome(InputBytes& input, unsigned char* out, std::size_t capacity) {
        constexpr std::size_t kMost = std::size_t{1} << 30;  // zlib counts in 32 bits
        stream_.next_in = const_cast<unsigned char*>(input.next);
        stream_.avail_in = static_cast<uInt>(std::min(input.count, kMost));
        stream_.next_out = out;
        stream_.avail_out = static_cast<uInt>(std::min(capacity, kMost));
        const uInt inputBefore = stream_.avail_in, outputBefore = stream_.avail_out;
        const int code = inflate(&stream_, Z_NO_FLUSH);
        const std::size_t consumed = inputBefore - stream_.avail_in;
        input = {input.next + consumed, input.count - consumed};
        pendingOutput_ = code == Z_OK && stream_.avail_out == 0;
        if (code == Z_STREAM_END) {
            betweenMembers_ = true;
            ++members_;
        } else if (code != Z_OK && code != Z_BUF_ERROR) {
            error_ = "the gzip data are damaged (" +
                     std::string(stream_.msg != nullptr ? stream_.msg : zError(code)) + ")";
        }
        return outputBefore - stream_.avail_out;
    }

    z_stream stream_{};
    std::uint64_t members_ = 0;
    bool betweenMembers_ = true;
    bool padded_ = false;
    bool pendingOutput_ = false;  ///< zlib may hold output without needing input
};

/// Frames of zstd, one after the other. The window is limited as in zstd itself, to
/// 128 MiB: a frame that asks for more (`zstd --long=28` and up) could ask for any
/// amount of memory.
class ZstdDecoder final : public Decoder {
 public:
    ZstdDecoder() : stream_(ZSTD_createDCtx()) {
        if (stream_ == nullptr) throw std::bad_alloc();
    }
    ~ZstdDecoder() override { ZSTD_freeDCtx(stream_); }
    ZstdDecoder(const ZstdDecoder&) = delete;
    ZstdDecoder& operator=(const ZstdDecoder&) = delete;

    std::size_t decode(InputBytes& input, unsigned char* out, std::size_t capacity) override {
        ZSTD_outBuffer output{out, capacity, 0};
        ZSTD_inBuffer source{input.next, input.count, 0};
        while (error_.empty() && output.pos < capacity &&
               (source.pos < source.size || pendingOutput_)) {
            const std::size_t result = ZSTD_decompressStream(stream_, &output, &source);
            if (ZSTD_isError(result)) {
                error_ = describe(result);
                break;
            }
            atBorder_ = result == 0;
            frames_ += atBorder_;
            pendingOutput_ = !atBorder_ && output.pos == capacity;
        }
        input = {input.next + source.pos, input.count - source.pos};
        return output.pos;
    }
    bool atBorder() const override { return atBorder_; }

 private:
    std::string describe(std::size_t result) const {
        const auto code = ZSTD_getErrorCode(result);
        if (code == ZSTD_error_frameParameter_windowTooLarge)
            return "the zstd data need a window of more than 128 MiB; compress them with "
                   "less: zstd -d --long=31 <IN | zstd >OUT";
        if (code == ZSTD_error_prefix_unknown && atBorder_ && frames_ > 0)
            return "after the end of the zstd data there are bytes that are none";
        if (code == ZSTD_error_checksum_wrong)
            return "the zstd data are damaged (their checksum is another)";
        return "the zstd data are damaged (" + std::string(ZSTD_getErrorName(result)) + ")";
    }

    ZSTD_DCtx* stream_;
    std::uint64_t frames_ = 0;
    bool atBorder_ = false;
    bool pendingOutput_ = false;  ///< zstd may hold output without needing input
};

}  // namespace

Compression recognise(const unsigned char* bytes, std::size_t count) {
    if (startsWith(bytes, count, kGzipMagic)) return Compression::gzip;
    if (startsWith(bytes, count, kZstdMagic)) return Compression::zstd;
    return Compression::none;
}

std::unique_ptr<Decoder> makeDecoder(Compression compression) {
    switch (compression) {
        case Compression::gzip:
            return std::make_unique<GzipDecoder>();
        case Compression::zstd:
            return std::make_unique<ZstdDecoder>();
        case Compression::none:
            break;
    }
    return std::make_unique<PlainDecoder>();
}

}  // namespace superray
