// SPDX-License-Identifier: BSD-3-Clause
#include "sources/folders/depth_image.h"

#include <png.h>
#include <superray/eval/input_error.h>

#include <csetjmp>
#include <cstdio>
#include <memory>
#include <vector>

namespace superray {
namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

/// What libpng says; it leaves a reader by a long jump, which must cross no C++ object that
/// has a destructor.
struct Decoder {
    std::string message;
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::uint32_t columns = 0, rows = 0;
    int depth = 0, colour = 0;

    ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }

    static void onError(png_structp png, png_const_charp text) {
        static_cast<Decoder*>(png_get_error_ptr(png))->message = text;
        png_longjmp(png, 1);
    }
    static void onWarning(png_structp, png_const_charp) {}

    bool readHeader(std::FILE* file) {
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_init_io(png, file);
        png_read_info(png, info);
        columns = png_get_image_width(png, info);
        rows = png_get_image_height(png, info);
        depth = png_get_bit_depth(png, info);
        colour = png_get_color_type(png, info);
        return true;
    }
    bool readRows(png_bytep* rowPointers) {
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_set_swap(png);  // PNG is big endian
        png_read_image(png, rowPointers);
        png_read_end(png, nullptr);
        return true;
    }
};

}  // namespace

mrpt::math::CMatrixDynamic<std::uint16_t> readDepthPng(const std::string& path) {
    requireRegularFile(path);
    const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
    if (!file) throw InputError(path + ": cannot be opened for reading");
    Decoder decoder;
    decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, Decoder::onError,
                                         Decoder::onWarning);
    decoder.info = decoder.png != nullptr ? png_create_info_struct(decoder.png) : nullptr;
    if (decoder.info == nullptr) throw std::bad_alloc();
    constexpr std::uint32_t kLargest = 16384;
    constexpr std::size_t kMostChunk = 8'000'000;  // bytes, of a text or a profile
    png_set_user_limits(decoder.png, kLargest, kLargest);
    png_set_chunk_malloc_max(decoder.png, kMostChunk);
    const auto fail = [&](const std::string& why) {
        throw InputError(path + ": is not a whole depth image: " + why);
    };
    if (!decoder.readHeader(file.get())) fail(decoder.message);
    if (decoder.depth != 16 || decoder.colour != PNG_COLOR_TYPE_GRAY)
        fail("it must be a PNG of one channel of 16 bits");
    std::vector<std::uint16_t> values(std::size_t{decoder.columns} * decoder.rows);
    std::vector<png_bytep> rowPointers(decoder.rows);
    for (std::size_t r = 0; r < decoder.rows; ++r)
        rowPointers[r] = reinterpret_cast<png_bytep>(&values[r * decoder.columns]);
    if (!decoder.readRows(rowPointers.data())) fail(decoder.message);
    mrpt::math::CMatrixDynamic<std::uint16_t> image(static_cast<int>(decoder.rows),
                                                    static_cast<int>(decoder.columns));
    std::copy(values.begin(), values.end(), image.data());
    return image;
}

}  // namespace superray
