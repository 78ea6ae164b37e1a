// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/map_compare.h>

#include <iostream>
#include <memory>

#include "commands.h"

namespace superray {

Command declareCompare(CLI::App& app) {
    struct Arguments {
        std::string a, b;
        bool json = false;
    };
    auto arguments = std::make_shared<Arguments>();
    app.footer(
        "Reads .srmap, .ot and .bt. Log-odds are equal only if all their bits are. A .bt\n"
        "file has no log-odds: with one, cells are compared as occupied or free.\n\n"
        "Exit code: 0 identical, 1 different, 2 error.\n\n"
        "Example:\n"
        "  superray-map compare drive.srmap drive.ot && echo same\n");
    app.add_option("A", arguments->a, "Map")->required()->type_name("FILE");
    app.add_option("B", arguments->b, "Map to compare with it")->required()->type_name("FILE");
    app.add_flag("--json", arguments->json, "One JSON object instead of text");
    return [arguments] {
        const MapDifference difference = compareMapFiles(arguments->a, arguments->b);
        std::cout << (arguments->json ? describeAsJson(difference) : describe(difference));
        return int{difference.identical() ? kSuccess : kDifferent};
    };
}

}  // namespace superray
