// SPDX-License-Identifier: BSD-3-Clause
#include <png.h>
#include <superray/maps/png_output.h>
#include <superray/storage/atomic_file.h>

#include <cstdint>
#include <vector>

namespace superray {

void writePng(const mrpt::img::CImage& image, const std::string& path) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.getWidth());
    png.height = static_cast<png_uint_32>(image.getHeight());
    png.format = image.isColor() ? PNG_FORMAT_BGR : PNG_FORMAT_GRAY;
    const auto* pixels = image.ptrLine<std::uint8_t>(0);
    const auto stride = static_cast<png_int_32>(image.getRowStride());
    std::vector<char> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
    png_alloc_size_t size = bytes.size();
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, stride, nullptr) == 0)
        throw MapFileError("cannot write " + path + ": " + png.message);
    writeFileAtomically(path, {bytes.data(), size});
}

}  // namespace superray
