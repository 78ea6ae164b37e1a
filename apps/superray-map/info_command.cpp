// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/map_info.h>
#include <superray/maps/map_factory.h>

#include <iostream>
#include <memory>

#include "commands.h"

namespace superray {

Command declareInfo(CLI::App& app) {
    struct Arguments {
        std::string map;
        bool json = false;
    };
    auto arguments = std::make_shared<Arguments>();
    app.footer(
        "The digest depends on resolution, known cells and their values, and on nothing\n"
        "else: maps with equal digests have equal contents, whatever their class.\n\n"
        "Examples:\n"
        "  superray-map info drive.srmap\n"
        "  superray-map info drive.srmap --json | jq -r .digest\n");
    app.add_option("MAP", arguments->map, "Map: .srmap, .ot or .bt")
        ->required()
        ->type_name("FILE");
    app.add_flag("--json", arguments->json, "One JSON object");
    return [arguments] {
        const auto map = loadMap(arguments->map);
        const auto& info = dynamic_cast<const SuperRayMapInterface&>(*map);
        std::cout << (arguments->json ? infoAsJson(info, arguments->map)
                                      : infoAsText(info, arguments->map));
        return int{kSuccess};
    };
}

}  // namespace superray
