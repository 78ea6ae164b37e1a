// SPDX-License-Identifier: BSD-3-Clause
// MRPT streams of our maps. The first byte chooses the class, the rest is its data.

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <array>

#include "fuzz/target.h"

namespace superray::fuzz {
namespace {

using mrpt::serialization::CSerializable;

std::array<CSerializable::Ptr, 6> maps() {
    return {CSuperRayGridMap2D::Create(),   CSuperRayGridMap3D::Create(),
            CSuperRayOctoMap::Create(),     CSuperRayQuadMap::Create(),
            CSuperRayPointsMap2D::Create(), CSuperRayPointsMap3D::Create()};
}

mrpt::obs::CObservation2DRangeScan scan() {
    mrpt::obs::CObservation2DRangeScan s;
    s.aperture = 3;
    s.resizeScanAndAssign(31, 1.0f, true);
    return s;
}

/// How streams hold an object, without its data.
std::string headerOf(const CSerializable& object) {
    mrpt::io::CMemoryStream memory;
    mrpt::serialization::archiveFrom(memory) << object;
    const std::string bytes(static_cast<const char*>(memory.getRawBufferData()),
                            static_cast<std::size_t>(memory.getTotalBytesCount()));
    return bytes.substr(0, 2 + (static_cast<unsigned char>(bytes[0]) & 0x7Fu));
}

}  // namespace

std::vector<std::string> seeds() {
    std::vector<std::string> result;
    char number = 0;
    for (const auto& object : maps()) {
        auto& map = dynamic_cast<mrpt::maps::CMetricMap&>(*object);
        map.insertObservation(scan());
        mrpt::io::CMemoryStream memory;
        mrpt::serialization::archiveFrom(memory) << *object;
        const std::string bytes(static_cast<const char*>(memory.getRawBufferData()),
                                static_cast<std::size_t>(memory.getTotalBytesCount()));
        result.push_back(number++ + bytes.substr(headerOf(*object).size()));
    }
    return result;
}

void run(const std::string& input) {
    static const auto all = maps();
    if (input.empty()) return;
    const auto& object = all[static_cast<unsigned char>(input[0]) % all.size()];
    const std::string bytes = headerOf(*object) + input.substr(1);
    mrpt::io::CMemoryStream memory;
    memory.Write(bytes.data(), bytes.size());
    memory.Seek(0);
    try {
        mrpt::serialization::archiveFrom(memory).ReadObject();
    } catch (const std::exception&) {  // MRPT wraps all errors
    }
}

}  // namespace superray::fuzz
