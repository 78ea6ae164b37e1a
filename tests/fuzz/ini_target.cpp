// SPDX-License-Identifier: BSD-3-Clause
// Configuration files of maps, and the options text of native files.

#include <superray/eval/input_error.h>
#include <superray/eval/map_request.h>
#include <superray/maps/options.h>

#include <stdexcept>

#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    return {
        "[map]\nsuperRayGridMap2D_count = 1\n[map_superRayGridMap2D_00_creationOpts]\n"
        "resolution = 0.2\n[map_superRayGridMap2D_00_insertOpts]\nmaxrange = 5 // m\n",
        "[map_creationOpts]\nresolution = 0.1\n[map_insertOpts]\nprobHit = 0.8\n",
        TMapOptions().toText()};
}

void run(const std::string& input) {
    MapRequest request;
    request.configFile = asFile(input, "input.ini");
    request.section = "map";
    try {
        makeMap(request);
    } catch (const std::exception&) {  // InputError, or MRPT's own
    }
    try {
        TMapOptions().fromText(input);
    } catch (const std::invalid_argument&) {
    }
}

}  // namespace superray::fuzz
