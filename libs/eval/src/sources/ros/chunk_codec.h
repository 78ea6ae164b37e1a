// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file chunk_codec.h
/// The compression of chunks in ROS recordings.

#include <cstdint>
#include <string>
#include <string_view>

namespace superray {

/// Compressed data as they were. Memory grows with what is really there.
/// \param codec "bz2", "lz4" (frames) or "zstd"
/// \param size what the recording says that they have [bytes]
/// \throws MalformedBytes if they are damaged, or of another size
/// \throws InputError naming the package, if this program was built without the codec
std::string decompressChunk(std::string_view codec, std::string_view packed,
                            std::uint64_t size);

}  // namespace superray
