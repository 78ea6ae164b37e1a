// SPDX-License-Identifier: BSD-3-Clause
// The native file, and the cells in it, 2D and 3D, into every storage.

#include <superray/storage/map_file.h>

#include "fuzz/target.h"

namespace superray::fuzz {
namespace {

constexpr MapFileLimits kLimits{std::uint64_t{1} << 20, std::uint64_t{64} << 20};

template <int Dim>
void decode(const MapFile& file) {
    for (const auto type : {StorageType::blockGrid, StorageType::tree}) {
        const auto map = makeStorage<Dim>(type, CellGeometry<Dim>(file.header.resolution));
        try {
            decodeCells<Dim>(file.cells.data(), file.cells.size(), *map, kLimits);
            contentDigest<Dim>(*map);
        } catch (const MapFileError&) {
        }
    }
}

}  // namespace

std::vector<std::string> seeds() {
    return {testData("format_v1_2d.srmap"), testData("format_v1_3d.srmap")};
}

void run(const std::string& input) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(input.data());
    try {
        const MapFile file = parseMapFile(data, input.size(), "input");
        if (file.header.dimension == 2) decode<2>(file);
        if (file.header.dimension == 3) decode<3>(file);
    } catch (const MapFileError&) {
    } catch (const std::invalid_argument&) {  // e.g. a resolution of 1e-300 m
    }
}

}  // namespace superray::fuzz
