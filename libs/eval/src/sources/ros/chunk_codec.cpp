// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/chunk_codec.h"

#include <superray/eval/input_error.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>

#include "sources/ros/byte_cursor.h"

#if SUPERRAY_HAVE_BZIP2
#include <bzlib.h>
#endif
#if SUPERRAY_HAVE_LZ4
#include <lz4frame.h>
#endif

namespace superray {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;  // recorders write some MiB
using Block = std::array<char, std::size_t{1} << 16>;

[[noreturn]] void failDamaged(std::string_view codec) {
    throw MalformedBytes("its " + std::string(codec) + " data are damaged");
}

/// Takes what a codec made, up to the size that was told.
class Output {
 public:
    explicit Output(std::uint64_t size) : size_(size) {}
    void add(const char* bytes, std::size_t count) {
        if (count > size_ - out_.size())
            throw MalformedBytes("compressed data have more than the " + std::to_string(size_) +
                                 " bytes that are told");
        out_.append(bytes, count);
    }
    std::string finish() {
        if (out_.size() != size_)
            throw MalformedBytes("compressed data have " + std::to_string(out_.size()) +
                                 " bytes, " + std::to_string(size_) + " are told");
        return std::move(out_);
    }

 private:
    std::uint64_t size_;
    std::string out_;
};

std::string unpackZstd(std::string_view packed, std::uint64_t size) {
    const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                          ZSTD_freeDCtx);
    if (!context) throw std::bad_alloc();
    Output out(size);
    Block block;
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    std::size_t wanted = 1;
    while (wanted != 0) {
        ZSTD_outBuffer made{block.data(), block.size(), 0};
        const std::size_t before = in.pos;
        wanted = ZSTD_decompressStream(context.get(), &made, &in);
        const bool stands = in.pos == before && made.pos == 0 && wanted != 0;
        if (ZSTD_isError(wanted) != 0 || stands) failDamaged("zstd");
        out.add(block.data(), made.pos);
    }
    if (in.pos != in.size) failDamaged("zstd");
    return out.finish();
}

#if SUPERRAY_HAVE_LZ4
std::string unpackLz4(std::string_view packed, std::uint64_t size) {
    LZ4F_dctx* raw = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0)
        throw std::bad_alloc();
    const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(
        raw, LZ4F_freeDecompressionContext);
    Output out(size);
    Block block;
    std::size_t at = 0, wanted = 1;
    while (wanted != 0) {
        std::size_t used = packed.size() - at, made = block.size();
        wanted = LZ4F_decompress(context.get(), block.data(), &made, packed.data() + at, &used,
                                 nullptr);
        const bool stands = used == 0 && made == 0 && wanted != 0;
        if (LZ4F_isError(wanted) != 0 || stands) failDamaged("lz4");
        out.add(block.data(), made);
        at += used;
    }
    if (at != packed.size()) failDamaged("lz4");
    return out.finish();
}
#endif

#if SUPERRAY_HAVE_BZIP2
std::string unpackBzip2(std::string_view packed, std::uint64_t size) {
    bz_stream stream{};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
    const std::unique_ptr<bz_stream, int (*)(bz_stream*)> closer(&stream, BZ2_bzDecompressEnd);
    std::string in(packed);  // bzlib's input is not const
    stream.next_in = in.data();
    stream.avail_in = static_cast<unsigned>(in.size());
    Output out(size);
    Block block;
    for (int state = BZ_OK; state != BZ_STREAM_END;) {
        stream.next_out = block.data();
        stream.avail_out = static_cast<unsigned>(block.size());
        const unsigned before = stream.avail_in;
        state = BZ2_bzDecompress(&stream);
        const std::size_t made = block.size() - stream.avail_out;
        const bool stands = state == BZ_OK && made == 0 && stream.avail_in == before;
        if ((state != BZ_OK && state != BZ_STREAM_END) || stands) failDamaged("bz2");
        out.add(block.data(), made);
    }
    if (stream.avail_in != 0) failDamaged("bz2");
    return out.finish();
}
#endif

#if !SUPERRAY_HAVE_LZ4 || !SUPERRAY_HAVE_BZIP2
[[noreturn]] void failMissing(const char* codec, const char* package) {
    throw InputError("its chunks are compressed by " + std::string(codec) +
                     ", which this program was built without: install " + package +
                     " and build it again");
}
#endif

}  // namespace

std::string decompressChunk(std::string_view codec, std::string_view packed,
                            std::uint64_t size) {
    if (size > kMostBytes)
        throw MalformedBytes("a chunk tells " + std::to_string(size) +
                             " bytes; at most 1 GiB is read");
    if (packed.size() > std::numeric_limits<unsigned>::max())
        throw MalformedBytes("a compressed chunk has more than 4 GiB");
    if (codec == "zstd") return unpackZstd(packed, size);
#if SUPERRAY_HAVE_LZ4
    if (codec == "lz4") return unpackLz4(packed, size);
#else
    if (codec == "lz4") failMissing("lz4", "liblz4-dev");
#endif
#if SUPERRAY_HAVE_BZIP2
    if (codec == "bz2") return unpackBzip2(packed, size);
#else
    if (codec == "bz2") failMissing("bz2", "libbz2-dev");
#endif
    throw MalformedBytes("its chunks have the unknown compression '" + std::string(codec) +
                         "'");
}

}  // namespace superray
