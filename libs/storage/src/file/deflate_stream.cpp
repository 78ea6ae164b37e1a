// SPDX-License-Identifier: BSD-3-Clause
#include "file/deflate_stream.h"

#include <superray/storage/map_file_error.h>

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace superray {
namespace {

constexpr std::size_t kMaxStep = std::numeric_limits<uInt>::max();

[[noreturn]] void fail(const char* what) {
    throw MapFileError(std::string("zlib: ") + what);
}

}  // namespace

std::uint32_t crc32Of(const std::uint8_t* data, std::size_t size, std::uint32_t previous) {
    // Of no bytes at no address zlib says 0, whatever came before.
    return size == 0 ? previous : static_cast<std::uint32_t>(crc32_z(previous, data, size));
}

DeflateStream::DeflateStream() : z_(std::make_unique<z_stream_s>()) {
    // Level 1: half the time of the default level for maps a few percent larger.
    if (deflateInit(z_.get(), Z_BEST_SPEED) != Z_OK) fail("cannot start deflating");
}
DeflateStream::~DeflateStream() {
    deflateEnd(z_.get());
}

void DeflateStream::run(int flush) {
    do {
        z_->next_out = buffer_.data();
        z_->avail_out = static_cast<uInt>(buffer_.size());
        deflate(z_.get(), flush);
        out_.insert(out_.end(), buffer_.data(),
                    buffer_.data() + (buffer_.size() - z_->avail_out));
    } while (z_->avail_out == 0);
}

void DeflateStream::write(const std::uint8_t* data, std::size_t size) {
    while (size > 0) {
        const std::size_t step = std::min(size, kMaxStep);
        z_->next_in = const_cast<Bytef*>(data);
        z_->avail_in = static_cast<uInt>(step);
        run(Z_NO_FLUSH);
        data += step;
        size -= step;
    }
}

Bytes DeflateStream::finish() {
    run(Z_FINISH);
    return std::move(out_);
}

InflateStream::InflateStream(const std::uint8_t* data, std::size_t size)
    : z_(std::make_unique<z_stream_s>()), data_(data), left_(size) {
    if (inflateInit(z_.get()) != Z_OK) fail("cannot start inflating");
}
InflateStream::~InflateStream() {
    inflateEnd(z_.get());
}

bool InflateStream::refill() {
    begin_ = end_ = 0;
    while (!ended_ && end_ == 0) {
        const std::size_t step = std::min(left_, kMaxStep);
        z_->next_in = const_cast<Bytef*>(data_);
        z_->avail_in = static_cast<uInt>(step);
        z_->next_out = buffer_.data();
        z_->avail_out = static_cast<uInt>(buffer_.size());
        const int result = inflate(z_.get(), Z_NO_FLUSH);
        const std::size_t used = step - z_->avail_in;
        data_ += used;
        left_ -= used;
        end_ = buffer_.size() - z_->avail_out;
        if (result == Z_STREAM_END)
            ended_ = true;
        else if (result != Z_OK)
            fail(result == Z_BUF_ERROR ? "deflated data end too early"
                                       : "corrupt deflated data");
    }
    return end_ > 0;
}

void InflateStream::read(std::uint8_t* to, std::size_t size) {
    while (size > 0) {
        if (begin_ == end_ && !refill()) fail("inflated data end too early");
        const std::size_t step = std::min(size, end_ - begin_);
        std::copy_n(buffer_.data() + begin_, step, to);
        begin_ += step;
        to += step;
        size -= step;
    }
}

void InflateStream::requireEnd() {
    if (begin_ != end_ || refill()) fail("inflated data are longer than declared");
    if (left_ != 0) fail("bytes after the end of the deflated data");
}

}  // namespace superray
